"""Fit a missing torque that has no name: `Study` and the `Solution` that lacks it in, `Shape` out.

1. Fit a spline over each single variable of each joint through homotopy, of long recordings with several rows merged
   into one, and the likeliest one to the end.
2. Where that closes too little of the residual, fit surfaces over two variables of the same joint in the same way.
3. Return the surface where it closes clearly more than the curve, or else the curve.

The function is an effect like any other and is fitted jointly with all parameters, so its values have standard errors,
and held-out runs show how much it explains. Of several joints that move together, the torque acts in one joint, over
that joint's position, speed, drive torque, or over time.
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
from haptid.discrepancy.fit.homotopy import through_homotopy
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.channels import alone
from haptid.discrepancy.study.merged_rows import merged, rows_to_merge
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.unnamed.splines import HELD, SYMBOLS, Curve, without_polynomial
from haptid.discrepancy.unnamed.suggestion import suggestion
from haptid.discrepancy.unnamed.surface import Axis, Surface
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.noise.correlation import Noise
from haptid.support.linear_algebra import rms, scaled_covariance
from haptid.support.processes.threads import map_threads

MOTION = {"position_rad", "velocity_rad_s"}
"""Variables that are always tried as a pair; every other pair contains the best single variable."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Functions that are tried in one joint.

    Parameters
    ----------
    functions
        Functions of one or two variables.
    column
        Index of the joint among the free joints.
    """

    functions: Curve | Surface
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A missing torque as a function of one or two variables.

    Parameters
    ----------
    joint
        Number of the joint in which it acts.
    variables
        One or two keys of `splines.SYMBOLS`.
    knots
        Values of each variable in its unit, shape (n,) each.
    torque, std
        Torque at the knots [N m] ([N] for a prismatic joint), in the direction of the drive's and without the part that
        the nominal model can hold, and its standard error. Shape (n,), or (n, n) with the first variable along axis 0.
    gain
        Twice the gain in log-likelihood under white noise.
    closed
        Share of the excess RMS over the sensor noise that it closes, on held-out runs where there are any.
    suggestion
        Closed form that follows the torque, or None.
    alone
        Best shape over one variable, where this one has two.
    beside
        Keys of the named effects beside which it is what is left.
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
    beside: tuple[str, ...] = ()

    def as_json(self) -> dict[str, object]:
        """Convert to ``unnamed_shape`` of the finding's JSON.

        Returns
        -------
        dict
            The fields with arrays as lists; the second variable and its knots are None for a shape over one.
        """
        (variable, *other), (knots, *others) = self.variables, self.knots
        return {
            "joint": self.joint, "variable": variable, "second_variable": other[0] if other else None,
            "knots": knots.tolist(),
            "second_knots": others[0].tolist() if others else None, "torque_Nm": self.torque.tolist(),
            "std_Nm": self.std.tolist(), "gain": self.gain, "closed": self.closed, "suggestion": self.suggestion,
            "over_one_variable": self.alone.as_json() if self.alone else None, "beside": list(self.beside),
        }  # fmt: skip


def missing(study: Study, model: Solution, *, is_near: bool = False) -> Shape:
    """Fit the missing torque over the variables that explain most of a model's residual.

    Parameters
    ----------
    study
        Study with the fitted runs.
    model
        Nominal model, or one with effects that explain a part, under any noise; white noise is used here.
    is_near
        Whether the model explains most of what was missing, so that each shape is fitted from its optimum, without an
        observer.

    Returns
    -------
    Shape
        Torque over one variable; over two where one closes less than `share_closed_by_one_variable` and a second adds
        more than `least_share_added_by_second_variable`.
    """
    # The noise model of the nominal fit may have absorbed the discrepancy as correlation or scatter.
    white = solve(study, model.effects, Noise(), model.values, x0=model.x0)
    joints = study.fitted[0].free_joints
    ranges = [{variable: _range(study, variable, k) for variable in SYMBOLS} for k in range(len(joints))]
    curves = [
        Place(functions=Curve(variable=variable, first=a, last=b), column=k)
        for k, own in enumerate(ranges)
        for variable, (a, b) in own.items()
    ]
    one = _best(study, white, curves, is_near=is_near)
    if one.closed >= THRESHOLDS.unnamed.share_closed_by_one_variable:
        return one
    column = joints.index(one.joint)
    axes = {variable: Axis(variable=variable, first=a, last=b) for variable, (a, b) in ranges[column].items()}
    pairs = [pair for pair in combinations(SYMBOLS, 2) if one.variables[0] in pair or set(pair) == MOTION]
    surfaces = [Place(functions=Surface(axes=(axes[a], axes[b])), column=column) for a, b in pairs]
    two = _best(study, white, surfaces, is_near=is_near)
    least = one.closed + THRESHOLDS.unnamed.least_share_added_by_second_variable
    return replace(two, alone=one) if two.closed > least else one


def _best(study: Study, white: Solution, tried: Sequence[Place], *, is_near: bool) -> Shape:
    """Fit all candidates roughly, side by side, and the likeliest of them to the end."""
    few = merged(study, rows_to_merge(study, THRESHOLDS.unnamed.most_rows_of_rough_shape))
    fit = partial(_roughly, at_step(few, study.factory.sketch), white, is_near=is_near)
    rough = map_threads(fit, tried, threads=study.threads)
    begun = likeliest(*rough)
    place = next(p for p, found in zip(tried, rough, strict=True) if found is begun)
    return _over(study, white, begun, place)


def _range(study: Study, variable: str, column: int) -> tuple[float, float]:
    data = np.concatenate([_values(alone(run, column), variable) for run in study.fitted])
    # Without the outermost half per cent at either end, no knot lies where hardly any reading does.
    first, last = np.quantile(data, [0.005, 0.995])
    return float(first), float(last)


def _roughly(study: Study, white: Solution, place: Place, *, is_near: bool) -> Solution:
    """Fit the shape through homotopy, or from the optimum of a model that is near, to `rough_tolerance_chi2`.

    Beside the nominal model, which may have taken what is missing upon itself, it begins at the first guesses.
    """
    scale = max(float(np.abs(run.u[:, place.column]).max()) for run in study.fitted)
    effect = study.in_joint(place.functions.effect(scale), place.column)
    effects, tolerance = (*white.effects, effect), THRESHOLDS.fit.rough_tolerance_chi2
    study = replace(study, threads=1)
    if is_near:
        few = THRESHOLDS.candidate.first_try_simulations
        return solve(study, effects, Noise(), white.values, x0=white.x0, iterations=few, tolerance=tolerance)
    values = white.values if white.effects else {q.id: q.initial for q in study.base.parameters}
    return through_homotopy(study, effects, values, tolerance=tolerance)[0]


def _over(study: Study, before: Solution, rough: Solution, tried: Place) -> Shape:
    """Fit a rough shape to the end, and compute its torque with standard errors."""
    functions, first = tried.functions, study.fitted[0]
    iterations = THRESHOLDS.fit.most_simulations_of_last_fit
    after = solve(study, rough.effects, Noise(), rough.values, x0=rough.x0, iterations=iterations)
    effect = rough.effects[-1]
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
        suggestion=simple, beside=tuple(e.key for e in before.effects),
    )  # fmt: skip


def _share_closed(study: Study, before: Solution, after: Solution) -> float:
    """Return (before − after)/(before − 1) of the RMS over the sensor noise."""
    b, a = (_rms_over_noise(study, solution) for solution in (before, after))
    return (b - a) / max(b - 1.0, 1e-3)


def _rms_over_noise(study: Study, solution: Solution) -> float:
    """Return the RMS of measured − simulated over the sensor noise, on held-out runs where there are any."""
    runs = study.unseen or study.fitted
    each = zip(runs, predict(study, solution, runs).y, strict=True)
    left = np.concatenate([((run.y - y) / run.sensor_std)[run.scored].ravel() for run, y in each])
    return rms(left)


def covariance_of(solution: Solution, place: Sequence[int]) -> Array:
    """Return the covariance of some free parameters.

    Parameters
    ----------
    solution
        Fitted model.
    place
        Indices in ``equations.parameters``; all of them free and of linear scale.

    Returns
    -------
    ndarray
        Covariance in the parameters' units, shape (n, n), for noise as large as the noise model says.
    """
    inverse, size = scaled_covariance(solution.blocks.jacobian)
    parametrisation = solution.problem.parametrisation
    at = [parametrisation.free.index(i) for i in place]
    unit = parametrisation.slope(solution.theta)[at] / size[at]
    return np.asarray(inverse[np.ix_(at, at)] * np.outer(unit, unit))


def _values(run: Run, variable: str) -> Array:
    if variable == "velocity_rad_s":
        return np.asarray(np.gradient(_smooth(run.y[:, 0]), run.t))
    return {"position_rad": run.y[:, 0], "torque_Nm": run.u[:, 0], "time_s": run.t}[variable]


def _smooth(y: Array) -> Array:
    width = max(y.size // 200, 3)
    # Differences of neighbouring readings would magnify the sensor noise; a moving average over a two-hundredth of the
    # run comes first.
    return np.convolve(np.pad(y, width, mode="edge"), np.ones(width) / width, mode="same")[width:-width]
