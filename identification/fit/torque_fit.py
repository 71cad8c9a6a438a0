"""Torque fit of one joint for runs recorded under position control: `Equations` and `Run`s in, `Fit` out.

1. Exchange torque and position of the runs, the torque behind the delay that the plain model found, and turn the
   equation into the torque equation (`identification.simulators.inverse_dynamics`).
2. Fit without observer.
3. Where the residual is above the torque's noise, widen the standard deviations by the jackknife: a slow sweep then
   identifies inertia, Stribeck velocity or viscous friction only as far as all its parts agree on them.
4. Move the estimate within these errors along what free simulations of the position see
   (`identification.fit.joint_cost`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.fit.joint_cost import move_by_position
from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_runs
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.jackknife import with_jackknife
from haptid.identification.statistics.score import residuals, score, score_of
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Workers
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Run
from haptid.measurement.values.units import unit_for
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import rms
from haptid.support.numbers import plain


def fit_torque(
    equations: Equations,
    runs: Sequence[Run],
    *,
    stated: Sequence[str] = (),
    delay: float = 0.0,
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
    delay
        Delay of the recorded torque [s], as the plain model has it.
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
    simulator = TorqueSimulator.of(restrain_stribeck(equations, runs, stated))
    turned = torque_runs(runs, delay)
    found = fit(simulator, turned, options=options, workers=workers)
    if found.basins[0].over_noise > options.tolerance:
        found = with_jackknife(simulator, found, turned, options, workers)
    if position is not None:
        found = _move_by_position(found, simulator, position, runs, turned, delay)
    return found.but(outcome=Outcome.TORQUE_SCORED, notes=(*found.notes, *_sentences(found, turned)))


def _move_by_position(
    found: Fit,
    simulator: TorqueSimulator,
    position: Simulator,
    runs: Sequence[Run],
    turned: Sequence[Run],
    delay: float,
) -> Fit:
    """Return the fit at the parameters that hold torque and position, its torques scored there."""
    moved = move_by_position(found, position, runs, delay)
    if moved is None:
        return found
    at = found.but(theta=moved.theta)
    scores = []
    for run in turned:
        if run.use == "fit":
            x0 = found.x0[run.file]
            scores.append(score_of(run, residuals(simulator, at.theta, run, x0)[run.scored], x0))
        elif run.use == "validate":
            scores.append(score(simulator, at, run))
    unit = unit_for("rad", runs[0].prismatic)
    told = (
        "torque and position are held by one cost: within the errors of the torque, the error of free simulations of "
        f"the fitted runs falls from {plain(moved.before, 3)} to {plain(moved.after, 3)} {unit} RMS"
    )
    return at.but(runs=tuple(scores), notes=(*found.notes, told))


def restrain_stribeck(equations: Equations, runs: Sequence[Run], stated: Sequence[str]) -> Equations:
    """Hold stiction and Stribeck speed near what friction has in general, as far as the data do not pay for more.

    Along a motion that hardly creeps a free Stribeck curve takes the Coulomb torque's part: its speed rises to half of
    the top speed and Fc collapses, or Fs grows without bound.

    Parameters
    ----------
    equations
        Equations of the joint, whose first guesses are those of the data.
    runs
        Runs that scale the speeds.
    stated
        Ids of the parameters that the user stated, which stay as they are.

    Returns
    -------
    Equations
        With normal priors of Fs and vs, and with bounds Fs ≤ 3·Fc and vs ≤ 5 % of the top speed.
    """
    roles = law_named(equations.friction[0]).roles
    changes: dict[str, dict[str, object]] = {}
    if roles.stiction != roles.coulomb and roles.stiction not in stated:
        level = equations.parameter(roles.coulomb).initial
        mean = THRESHOLDS.stiction_prior_mean_over_coulomb * level
        changes[roles.stiction] = {
            "initial": mean,
            "upper": THRESHOLDS.largest_stiction_over_coulomb * level,
            "prior": Normal(mean=mean, std=THRESHOLDS.stiction_prior_std_over_coulomb * level, source="restraint"),
        }
    if roles.stribeck_velocity and roles.stribeck_velocity not in stated:
        top = max(float(np.max(np.abs(filter_run(run).v))) for run in runs if run.use == "fit")
        usual = THRESHOLDS.stribeck_speed_over_top_speed * top
        changes[roles.stribeck_velocity] = {
            "initial": usual,
            "lower": usual / THRESHOLDS.stribeck_speed_over_least_speed,
            "upper": THRESHOLDS.largest_stribeck_speed_over_top_speed * top,
            "prior": Normal(mean=usual, std=usual, source="restraint"),
        }
    return equations.with_parameters(changes)


def _sentences(found: Fit, turned: Sequence[Run]) -> list[str]:
    """Say for every scored run how large the residual torque is, against the torque and against its noise."""
    scored: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in turned}
    sentences = []
    for one in found.runs:
        run = scored[one.file, one.use]
        unit = unit_for("N m", run.prismatic)
        size = rms(run.y[run.scored])
        close = "at" if one.over_noise <= FitOptions().tolerance else f"{one.over_noise:.1f} times"
        sentences.append(
            f"{run.file} ({one.use}): residual torque {plain(one.rmse_rad, 3)} {unit} RMS, {one.rmse_rad / size:.1%} "
            f"of the torque's RMS and {close} its white noise ({plain(float(run.sensor_std[0]))} {unit})"
        )
    return sentences
