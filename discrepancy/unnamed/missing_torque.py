"""What is missing, without a name: a torque as a smooth function of the one or two variables in which it lives.

Of several joints that move together, the torque is one joint's, over its own position, speed, drive torque, or time.

The function is an effect like any other, fitted on top of the base jointly with all parameters; so its values come with
standard errors, and runs that no fit saw tell its worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np

from haptid.discrepancy.candidate.refit import likeliest
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.fit.homotopy import MANY, through_homotopy
from haptid.discrepancy.fit.solution import ROUGH, Solution, solve
from haptid.discrepancy.study.channels import alone
from haptid.discrepancy.study.simulators import SKETCH
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.unnamed.splines import HELD, SYMBOLS, Curve, without_polynomial
from haptid.discrepancy.unnamed.suggestion import suggestion
from haptid.discrepancy.unnamed.surface import Axis, Surface
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.noise.correlation import Noise
from haptid.support.linear_algebra import scaled_covariance
from haptid.support.processes.threads import map_threads

MOTION = {"position_rad", "velocity_rad_s"}
"""The two variables that are tried together whichever is the best one alone; the others are beside that one only."""
ENOUGH, MORE = 0.9, 0.05
"""Share of the gap that one variable has to close for no second one to be looked for, and what a second has to add."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Functions that are tried in the joint at place ``column``."""

    functions: Curve | Surface
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A torque as a function of one or two variables.

    Parameters
    ----------
    joint
        In which it acts.
    variables
        Of `splines.SYMBOLS`.
    knots
        Values of each variable, (n,) each.
    torque, std
        Torque there less what the base holds [N m], counted as the drive's is, and its standard error: (n,), or (n, n),
        the first variable down.
    gain
        Twice the gain in log-likelihood under white noise.
    closed
        Share of the gap that it closes, RMS over the sensor's noise, on unseen runs where there are any.
    suggestion
        A closed form that follows it, where one was found.
    alone
        The best of one variable, where it has two.
    """

    joint: int
    variables: tuple[str, ...]
    knots: tuple[Array, ...]
    torque: Array
    std: Array
    gain: float
    closed: float
    suggestion: str | None = None
    alone: Shape | None = None

    def as_json(self) -> dict[str, object]:
        """Plain lists."""
        (variable, *other), (knots, *others) = self.variables, self.knots
        return {
            "joint": self.joint, "variable": variable, "second_variable": other[0] if other else None,
            "knots": knots.tolist(),
            "second_knots": others[0].tolist() if others else None, "torque_Nm": self.torque.tolist(),
            "std_Nm": self.std.tolist(), "gain": self.gain, "closed": self.closed, "suggestion": self.suggestion,
            "over_one_variable": self.alone.as_json() if self.alone else None,
        }  # fmt: skip


def missing(study: Study, base: Solution) -> Shape:
    """Return the shape over the variable that explains most of what ``base`` leaves under white noise.

    Where that is not most of it, and a second variable beside it adds to it, over both.
    """
    white = solve(study, (), Noise(), base.values, x0=base.x0)
    joints = study.fitted[0].free_joints
    ranges = [{variable: _range(study, variable, k) for variable in SYMBOLS} for k in range(len(joints))]
    curves = [
        Place(functions=Curve(variable=variable, first=a, last=b), column=k)
        for k, own in enumerate(ranges)
        for variable, (a, b) in own.items()
    ]
    one = _best(study, white, curves)
    if one.closed >= ENOUGH:
        return one
    column = joints.index(one.joint)
    axes = {variable: Axis(variable=variable, first=a, last=b) for variable, (a, b) in ranges[column].items()}
    pairs = [pair for pair in combinations(SYMBOLS, 2) if one.variables[0] in pair or set(pair) == MOTION]
    two = _best(study, white, [Place(functions=Surface(axes=(axes[a], axes[b])), column=column) for a, b in pairs])
    return replace(two, alone=one) if two.closed > one.closed + MORE else one


def _best(study: Study, white: Solution, tried: Sequence[Place]) -> Shape:
    """Fit every one roughly, side by side, and the best of them to the end."""
    rough = map_threads(partial(_roughly, at_step(study, SKETCH)), tried, threads=study.threads)
    begun = likeliest(*rough)
    place = next(p for p, found in zip(tried, rough, strict=True) if found is begun)
    return _over(study, white, begun, place)


def _range(study: Study, variable: str, column: int) -> tuple[float, float]:
    data = np.concatenate([_values(alone(run, column), variable) for run in study.fitted])
    first, last = np.quantile(data, [0.005, 0.995])
    return float(first), float(last)


def _roughly(study: Study, place: Place) -> Solution:
    """Fit the shape from the first guesses, not to the end."""
    scale = max(float(np.abs(run.u[:, place.column]).max()) for run in study.fitted)
    effect = study.in_joint(place.functions.effect(scale), place.column)
    guesses = {q.id: q.initial for q in study.base.parameters}
    return through_homotopy(replace(study, threads=1), (effect,), guesses, tolerance=ROUGH)[0]


def _over(study: Study, before: Solution, rough: Solution, tried: Place) -> Shape:
    """Fit to the end what was begun roughly, and tell of it."""
    functions, first = tried.functions, study.fitted[0]
    after = solve(study, rough.effects, Noise(), rough.values, x0=rough.x0, iterations=MANY)
    (effect,) = rough.effects
    ids = [p.id for p in after.equations.parameters]
    place = [ids.index(q.id) for q in effect.parameters[: effect.amplitudes]]
    told, knots = functions.design, functions.knots
    size = [k.size for k in knots]
    misfit = max(1.0, float(after.residual @ after.residual) / study.rows)  # what it leaves widens its errors
    torque = told @ after.theta[place]
    std = np.sqrt(misfit * np.diag(told @ covariance_of(after, place) @ told.T))
    simple = None
    if isinstance(functions, Curve):
        bend = without_polynomial(knots[0], HELD[functions.variable])
        simple = suggestion(knots[0], torque, std, bend, unit_for("N m", alone(first, tried.column).prismatic))
    return Shape(
        joint=first.free_joints[tried.column], variables=functions.variables, knots=knots,
        torque=torque.reshape(size), std=std.reshape(size),
        gain=2.0 * (after.log_likelihood - before.log_likelihood), closed=_share_closed(study, before, after),
        suggestion=simple,
    )  # fmt: skip


def _share_closed(study: Study, before: Solution, after: Solution) -> float:
    """(before − after)/(before − 1) of the RMS over the sensor's noise."""
    b, a = (_rms_over_noise(study, solution) for solution in (before, after))
    return (b - a) / max(b - 1.0, 1e-3)


def _rms_over_noise(study: Study, solution: Solution) -> float:
    """RMS of measured − simulated over the sensor's noise, on unseen runs where there are any."""
    runs = study.unseen or study.fitted
    each = zip(runs, predict(study, solution, runs).y, strict=True)
    left = np.concatenate([((run.y - y) / run.sensor_std)[run.scored].ravel() for run, y in each])
    return float(np.sqrt(np.mean(left**2)))


def covariance_of(solution: Solution, place: Sequence[int]) -> Array:
    """Return the covariance of the free parameters at ``place`` of ``equations.parameters``, all of linear scale."""
    inverse, size = scaled_covariance(solution.blocks.jacobian)
    scaling = solution.problem.scaling
    at = [scaling.free.index(i) for i in place]
    unit = scaling.slope(solution.theta)[at] / size[at]
    return np.asarray(inverse[np.ix_(at, at)] * np.outer(unit, unit))


def _values(run: Run, variable: str) -> Array:
    if variable == "velocity_rad_s":
        return np.asarray(np.gradient(_smooth(run.y[:, 0]), run.t))
    return {"position_rad": run.y[:, 0], "torque_Nm": run.u[:, 0], "time_s": run.t}[variable]


def _smooth(y: Array) -> Array:
    width = max(y.size // 200, 3)
    return np.convolve(np.pad(y, width, mode="edge"), np.ones(width) / width, mode="same")[width:-width]
