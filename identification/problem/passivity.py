"""Passivity of friction as a constraint of the optimiser: `Problem` in, constraint in SLSQP's form out.

A friction law may state an expression that must not be negative; LuGre states σ2 ≥ σ1·(Fs − Fc)/Fc. Measured joints
need not obey it, so fits apply the constraint on request only.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from haptid.identification.problem.residuals import Problem
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import law_named


@cache
def _formula(friction: str) -> tuple[tuple[str, ...], Callable[..., Any]]:
    """Return the parameter ids in a law's constraint, and a function of their values for constraint and gradient."""
    expression = law_named(friction).passivity
    if expression is None:
        return (), lambda: ()
    symbols = sorted(expression.free_symbols, key=str)
    slopes = [sp.diff(expression, s) for s in symbols]
    return tuple(s.name for s in symbols), sp.lambdify(symbols, (expression, *slopes), "math", cse=True)


def margin(equations: Equations, theta: Array) -> tuple[Array, Array]:
    """Evaluate the passivity constraint of every joint whose friction law states one.

    Parameters
    ----------
    equations
        Equations of the joints.
    theta
        Parameters, shape (n_p,).

    Returns
    -------
    value : ndarray, shape (n,)
        Constraint expressions, passive where not negative; n counts the joints whose law states a constraint.
    gradient : ndarray, shape (n, n_p)
        Derivatives by the parameters.
    """
    place = {q.id: i for i, q in enumerate(equations.parameters)}
    values, gradients = [], []
    for suffix, friction in zip(id_suffixes(equations.joints), equations.friction, strict=True):
        ids, formula = _formula(friction)
        if not ids:
            continue
        columns = [place[f"{id}{suffix}"] for id in ids]
        value, *slopes = formula(*theta[columns])
        row = np.zeros(theta.size)
        row[columns] = slopes
        values.append(value)
        gradients.append(row)
    return np.array(values), np.array(gradients).reshape(len(values), theta.size)


def passivity(problem: Problem, point: Callable[[Array], Array], tangent: Callable[[Array], Array]) -> dict[str, Any]:
    """Build the passivity constraint for SciPy's SLSQP.

    Parameters
    ----------
    problem
        Problem with the unknowns x.
    point
        Map from the optimiser's variables w to the unknowns x, both shape (n,).
    tangent
        dx/dw, shape (n, n).

    Returns
    -------
    dict
        Inequality constraint with value and Jacobian as functions of w.
    """
    parametrisation, n = problem.parametrisation, problem.n_parameters

    def value(w: Array) -> Array:
        return margin(parametrisation.equations, problem.theta(point(w)))[0]

    def jacobian(w: Array) -> Array:
        theta = problem.theta(point(w))
        columns = margin(parametrisation.equations, theta)[1][:, list(parametrisation.free)] * parametrisation.slope(
            theta
        )
        return np.pad(columns, ((0, 0), (0, problem.size - n))) @ tangent(w)

    return {"type": "ineq", "fun": value, "jac": jacobian}
