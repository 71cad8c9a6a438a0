"""Torque fit of one joint for runs recorded under position control: `Equations` and `Run`s in, `Fit` out.

1. Exchange torque and position of the runs, the torque behind the delay that the plain model found, and turn the
   equation into the torque equation (`identification.simulators.inverse_dynamics`).
2. Leave rows at rest out: friction holds the joint there with any torque up to its level, so that the motion does not
   tell it.
3. Fit without observer. Fit again with the rows near reversals at the weight w = min(1, RMS away from reversals over
   RMS near them): the filter decides there when friction turns, a joint that sticks for a few rows leaves as much as
   its friction, and a fit that counts these rows alike bends friction and inertia to them. Weight and fit are repeated
   until the weight stays (`identification.fit.weight_near_reversals`).
4. Widen ranges that haptid chose where the optimum lies on them (`identification.fit.own_bounds`). The range of the
   Stribeck curve is not one of them: it is restrained, and the restraint is dropped where the model then leaves noise,
   and clearly less, or less than half (`identification.fit.stribeck_restraint`).
5. Where the residual is above the torque's noise, widen the standard deviations by the jackknife: a slow sweep then
   identifies inertia, Stribeck velocity or viscous friction only as far as all its parts agree on them.
6. Move the estimate within these errors along what free simulations of the position see
   (`identification.fit.joint_cost`).

Scores are those of rows away from rests and reversals; what is left near reversals is told beside them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.fit.joint_cost import move_by_position
from haptid.identification.fit.multistart import fit, from_optimum, with_agreement
from haptid.identification.fit.own_bounds import fit_within_own_bounds
from haptid.identification.fit.strategy import quiet
from haptid.identification.fit.stribeck_restraint import (
    pays_for_release,
    release_stribeck,
    restrain_stribeck,
    restrained_ids,
)
from haptid.identification.fit.weight_near_reversals import refit_until_weight_stays, weight_near_reversals
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_runs
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.simulators.slow_rows import Mask, rests, turns
from haptid.identification.statistics.jackknife import with_jackknife
from haptid.identification.statistics.score import fit_initial_state, residuals, score_of
from haptid.identification.workers.workers import Workers
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.model.equations.equations import Equations
from haptid.support.linear_algebra import rms
from haptid.support.numbers import plain


def fit_torque(  # noqa: PLR0913 # the joint and its runs, what is known of them, and how the fit is done
    equations: Equations,
    runs: Sequence[Run],
    *,
    stated: Sequence[str] = (),
    own: Sequence[str] = (),
    delay: float = 0.0,
    sliding: float = 0.0,
    position: Simulator | None = None,
    options: FitOptions | None = None,
    workers: Workers | None = None,
) -> Fit:
    """Fit one joint to the torque of its runs, with the measured motion as input.

    Parameters
    ----------
    equations
        Equations of the joint.
    runs
        All runs of the joint: those with ``use == "fit"`` are fitted, the others scored.
    stated
        Ids of the parameters that the user stated, which stay as they are.
    own
        Ids of the parameters whose range haptid chose.
    delay
        Delay of the recorded torque [s], as the plain model has it.
    sliding
        Sliding friction that the plain model finds [N m]: the restraint of stiction counts from it where it is larger
        than the first guess, which may be far too low.
    position
        Simulator from torque to position, of the same parameters; where None the torque alone counts.
    options
        Choices of the fit; the observer gains are replaced by 0.
    workers
        Workers that run the starts and refits.

    Returns
    -------
    Fit
        Residuals, scores and noise are torques [N m], or forces [N] of a prismatic joint; the notes say how large.

    Raises
    ------
    NumericalError
        Where no start gave a finite simulation.
    """
    options = (options or FitOptions()).but(gains=(0.0,))
    restrained = restrain_stribeck(equations, runs, stated, sliding)
    # Rows at rest have the weight 0.
    turned = tuple(run.but(weight=(~rests(run)).astype(float)) for run in torque_runs(runs, delay))
    found = fit(TorqueSimulator.of(restrained), turned, options=options, workers=workers)
    noisy = torque_runs(runs, delay, found.values["inertia"])
    turned = tuple(run.but(noise=one.noise) for run, one in zip(turned, noisy, strict=True))

    def fit_at(weight: float) -> Callable[[Equations, FitOptions], Fit]:
        weighted = _weigh_reversals(turned, weight)
        return lambda equations, options: fit(TorqueSimulator.of(equations), weighted, options=options, workers=workers)

    def asked_by(found: Fit) -> float:
        return _weight_asked_by(_residuals(found, turned))

    def reweigh(found: Fit, weight: float, equations: Equations) -> tuple[Fit, float]:
        def refit(found: Fit, weight: float) -> Fit:
            return fit_at(weight)(_with_ranges_of(found, equations), from_optimum(found, options, alone=True))

        return refit_until_weight_stays(found, weight, asked_by=asked_by, refit=refit)

    weight, held = asked_by(found), restrained_ids(restrained)
    own = [id for id in own if id not in held]
    found = fit_within_own_bounds(fit_at(weight), restrained, turned, own, from_optimum(found, options))
    found, weight = reweigh(found, weight, restrained)
    freed = _released(found, restrained, fit_at(weight), turned, options)
    if freed is not found:
        found, weight = reweigh(freed, weight, release_stribeck(restrained))
    weighted = _weigh_reversals(turned, weight)
    simulator = TorqueSimulator.of_torque(found.equations)
    if found.basins[0].over_noise > options.tolerance:
        found = with_jackknife(simulator, found, weighted, options, workers)
    if position is not None:
        found = _move_by_position(found, position, runs, delay)
    left = _residuals(found, weighted)
    found = found.but(
        outcome=Outcome.TORQUE_SCORED, runs=tuple(score_of(one.run, one.r[_judged(one.run)], one.x0) for one in left)
    )
    told = (*_tell_scores(found, weighted), *_tell_reversals(left, weight))
    return found.but(notes=(*found.notes, *told))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Left:
    """What a fit leaves of a turned run: the residual torque (n_t, 1) [N m] from the initial state x0 (n_x,)."""

    run: Run
    r: Array
    x0: Array


def _residuals(found: Fit, turned: Sequence[Run]) -> list[_Left]:
    """Return what a fit leaves of all runs that are not excluded."""
    simulator, left = TorqueSimulator.of_torque(found.equations), []
    for run in turned:
        if run.use == "excluded":
            continue
        # The held-out part of a fitted file goes on from the initial state of its fitted part.
        known = found.x0.get(run.file)
        x0 = fit_initial_state(simulator, found.theta, run) if known is None else known
        left.append(_Left(run=run, r=residuals(simulator, found.theta, run, x0), x0=x0))
    return left


def _with_ranges_of(found: Fit, equations: Equations) -> Equations:
    """Return the equation of motion with the ranges that a fit of its torque equation ended with."""
    return equations.with_parameters({q.id: {"lower": q.lower, "upper": q.upper} for q in found.equations.parameters})


def _weight_asked_by(left: Sequence[_Left]) -> float:
    """Return the weight of rows near reversals that the fitted runs ask for."""
    away, near = [], []
    for one in left:
        if one.run.use == "fit":
            counted = _scored(one.run) & ~rests(one.run)
            near.append(one.r[counted & turns(one.run)])
            away.append(one.r[counted & ~turns(one.run)])
    return weight_near_reversals(np.concatenate(away), np.concatenate(near))


def _rows_away_over_noise(found: Fit, turned: Sequence[Run]) -> Array:
    """Return the residual of fitted rows away from rests and reversals over the noise, shape (n_rows,)."""
    left = [one for one in _residuals(found, turned) if one.run.use == "fit"]
    return np.concatenate([one.r[_judged(one.run)].ravel() / float(one.run.sensor_std[0]) for one in left])


def _weigh_reversals(turned: Sequence[Run], weight: float) -> tuple[Run, ...]:
    """Return the runs with the weight of rows near reversals."""
    return tuple(run.but(weight=np.where(turns(run), weight * run.weight, run.weight)) for run in turned)


def _scored(run: Run) -> Mask:
    """Return which rows are scored at all, shape (n_t,)."""
    rows = np.zeros(run.t.size, dtype=bool)
    rows[run.scored] = True
    return rows


def _judged(run: Run) -> Mask:
    """Return the scored rows away from rests and reversals, shape (n_t,); all scored rows where there are none."""
    away = _scored(run) & ~(rests(run) | turns(run))
    return away if away.any() else _scored(run)


def _move_by_position(found: Fit, position: Simulator, runs: Sequence[Run], delay: float) -> Fit:
    """Return the fit at the parameters that hold torque and position; its scores are still those by the torque."""
    moved = move_by_position(found, position, runs, delay)
    if moved is None:
        return found
    unit = unit_for("rad", runs[0].prismatic)
    told = (
        "torque and position are held by one cost: within the errors of the torque, the error of free simulations of "
        f"the fitted runs falls from {plain(moved.before, 3)} to {plain(moved.after, 3)} {unit} RMS"
    )
    return found.but(theta=moved.theta, notes=(*found.notes, told))


def _released(
    found: Fit,
    restrained: Equations,
    fit_weighted: Callable[[Equations, FitOptions], Fit],
    turned: Sequence[Run],
    options: FitOptions,
) -> Fit:
    """Return the fit without the restraint of the Stribeck curve where that pays (`stribeck_restraint`)."""
    held = restrained_ids(restrained)
    if not held:
        return found
    released = release_stribeck(_with_ranges_of(found, restrained))
    begin = {id: max(found.values[id], released.parameter(id).initial) for id in held}
    start = tuple((found.values | begin).values())
    freed = fit_weighted(released, from_optimum(found, options, alone=True).but(start=start))
    before, after = (_rows_away_over_noise(one, turned) for one in (found, freed))
    rows = after.size / max(freed.correlation_time, 1.0)
    squares = (float(np.mean(before**2)), float(np.mean(after**2)))
    if pays_for_release(*squares, rows, len(held), leaves_noise=quiet(freed, options)):
        return with_agreement(freed, found, options)
    return found


def _tell_scores(found: Fit, turned: Sequence[Run]) -> list[str]:
    """Say for every scored run how large the residual torque is, against the torque and against its noise."""
    scored: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in turned}
    sentences = []
    for one in found.runs:
        run = scored[one.file, one.use]
        unit = unit_for("N m", run.prismatic)
        size = rms(run.y[_judged(run)])
        close = "at" if one.over_noise <= FitOptions().tolerance else f"{one.over_noise:.1f} times"
        sentences.append(
            f"{run.file} ({one.use}): residual torque {plain(one.rmse_rad, 3)} {unit} RMS, {one.rmse_rad / size:.1%} "
            f"of the torque's RMS and {close} its white noise ({plain(float(run.sensor_std[0]))} {unit})"
        )
    return sentences


def _tell_reversals(left: Sequence[_Left], weight: float) -> list[str]:
    """Say how many rows took no part or counted less, and what is left there, where there are such rows."""
    rows = sum(np.sum(_scored(one.run)) for one in left)
    resting = sum(np.sum(_scored(one.run) & rests(one.run)) for one in left)
    near = [one.r[_scored(one.run) & turns(one.run) & ~rests(one.run)] for one in left]
    sentences = []
    if resting:
        sentences.append(
            f"{resting / rows:.1%} of the rows are at rest, where friction holds the joint with any torque up to its "
            "level: they take no part"
        )
    if weight < 1.0:
        unit = unit_for("N m", left[0].run.prismatic)
        sentences.append(
            f"{sum(map(len, near)) / rows:.1%} of the rows are near reversals, where the filter decides when friction "
            f"turns: they have the weight {plain(weight)} and leave {plain(rms(np.concatenate(near)), 3)} {unit} RMS, "
            "which the residual torques of the runs do not contain"
        )
    return sentences
