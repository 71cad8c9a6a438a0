"""Passivity of LuGre friction as a constraint, on request: σ2 ≥ σ1·(Fs − Fc)/Fc (Barabanov & Ortega 2000).

Measured joints need not obey it, so fits leave it out unless asked.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations


def friction_sets(equations: Equations) -> list[tuple[int, int, int, int]]:
    """Return indices of (sigma1, sigma2, Fs, Fc) of every joint that has them."""
    place = {q.id: i for i, q in enumerate(equations.parameters)}
    tails = [name.removeprefix("sigma2") for name in place if name.startswith("sigma2")]
    names = ("sigma1", "sigma2", "Fs", "Fc")
    return [
        (place[f"sigma1{tail}"], place[f"sigma2{tail}"], place[f"Fs{tail}"], place[f"Fc{tail}"])
        for tail in tails
        if all(f"{name}{tail}" in place for name in names)
    ]


def margin(equations: Equations, theta: Array) -> tuple[Array, Array]:
    """Return ln σ2 + ln Fc − ln(σ1·(Fs − Fc) + ε) per joint and its gradient (n_joints, n_p)."""
    sets = friction_sets(equations)
    value, gradient = np.zeros(len(sets)), np.zeros((len(sets), theta.size))
    for k, (s1, s2, fs, fc) in enumerate(sets):
        rise = theta[s1] * (theta[fs] - theta[fc]) + 1e-3 * theta[s2] * theta[fc]
        value[k] = np.log(theta[s2] * theta[fc] / rise)
        gradient[k, s2] = 1.0 / theta[s2] - 1e-3 * theta[fc] / rise
        gradient[k, fc] = 1.0 / theta[fc] - (1e-3 * theta[s2] - theta[s1]) / rise
        gradient[k, s1] = -(theta[fs] - theta[fc]) / rise
        gradient[k, fs] = -theta[s1] / rise
    return value, gradient


def passivity(problem: Problem, point: Callable[[Array], Array], tangent: Callable[[Array], Array]) -> dict[str, Any]:
    """Return the constraint in SLSQP's form, for variables w with x = point(w), dx/dw = tangent(w)."""
    scaling, n = problem.scaling, problem.n_parameters

    def value(w: Array) -> Array:
        return margin(scaling.equations, problem.theta(point(w)))[0]

    def jacobian(w: Array) -> Array:
        theta = problem.theta(point(w))
        columns = margin(scaling.equations, theta)[1][:, list(scaling.free)] * scaling.slope(theta)
        return np.pad(columns, ((0, 0), (0, problem.size - n))) @ tangent(w)

    return {"type": "ineq", "fun": value, "jac": jacobian}
