"""What is missing, without a name: the remaining torque as a piecewise linear function of the one variable it lives in.

The function is an effect like any other, −Σ aₖ·hatₖ(x) with hat functions on equidistant knots, fitted jointly with all
parameters; so its values come with standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from discrepancy.solution import Solution, solve
from discrepancy.study import Study
from discrepancy.suggestion import suggestion
from measurement.run import Array, Run
from model.effect import Effect, parameter
from model.effect import q as position
from model.effect import v as velocity
from model.equations import TIME

KNOTS = 8
VARIABLES = {"position_rad": position, "velocity_rad_s": velocity, "time_s": TIME}


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """Remaining torque (KNOTS,) [N m] over ``variable`` less its straight line, its std, and twice the gain in ln L.

    ``suggestion`` is a closed form that follows it, where one was found.
    """

    variable: str
    knots: Array
    torque: Array
    std: Array
    gain: float
    suggestion: str | None = None

    def as_json(self) -> dict[str, object]:
        """Plain lists."""
        return {
            "variable": self.variable, "knots": self.knots.tolist(), "torque_Nm": self.torque.tolist(),
            "std_Nm": self.std.tolist(), "gain": self.gain, "suggestion": self.suggestion,
        }  # fmt: skip


def spline(variable: str, knots: Array, scale: float) -> Effect:
    """Return the effect −Σ aₖ·hatₖ(x) whose amplitudes are bounded by ten times ``scale``."""
    x = VARIABLES[variable]
    width = float(knots[1] - knots[0])
    quantities = tuple(
        parameter(f"shape{k}", "N m", f"remaining torque at knot {k}", 0.0, -10 * scale, 10 * scale)
        for k in range(knots.size)
    )
    hats = [sp.Max(1 - sp.Abs(x - float(c)) / width, 0) for c in knots]
    torque = -sp.Add(*(quantity.symbol * hat for quantity, hat in zip(quantities, hats, strict=True)))
    return Effect(
        id=f"shape_over_{variable.partition('_')[0]}",
        title=f"remaining torque over {variable}", formula="−Σ aₖ·hatₖ(x)",
        lives_in=variable.partition("_")[0], side="torque", parameters=quantities, amplitudes=knots.size, torque=torque,
    )  # fmt: skip


def remaining(study: Study, solution: Solution) -> Shape:
    """Return the shape over the variable that explains most of what is left."""
    best = max((_over(study, solution, variable) for variable in VARIABLES), key=lambda s: s.gain)
    return replace(best, suggestion=suggestion(best.knots, best.torque, best.std, without_line(best.knots)))


def _over(study: Study, solution: Solution, variable: str) -> Shape:
    data = np.concatenate([_values(run, variable) for run in study.fitted])
    first, last = np.quantile(data, [0.005, 0.995])
    knots = np.linspace(float(first), float(last), KNOTS)
    scale = max(float(np.abs(run.u).max()) for run in study.fitted)
    effect = spline(variable, knots, scale)
    richer = solve(study, (*solution.effects, effect), solution.noise, solution.values, x0=solution.x0, iterations=15)
    place = [i for i, p in enumerate(richer.equations.parameters) if p.id.startswith("shape")]
    bent = without_line(knots)
    std = np.sqrt(np.diag(bent @ covariance_of(richer, place) @ bent.T))
    gain = 2.0 * (richer.log_likelihood - solution.log_likelihood)
    return Shape(variable=variable, knots=knots, torque=bent @ richer.theta[place], std=std, gain=gain)


def without_line(knots: Array) -> Array:
    """Return the projector (n, n) that takes constant and slope off a function at the knots.

    A spring's stiffness and place, or viscous friction, hold them already: with those the data fix the rest alone.
    """
    Q = np.linalg.qr(np.column_stack((np.ones(knots.size), knots)))[0]
    return np.asarray(np.eye(knots.size) - Q @ Q.T)


def covariance_of(solution: Solution, place: Sequence[int]) -> Array:
    """Return the covariance of the free parameters at ``place`` of ``equations.parameters``, all of linear scale."""
    J = solution.blocks.jacobian
    size = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    inverse = np.linalg.pinv((J / size).T @ (J / size), rcond=1e-12, hermitian=True)
    scaling = solution.problem.scaling
    at = [scaling.free.index(i) for i in place]
    unit = scaling.slope(solution.theta)[at] / size[at]
    return np.asarray(inverse[np.ix_(at, at)] * np.outer(unit, unit))


def _values(run: Run, variable: str) -> Array:
    if variable == "position_rad":
        return run.y[:, 0]
    return np.gradient(_smooth(run.y[:, 0]), run.t) if variable == "velocity_rad_s" else run.t


def _smooth(y: Array) -> Array:
    width = max(y.size // 200, 3)
    return np.convolve(np.pad(y, width, mode="edge"), np.ones(width) / width, mode="same")[width:-width]


def standard_errors(solution: Solution) -> Array:
    """Return the standard error of every parameter (n_p,), 0 where fixed, from whitened Jacobian and priors."""
    problem = solution.problem
    J = solution.blocks.jacobian
    covariance = np.linalg.pinv(J.T @ J, rcond=1e-14, hermitian=True)
    n, scaling = problem.n_parameters, problem.scaling
    result = np.zeros(solution.theta.size)
    result[list(scaling.free)] = scaling.slope(solution.theta) * np.sqrt(np.maximum(np.diag(covariance)[:n], 0.0))
    return result
