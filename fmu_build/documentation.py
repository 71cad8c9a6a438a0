"""``documentation/index.html`` of an FMU: equations, variables, parameters with their provenance and error bars."""

from __future__ import annotations

from collections.abc import Mapping

import jinja2
import sympy as sp
from markupsafe import Markup
from sympy.printing.mathml import mathml

from fmu_build.interface import Interface
from fmu_build.provenance import Provenance
from fmu_build.variables import Variable
from model.equations import Equations

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("fmu_build", "templates"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)
GENERAL = (
    "M(q)·v̇ = Kp·τ − C(q, v)·v − φ(q) − Ks·(q − epos) − σ0·z − σ1·ż − σ2·v + Jᵀ·f",
    "ż = v − σ0·|v|/g(v)·z,  g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)",
)


def documentation(
    interface: Interface, *, text: str, python: bool, provenance: Mapping[str, Provenance], notes: tuple[str, ...] = ()
) -> str:
    """Return the page."""
    e = interface.equations
    return _ENVIRONMENT.get_template("documentation.html.j2").render(
        interface=interface,
        text=text,
        python=python,
        notes=(*e.notes, *notes),
        formulas=_formulas(e),
        general=GENERAL if e.definitions else (),
        parameters=[(v, provenance[v.id]) for v in interface.of_role("parameter")],
        others=[v for v in interface.variables if v.role != "parameter"],
        number=_number,
        error_bar=_error_bar,
        span=_span,
    )


def _formulas(e: Equations) -> list[Markup]:
    """Return the explicit equations as MathML; a recorded tape is not for reading."""
    if e.definitions:
        return []
    rates = zip(e.states, e.rhs, strict=True)
    lines = [(f"<mover>{_math(x.symbol)}<mo>˙</mo></mover>", f) for x, f in rates]
    lines += [(_math(sp.Symbol(o.id)), o.expression) for o in e.outputs]
    return [
        Markup(f'<math display="block"><mrow>{left}<mo>=</mo>{_math(sp.sympify(f))}</mrow></math>')  # ours
        for left, f in lines
    ]


def _math(expression: sp.Expr) -> str:
    return mathml(expression, printer="presentation")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _error_bar(entry: Provenance) -> str:
    return "" if entry.std is None else f"± {entry.std:.2g}"


def _span(v: Variable) -> str:
    return f"{v.minimum:.4g} … {v.maximum:.4g}"
