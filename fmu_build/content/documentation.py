"""``documentation/index.html`` of an FMU: `Interface` and `Provenance` in, HTML out.

The page shows how good the model is, the equations, the variables, and the parameters with provenance and error bars.
"""

from __future__ import annotations

from collections.abc import Mapping

import jinja2
import sympy as sp
from markupsafe import Markup
from sympy.printing.mathml import mathml

from haptid.fmu_build.accuracy.accuracy import FIRST_GUESSES, Accuracy
from haptid.fmu_build.content.accuracy_files import KnownParameter, known_parameters
from haptid.fmu_build.content.accuracy_page import rows_of_digests, rows_of_runs, sentences_of_effects, write_snippet
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.provenance import Provenance
from haptid.fmu_build.description.variables import Variable
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import law_named
from haptid.support.numbers import says_nothing

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("haptid.fmu_build.content", ""),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)


def documentation(
    interface: Interface,
    *,
    text: str,
    linear: bool,
    source: bool,
    provenance: Mapping[str, Provenance],
    accuracy: Accuracy = FIRST_GUESSES,
) -> str:
    """Render the documentation of an FMU.

    Parameters
    ----------
    interface
        Variables and equations of the FMU.
    text
        Description of the model, one line.
    linear
        Whether a host may set the derivatives of the inputs, so that inputs run linearly within a step.
    source
        Whether the FMU carries its C source.
    provenance
        Provenance of every parameter by id; equal sources share a footnote.
    accuracy
        How good the values are.

    Returns
    -------
    str
        HTML with the equations as MathML.
    """
    e = interface.equations
    rows, drawn = known_parameters(interface, accuracy, provenance), accuracy.known.draws
    sources = list(dict.fromkeys(origin.source for origin in provenance.values()))
    return _ENVIRONMENT.get_template("documentation.html.j2").render(
        interface=interface,
        text=text,
        linear=linear,
        source=source,
        notes=e.notes,
        formulas=_formulas(e),
        general=_general(e) if e.definitions else (),
        parameters=[(one, sources.index(one.origin.source) + 1) for one in rows],
        sources=sources,
        accuracy=accuracy,
        draws=0 if drawn is None else len(drawn.values),
        runs=tuple(rows_of_runs(accuracy)),
        effects=tuple(sentences_of_effects(accuracy)),
        digests=tuple(rows_of_digests(accuracy, e.digest)),
        snippet=write_snippet(interface.identifier, interface.of_role("output")[0].name, 2.0),
        identification=interface.identification,
        others=[v for v in interface.variables if v.role != "parameter"],
        held=[v for v in interface.of_role("input") if v.start],
        number=_number,
        error_bar=_error_bar,
        interval=_interval,
        span=_span,
    )


def _general(e: Equations) -> tuple[str, ...]:
    """Return the equations of the whole device in general form, then the formulas of each friction law."""
    laws = [law_named(id) for id in dict.fromkeys(e.friction)]
    if len(laws) == 1:
        torque, *rates = laws[0].formulas
        return (_motion(torque.replace(" + ", " − ")), *rates)
    found = [_motion("friction")]
    for law in laws:
        joints = ", ".join(str(j) for j, id in zip(e.joints, e.friction, strict=True) if id == law.id)
        torque, *rates = law.formulas
        plural = "s" if "," in joints else ""
        found += [f"{law.title} friction of joint{plural} {joints}: {torque}", *rates]
    return tuple(found)


def _motion(friction: str) -> str:
    return f"M(q)·v̇ = Kp·τ − C(q, v)·v − φ(q) − Ks·(q − epos) − {friction} + Jᵀ·f"


def _formulas(e: Equations) -> list[Markup]:
    """Return explicit equations as MathML, empty for a whole device, whose recorded definitions nobody can read."""
    if e.definitions:
        return []
    levels = _stribeck_levels(e)
    rates = zip(e.states, e.rhs, strict=True)
    lines = [(f"<mover>{_math(x.symbol)}<mo>˙</mo></mover>", sp.sympify(f).subs(levels)) for x, f in rates]
    lines += [(_math(g), level) for level, g in levels.items()]
    lines += [(_math(sp.Symbol(o.id)), sp.sympify(o.expression)) for o in e.outputs]
    return [
        Markup(f'<math display="block"><mrow>{left}<mo>=</mo>{_math(f)}</mrow></math>')  # ours
        for left, f in lines
    ]


def _stribeck_levels(e: Equations) -> dict[sp.Expr, sp.Symbol]:
    """Return the Stribeck level g(v) of each joint as the right-hand side has it, and the symbol that replaces it."""
    levels = {}
    for suffix, friction in zip(id_suffixes(e.joints), e.friction, strict=False):
        law, number = law_named(friction), suffix.removeprefix("_")
        if law.level is not None:
            p = {id: sp.Symbol(f"{id}{suffix}", real=True) for id in law.ids}
            levels[law.level(sp.Symbol(f"v{number}", real=True), p)] = sp.Symbol(f"g{suffix}")
    return levels


def _math(expression: sp.Expr) -> str:
    """Return presentation MathML; ids that are words become the letters of the field, exponentials stay on one line."""
    letters = {"inertia": "M", "gravity_cos": "g_c", "gravity_sin": "g_s", "epos": "e"}
    names = {s: sp.Symbol(letters[s.name], real=True) for s in expression.free_symbols if s.name in letters}
    exp = sp.Function("exp")
    return mathml(expression.subs(names).replace(sp.exp, exp), printer="presentation")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _error_bar(one: KnownParameter) -> str:
    v = one.variable
    return "" if one.std is None or says_nothing(one.std, v.minimum, v.maximum) else f"± {one.std:.2g}"


def _interval(one: KnownParameter) -> str:
    """Return the 95 % interval of the draws."""
    return f"{one.quantiles[0]:.6g} … {one.quantiles[-1]:.6g}" if one.quantiles else ""


def _span(v: Variable) -> str:
    return f"{v.minimum:.4g} … {v.maximum:.4g}"
