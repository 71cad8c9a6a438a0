"""What is missing, without a name: a torque as a cubic spline over the one variable in which it lives.

The function is an effect like any other, −Σ aₖ·Bₖ(x) with cubic B-splines on equidistant knots, fitted on top of the
base jointly with all parameters; so its values come with standard errors, and runs that no fit saw tell its worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from discrepancy.held_out import predict
from discrepancy.homotopy import MANY, through_homotopy
from discrepancy.kernels import COARSE
from discrepancy.noise import Noise
from discrepancy.solution import ROUGH, Solution, solve
from discrepancy.steps import at_step
from discrepancy.study import Study
from discrepancy.suggestion import suggestion
from measurement.run import Array, Run
from measurement.units import unit_for
from model.effect import Effect, parameter
from model.effect import q as position
from model.effect import v as velocity
from model.equations import TIME

INTERVALS = 7
"""Stretches of the variable, each with a cubic of its own."""
POINTS = 15
"""Values of the variable at which the torque is told."""
HELD = {"position_rad": 2, "velocity_rad_s": 2, "time_s": 1}
"""Powers of each variable that the base holds: a spring's stiffness and place, viscous friction."""
PLACES = range(-1, INTERVALS + 2)
"""Centres of the B-splines, in stretches from the first one."""
BINOMIAL = (1, -4, 6, -4, 1)
"""Weights of the truncated powers (t + 2 − j)₊³/6 in a cubic B-spline about t = 0."""
VARIABLES = {"position_rad": position, "velocity_rad_s": velocity, "time_s": TIME}


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A torque as a function of one variable.

    Parameters
    ----------
    variable
        One of `VARIABLES`.
    knots, torque, std
        Values of the variable, the torque there less what the base holds [N m] and its standard error, (POINTS,) each.
    gain
        Twice the gain in log-likelihood under white noise.
    closed
        Share of the gap that it closes, RMS over the sensor's noise, on unseen runs where there are any.
    suggestion
        A closed form that follows it, where one was found.
    """

    variable: str
    knots: Array
    torque: Array
    std: Array
    gain: float
    closed: float
    suggestion: str | None = None

    def as_json(self) -> dict[str, object]:
        """Plain lists."""
        return {
            "variable": self.variable, "knots": self.knots.tolist(), "torque_Nm": self.torque.tolist(),
            "std_Nm": self.std.tolist(), "gain": self.gain, "closed": self.closed, "suggestion": self.suggestion,
        }  # fmt: skip


def spline(variable: str, first: float, last: float, scale: float) -> Effect:
    """Return the effect −Σ aₖ·sₖ(x), constant beyond ``first`` and ``last``; |aₖ| is bounded by ten times ``scale``."""
    t = (sp.Min(sp.Max(VARIABLES[variable], first), last) - first) * (INTERVALS / (last - first))
    powers = [[w * sp.Max(t - place + 2 - j, 0) ** 3 / 6 for j, w in enumerate(BINOMIAL)] for place in PLACES]
    splines = sp.Matrix([sp.Add(*row) for row in powers])
    free = mixtures(variable)
    quantities = tuple(
        parameter(f"shape{k}", "N m", f"weight {k} of the missing torque", 0.0, -10 * scale, 10 * scale)
        for k in range(free.shape[1])
    )
    torque = -sp.Add(*(q.symbol * (splines.T @ column)[0] for q, column in zip(quantities, free.T, strict=True)))
    return Effect(
        id=f"shape_over_{variable.partition('_')[0]}", title=f"missing torque over {variable}", formula="−Σ aₖ·sₖ(x)",
        lives_in=variable.partition("_")[0], side="torque", parameters=quantities, amplitudes=len(quantities),
        torque=torque,
    )  # fmt: skip


def mixtures(variable: str) -> Array:
    """Return weights of the B-splines, column by column, that together hold no polynomial that the base holds.

    Weights of equal size make a constant, equidistant ones a straight line.
    """
    held = np.vander(np.array(PLACES, dtype=float), HELD[variable])
    return np.linalg.qr(held, mode="complete")[0][:, HELD[variable] :]


def basis(t: Array) -> Array:
    """Return all B-splines (n, len(PLACES)) at t (n,) in [0, INTERVALS]."""
    powers = [w * np.maximum(t[:, None] - np.array(PLACES) + 2 - j, 0.0) ** 3 for j, w in enumerate(BINOMIAL)]
    return np.asarray(np.sum(powers, axis=0) / 6)


def missing(study: Study, base: Solution) -> Shape:
    """Return the shape over the variable that explains most of what ``base`` leaves under white noise."""
    white = solve(study, (), Noise(), base.values, x0=base.x0)
    variable, rough = max(((v, _roughly(study, v)) for v in VARIABLES), key=lambda pair: pair[1].log_likelihood)
    best = _over(study, white, rough, variable)
    bend = without_polynomial(best.knots, HELD[best.variable])
    unit = unit_for("N m", study.fitted[0].prismatic)
    return replace(best, suggestion=suggestion(best.knots, best.torque, best.std, bend, unit))


def _range(study: Study, variable: str) -> tuple[float, float]:
    data = np.concatenate([_values(run, variable) for run in study.fitted])
    first, last = np.quantile(data, [0.005, 0.995])
    return float(first), float(last)


def _roughly(study: Study, variable: str) -> Solution:
    """Fit the shape over one variable from the first guesses, at coarse steps and not to the end."""
    scale = max(float(np.abs(run.u).max()) for run in study.fitted)
    guesses = {q.id: q.initial for q in study.base.parameters}
    effects = (spline(variable, *_range(study, variable), scale),)
    return through_homotopy(at_step(study, COARSE), effects, guesses, tolerance=ROUGH)[0]


def _over(study: Study, before: Solution, rough: Solution, variable: str) -> Shape:
    """Fit to the end what was begun roughly, and tell of it."""
    after = solve(study, rough.effects, Noise(), rough.values, x0=rough.x0, iterations=MANY)
    first, last = _range(study, variable)
    place = [i for i, p in enumerate(after.equations.parameters) if p.id.startswith("shape")]
    knots = np.linspace(first, last, POINTS)
    told = without_polynomial(knots, HELD[variable]) @ basis(np.linspace(0.0, INTERVALS, POINTS)) @ mixtures(variable)
    misfit = max(1.0, float(after.residual @ after.residual) / study.rows)  # what it leaves widens its errors
    std = np.sqrt(misfit * np.diag(told @ covariance_of(after, place) @ told.T))
    return Shape(
        variable=variable, knots=knots, torque=told @ after.theta[place], std=std,
        gain=2.0 * (after.log_likelihood - before.log_likelihood), closed=_closed(study, before, after),
    )  # fmt: skip


def _closed(study: Study, before: Solution, after: Solution) -> float:
    """(before − after)/(before − 1) of the RMS over the sensor's noise."""
    runs = study.unseen or study.fitted
    noise = np.array([run.sensor_std[0] for run in runs])
    b, a = (float(np.sqrt(np.mean((np.array(predict(study, s, runs).rms) / noise) ** 2))) for s in (before, after))
    return (b - a) / max(b - 1.0, 1e-3)


def without_polynomial(knots: Array, terms: int) -> Array:
    """Return the projector (n, n) that takes the first ``terms`` powers off a function at the knots."""
    Q = np.linalg.qr(np.vander((knots - knots.mean()) / np.ptp(knots), terms))[0]
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
