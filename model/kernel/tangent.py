"""First-order sensitivities of the generated C: S' = J·S + ∂f/∂p, by exact derivatives of the formulas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from haptid.model.equations.equations import Equations
from haptid.model.kernel.printing import of_reals, slopes
from haptid.model.kernel.text import assignments


def tangent_columns(equations: Equations, starts: Iterable[int] | None = None) -> tuple[str, ...]:
    """Return the names of the sensitivity columns.

    Parameters
    ----------
    equations
        Equations of the kernel.
    starts
        Indices of the states whose initial values have columns; all where None.

    Returns
    -------
    tuple of str
        Ids of the parameters, then ``<state>_0`` of the initial states; empty for implicit equations.
    """
    if equations.mass_matrix is not None:
        return ()
    states = equations.states if starts is None else [equations.states[k] for k in starts]
    return (*(x.id for x in equations.parameters), *(f"{s.id}_0" for s in states))


def _tangent_function(e: Equations, head: str, target: str, expressions: Sequence[sp.Expr]) -> str:
    """Value in column 0; J·S + ∂/∂p in the others."""
    targets, values, products = [], [], []
    for i, f in enumerate(expressions):
        targets.append(f"{target}[{i}][0]")
        values.append(of_reals(f))
        terms = []
        for k, derivative in enumerate(slopes(f, [s.symbol for s in e.states])):
            if derivative != 0:
                targets.append(f"real J{i}_{k}")
                values.append(derivative)
                terms.append(f"J{i}_{k} * X[{k}][c]")
        products.append(f"    for (int c = 1; c <= HK_NC; c++) {target}[{i}][c] = {' + '.join(terms) or 'K(0.0)'};")
        for k, derivative in enumerate(slopes(f, [q.symbol for q in e.parameters])):
            if derivative != 0:
                targets.append(f"real P{i}_{k}")
                values.append(derivative)
                products.append(f"    {target}[{i}][{1 + k}] = {target}[{i}][{1 + k}] + P{i}_{k};")
    body = assignments(e, targets, values, "X[{}][0]")
    return f"{head} {{\n{body}\n" + "\n".join(products) + "\n}"


def tangent_source(e: Equations) -> str:
    """Print the C functions that evaluate right-hand sides and outputs with their sensitivities.

    Parameters
    ----------
    e
        Explicit equations without definitions.

    Returns
    -------
    str
        C source of ``hk_eval_tangent`` and ``hk_out_tangent``; column 0 holds values, the others J·S + ∂/∂p.
    """
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
