"""C source of a kernel, generated from `Equations`: functions of the physics, then the fixed stepper."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import combinations

import sympy as sp

from model.equations import TIME, Equations
from model.kernel.printing import CPrinter, check_functions, differentiate

DEFAULT_STEP = 5e-4
"""Inner step [s]: the one of Tam, Kubica and Wang (2005), section IV."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """Generated C source with the names of its arrays.

    ``columns`` are the tangent's directions: the parameters, then the initial states; empty where there is no tangent.
    """

    equations: Equations
    source: str
    digest: str
    columns: tuple[str, ...]
    step: float = DEFAULT_STEP


def template(name: str) -> str:
    """Return the text of a fixed part of the kernel."""
    return resources.files("model.kernel").joinpath(name).read_text(encoding="utf-8")


def _names(equations: Equations, state: str) -> dict[str, str]:
    names = {TIME.name: "t"}
    names.update({x.id: state.format(i) for i, x in enumerate(equations.states)})
    names.update({x.id: f"u[{i}]" for i, x in enumerate(equations.inputs)})
    names.update({x.id: f"p[{i}]" for i, x in enumerate(equations.parameters)})
    return names


def _needed(
    definitions: Sequence[tuple[sp.Symbol, sp.Expr]], expressions: Iterable[sp.Expr]
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Those of the definitions that the expressions use, directly or through others, in order."""
    wanted: set[sp.Symbol] = set().union(*(sp.sympify(e).free_symbols for e in expressions), set())
    kept = []
    for symbol, expression in reversed(definitions):
        if symbol in wanted:
            wanted |= expression.free_symbols
            kept.append((symbol, expression))
    return kept[::-1]


def assignments(equations: Equations, targets: Sequence[str], expressions: Sequence[sp.Expr], state: str = "x[{}]") -> str:
    """Write assignments ``target = expression;`` with common subexpressions taken out."""
    check_functions(expressions)
    printer = CPrinter(_names(equations, state))
    lines = [
        f"real {printer.doprint(s)} = K(0.0) + {printer.doprint(e)};"
        for s, e in _needed(equations.definitions, expressions)
    ]
    common, reduced = sp.cse([sp.sympify(e) for e in expressions], symbols=sp.numbered_symbols("e_"), order="none")
    lines += [f"real {s.name} = K(0.0) + {printer.doprint(e)};" for s, e in common]
    lines += [f"{target} = K(0.0) + {printer.doprint(e)};" for target, e in zip(targets, reduced, strict=True)]
    return "\n".join(f"    {line}" for line in lines)


def coupling(equations: Equations) -> sp.Expr:
    """Σ |Jᵢⱼ·Jⱼᵢ| over pairs of states plus Σ (Jᵢᵢ + aᵢ)²: the square of the stiffness that the rates leave [1/s²]."""
    if equations.mass_matrix is not None:
        return sp.S.Zero
    terms = [
        (differentiate(f, state.symbol) + rate) ** 2
        for f, rate, state in zip(equations.rhs, equations.rates, equations.states, strict=True)
    ]
    for i, j in combinations(range(len(equations.states)), 2):
        product = differentiate(equations.rhs[i], equations.states[j].symbol) * differentiate(
            equations.rhs[j], equations.states[i].symbol
        )
        if product != 0:
            terms.append(sp.Abs(product))
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
    outputs = assignments(e, [f"Y[{i}][0]" for i in range(len(e.outputs))], [o.expression for o in e.outputs], "X[{}][0]")
    return f"""
static inline void hk_eval_plain(real t, real X[HK_NX][1], const real *u, const real *p, real F[HK_NX][1]) {{
{setup}{assignments(e, targets, expressions, "X[{}][0]")}{finish}
}}
static inline void hk_out_plain(real t, real X[HK_NX][1], const real *u, const real *p, real Y[HK_NY][1]) {{
{outputs}
}}"""


def _tangent_function(e: Equations, head: str, target: str, expressions: Sequence[sp.Expr]) -> str:
    """Value in column 0; J·S + ∂/∂p in the others."""
    targets, values, products = [], [], []
    for i, f in enumerate(expressions):
        targets.append(f"{target}[{i}][0]")
        values.append(f)
        terms = []
        for k, state in enumerate(e.states):
            derivative = differentiate(f, state.symbol)
            if derivative != 0:
                targets.append(f"real J{i}_{k}")
                values.append(derivative)
                terms.append(f"J{i}_{k} * X[{k}][c]")
        products.append(f"    for (int c = 1; c <= HK_NC; c++) {target}[{i}][c] = {' + '.join(terms) or 'K(0.0)'};")
        for k, quantity in enumerate(e.parameters):
            derivative = differentiate(f, quantity.symbol)
            if derivative != 0:
                targets.append(f"real P{i}_{k}")
                values.append(derivative)
                products.append(f"    {target}[{i}][{1 + k}] = {target}[{i}][{1 + k}] + P{i}_{k};")
    body = assignments(e, targets, values, "X[{}][0]")
    return f"{head} {{\n{body}\n" + "\n".join(products) + "\n}"


def _tangent(e: Equations) -> str:
    width = "1 + HK_NC"
    arguments = f"(real t, real X[HK_NX][{width}], const real *u, const real *p, real"
    return "\n".join(
        (
            _tangent_function(e, f"static inline void hk_eval_tangent{arguments} F[HK_NX][{width}])", "F", e.rhs),
            _tangent_function(
                e,
                f"static inline void hk_out_tangent{arguments} Y[HK_NY][{width}])",
                "Y",
                [o.expression for o in e.outputs],
            ),
        )
    )


def tangent_columns(equations: Equations) -> tuple[str, ...]:
    """Return the directions of the sensitivities: parameters, then initial states; none for implicit equations."""
    if equations.mass_matrix is not None:
        return ()
    return (*(x.id for x in equations.parameters), *(f"{s.id}_0" for s in equations.states))


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


def generate(equations: Equations, *, tangent: bool = True, step: float = DEFAULT_STEP) -> Kernel:
    """Generate the C source of ``equations``.

    Parameters
    ----------
    tangent
        Whether to generate first-order sensitivities; only explicit equations have them.
    step
        Longest inner step [s].

    Returns
    -------
    Kernel
        One self-contained C99 source; with ``HK_LANES`` defined it is its vectorised form.
    """
    e = equations
    tangent = tangent and e.mass_matrix is None
    rates = [sp.sympify(r) for r in e.rates]
    sizes = {"NX": len(e.states), "NU": len(e.inputs), "NP": len(e.parameters), "NY": len(e.outputs)}
    columns = tangent_columns(e) if tangent else ()
    head = "\n".join(f"#define HK_{k} {v}" for k, v in sizes.items())
    stiff = ", ".join("0" if r == 0 else "1" for r in rates)
    arguments = "(real t, const real *x, const real *u, const real *p"
    rate_targets = [f"a[{i}]" for i in range(len(rates))]
    parts = [
        f"/* {e.title}: generated, do not edit. */",
        template("real.h"),
        head,
        f"#ifndef HK_LANES\n#define HK_NC {len(columns)}\n#endif" if tangent else "",
        f"static const int hk_stiff[HK_NX] = {{{stiff}}};",
        f"static inline void hk_rates{arguments}, real *a) {{\n{assignments(e, rate_targets, rates)}\n}}",
        f"static inline real hk_coupling{arguments}) {{\n{assignments(e, ['real c'], [coupling(e)])}\n    return c;\n}}",
        _plain(e),
        f"#ifdef HK_NC{_indent(_tangent(e))}\n#endif" if tangent else "",
        template("weights.h"),
        _include_stepper("plain", "1"),
        f"#ifdef HK_NC\n{_include_stepper('tangent', '1 + HK_NC')}\n#endif" if tangent else "",
        template("interface.c"),
    ]
    source = "\n".join(parts) + "\n"
    return Kernel(
        equations=e,
        source=source,
        digest=hashlib.sha256(f"{step!r}{source}".encode()).hexdigest()[:16],
        columns=columns,
        step=step,
    )


def _indent(text: str) -> str:
    return "\n" + text
