"""Generate the C source of a kernel: `Equations` in, `Kernel` out.

1. Substitute the definitions into explicit equations, whose derivatives are needed.
2. Print relaxation rates, coupling, right-hand sides and outputs as C functions; with ``tangent`` also their
   sensitivities.
3. Include the fixed stepper once for the plain and once for the tangent form, then the interface.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import resources
from itertools import combinations
from typing import Any

import sympy as sp

from haptid.model.equations.equations import Equations
from haptid.model.kernel.printing import Magnitude, slopes
from haptid.model.kernel.tangent import tangent_columns, tangent_source
from haptid.model.kernel.text import assignments
from haptid.model.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """Generated C source of a kernel.

    Parameters
    ----------
    equations
        Equations in the form that was printed.
    source
        C source.
    digest
        Sixteen hex digits of step and source.
    columns
        Directions of the sensitivities: parameters, then initial states; empty where there are no sensitivities.
    step
        Longest inner step [s].
    """

    equations: Equations
    source: str
    digest: str
    columns: tuple[str, ...]
    step: float = THRESHOLDS.inner_step_s

    @property
    def starts(self) -> list[int]:
        """Indices of the states whose initial values have a column of their own, in the order of the columns."""
        names = [f"{state.id}_0" for state in self.equations.states]
        return [names.index(column) for column in self.columns[len(self.equations.parameters) :]]


def template(name: str) -> str:
    """Return the text of a fixed part of the kernel, by its file name.

    Parameters
    ----------
    name
        Name of a file beside this module.

    Returns
    -------
    str
        Content of the file.
    """
    return resources.files("haptid.model.kernel").joinpath(name).read_text(encoding="utf-8")


def coupling(equations: Equations) -> sp.Expr:
    """Return the squared stiffness that remains beside the relaxation rates.

    Parameters
    ----------
    equations
        Equations with the Jacobian J = ∂f/∂x and relaxation rates a.

    Returns
    -------
    sympy.Expr
        Σ_{i<j} |Jᵢⱼ·Jⱼᵢ| + Σᵢ (Jᵢᵢ + aᵢ)² [1/s²]; 0 for implicit equations.
    """
    if equations.mass_matrix is not None:
        return sp.S.Zero
    J = [slopes(f, [s.symbol for s in equations.states]) for f in equations.rhs]
    terms = [(J[i][i] + rate) ** 2 for i, rate in enumerate(equations.rates)]
    for i, j in combinations(range(len(equations.states)), 2):
        product = J[i][j] * J[j][i]
        if product != 0:
            terms.append(Magnitude(product))
    return sp.Add(*terms)


def _solve(n: int) -> str:
    """Cholesky solution of M v' = h in place of the velocity rows, for a dense symmetric positive definite M."""
    return f"""
    for (int j = 0; j < {n}; j++) {{
        for (int k = 0; k < j; k++) M[j][j] = M[j][j] - M[j][k] * M[j][k];
        M[j][j] = hk_sqrt(M[j][j]);
        for (int i = j + 1; i < {n}; i++) {{
            for (int k = 0; k < j; k++) M[i][j] = M[i][j] - M[i][k] * M[j][k];
            M[i][j] = M[i][j] / M[j][j];
        }}
    }}
    for (int i = 0; i < {n}; i++) {{
        for (int k = 0; k < i; k++) F[{n} + i][0] = F[{n} + i][0] - M[i][k] * F[{n} + k][0];
        F[{n} + i][0] = F[{n} + i][0] / M[i][i];
    }}
    for (int i = {n} - 1; i >= 0; i--) {{
        for (int k = i + 1; k < {n}; k++) F[{n} + i][0] = F[{n} + i][0] - M[k][i] * F[{n} + k][0];
        F[{n} + i][0] = F[{n} + i][0] / M[i][i];
    }}"""


def _plain(e: Equations) -> str:
    targets, expressions, setup, finish = [f"F[{i}][0]" for i in range(len(e.states))], list(e.rhs), "", ""
    if e.mass_matrix is not None:
        n = len(e.joints)
        lower = [(i, j) for i in range(n) for j in range(i + 1)]
        targets += [f"M[{i}][{j}]" for i, j in lower]
        expressions += [e.mass_matrix[i][j] for i, j in lower]
        setup, finish = f"    real M[{n}][{n}];\n", _solve(n)
    outputs = assignments(
        e, [f"Y[{i}][0]" for i in range(len(e.outputs))], [o.expression for o in e.outputs], "X[{}][0]"
    )
    return f"""
HK_INLINE void hk_eval_plain(real t, real X[HK_NX][1], const real *u, const real *p, real F[HK_NX][1]) {{
{setup}{assignments(e, targets, expressions, "X[{}][0]")}{finish}
}}
static inline void hk_out_plain(real t, real X[HK_NX][1], const real *u, const real *p, real Y[HK_NY][1]) {{
{outputs}
}}"""


def _include_stepper(kind: str, width: str) -> str:
    definitions = {
        "HK_W": f"({width})",
        "HK_FN(name)": f"hk_{kind}_##name",
        "HK_EVAL": f"hk_eval_{kind}",
        "HK_OUT": f"hk_out_{kind}",
    }
    before = "\n".join(f"#define {k} {v}" for k, v in definitions.items())
    after = "\n".join(f"#undef {k.partition('(')[0]}" for k in definitions)
    return f"{before}\n{template('stepper.h')}\n{after}"


@dataclass(frozen=True, slots=True)
class _Formulas:
    """Equations that compare equal where their source is the same: values and ranges of parameters are not printed.

    Parameters
    ----------
    printed
        Ids in the order of the arrays, and all formulas.
    equations
        The equations without definitions, or with a mass matrix.
    """

    printed: tuple[Any, ...]
    equations: Equations = field(compare=False)

    @classmethod
    def of(cls, e: Equations) -> _Formulas:
        named = tuple(tuple(x.id for x in group) for group in (e.states, e.inputs, e.parameters, e.outputs))
        outputs = tuple(o.expression for o in e.outputs)
        return cls((named, len(e.joints), e.definitions, e.rhs, e.rates, outputs, e.mass_matrix), e)


def generate(
    equations: Equations,
    *,
    tangent: bool = True,
    starts: tuple[int, ...] | None = None,
    step: float = THRESHOLDS.inner_step_s,
) -> Kernel:
    """Generate the C source of ``equations``.

    Parameters
    ----------
    equations
        Explicit equations, or implicit ones with a mass matrix.
    tangent
        Whether to generate first-order sensitivities; only explicit equations have them.
    starts
        Indices of the states by whose initial values sensitivities are taken; all where None.
    step
        Longest inner step [s].

    Returns
    -------
    Kernel
        One self-contained C source; with ``HK_LANES`` defined it compiles to its vectorised form.
    """
    e = equations if equations.mass_matrix is not None else equations.without_definitions()
    tangent = tangent and e.mass_matrix is None
    columns = tangent_columns(e, starts) if tangent else ()
    source = _print(_Formulas.of(e), len(columns))
    return Kernel(
        equations=e,
        source=source,
        digest=hashlib.sha256(f"{step!r}{source}".encode()).hexdigest()[:16],
        columns=columns,
        step=step,
    )


# The lock postures of a joint share their formulas, and one fit asks for the same kernel several times.
@lru_cache(maxsize=64)
def _print(formulas: _Formulas, columns: int) -> str:
    """Print the C source of explicit equations without definitions, or of implicit ones, with so many sensitivities."""
    e = formulas.equations
    rates = [sp.sympify(r) for r in e.rates]
    sizes = {"NX": len(e.states), "NU": len(e.inputs), "NP": len(e.parameters), "NY": len(e.outputs)}
    head = "\n".join(f"#define HK_{k} {v}" for k, v in sizes.items())
    stiff = ", ".join("0" if r == 0 else "1" for r in rates)
    arguments = "(real t, const real *x, const real *u, const real *p"
    rate_targets = [f"a[{i}]" for i in range(len(rates))]
    stiffness = assignments(e, ["real c"], [coupling(e)])
    parts = [
        "/* Generated from the equations of the model, do not edit. No text of a file stands here. */",
        template("real.h"),
        head,
        f"#ifndef HK_LANES\n#define HK_NC {columns}\n#endif" if columns else "",
        f"static const int hk_stiff[HK_NX] = {{{stiff}}};",
        f"HK_INLINE void hk_rates{arguments}, real *a) {{\n{assignments(e, rate_targets, rates)}\n}}",
        f"HK_INLINE real hk_coupling{arguments}) {{\n{stiffness}\n    return c;\n}}",
        _plain(e),
        f"#ifdef HK_NC\n{tangent_source(e)}\n#endif" if columns else "",
        template("weights.h"),
        _include_stepper("plain", "1"),
        f"#ifdef HK_NC\n{_include_stepper('tangent', '1 + HK_NC')}\n#endif" if columns else "",
        template("subnormals.h"),
        template("interface.c"),
    ]
    return "\n".join(parts) + "\n"
