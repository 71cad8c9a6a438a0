"""Encoder zeros that differ from run to run: a fit above the noise in, the fit with a zero of each run out, or none.

An incremental encoder is zeroed where the joint happens to rest, so that forces at a position (weight, spring) act
elsewhere in every run than the reading says. Each joint whose forces depend on its position gets a zero a run, a state
with an unknown start value beside position and velocity (`model.joint.encoder_zero`). Parameters keep their meaning.

1. Fit again from the estimates, with the zeros: one start, and several where it comes near what zeros have to reach.
   Their prior is N(0, w²), with w a share of the joint's travel.
2. Take the zeros where they leave clearly less on the fitted runs: by a factor in the RMS, and by BIC with as many rows
   as the residual is long in correlation lengths, n·ln(S/S₀) + k·ln n < 0 with k zeros.
3. Leave them where one lies far outside its prior: a constant torque of the run, which a weak spring turns into a zero
   of any size, is no place of the encoder. Leave them, too, where they predict the runs that no fit saw worse.

On a run that no fit saw the first rows give the zero, as they give the initial position: the rest is a prediction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.fit.multistart import from_optimum
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.encoder_zero import is_felt, with_encoder_zeros, without_encoder_zeros, zero_states
from haptid.support.errors import NumericalError
from haptid.support.linear_algebra import rms


def fit_with_zeros(
    fit_equations: Callable[[Equations, FitOptions], Fit],
    try_equations: Callable[[Equations, FitOptions], Fit],
    found: Fit,
    runs: Sequence[Run],
    options: FitOptions,
) -> Fit | None:
    """Fit once more with an encoder zero of every run.

    Parameters
    ----------
    fit_equations
        Function that fits equations with options.
    try_equations
        Function that fits them within their ranges as they are.
    found
        Fit by simulation that takes the readings for positions.
    runs
        All runs of the configuration.
    options
        Choices of the fit.

    Returns
    -------
    Fit or None
        None where no force depends on a position, where fewer than two runs are fitted (one run's zero is part of the
        spring's and the weight's parameters), where the fit fails, and where the zeros do not clearly earn their place.
    """
    fitted = [run for run in runs if run.use == "fit"]
    joints = range(len(found.equations.joints))
    if len({run.file for run in fitted}) < 2 or not any(is_felt(found.equations, k) for k in joints):
        return None
    share = THRESHOLDS.encoder_zero_std_over_travel
    travel = np.max([np.ptp(run.y, axis=0) for run in fitted], axis=0)
    equations = with_encoder_zeros(found.equations, [share * float(length) for length in travel])
    again = from_optimum(found, options)
    try:
        # One start says whether the zeros promise anything; whatever else is missing they hardly change.
        if not _promise(try_equations(equations, again.but(starts=1)), found):
            return None
        zeroed = fit_equations(equations, again)
    except NumericalError:
        return None
    return zeroed.but(notes=(*zeroed.notes, *_sentences(zeroed))) if _earn_their_place(zeroed, found, fitted) else None


def _promise(tried: Fit, found: Fit) -> bool:
    """Say whether one start with zeros comes near the share of the residual that several have to reach."""
    most = THRESHOLDS.largest_residual_of_first_start_with_zeros
    return tried.basins[0].over_noise <= most * found.basins[0].over_noise


def _earn_their_place(zeroed: Fit, found: Fit, fitted: Sequence[Run]) -> bool:
    if not _are_places(zeroed) or _over_noise_unseen(zeroed) > _over_noise_unseen(found):
        return False
    before, after = found.basins[0].over_noise, zeroed.basins[0].over_noise
    if not 0.0 < after <= THRESHOLDS.largest_residual_with_zeros_over_without * before:
        return False
    rows = sum(run.y.size for run in fitted) / max(zeroed.correlation_time, found.correlation_time, 1.0)
    zeros = len(zero_states(zeroed.equations)) * len(fitted)
    return 2.0 * rows * np.log(before / after) > zeros * np.log(max(rows, 2.0))


def _are_places(zeroed: Fit) -> bool:
    """Say whether every zero of a fitted run lies within reach of its prior N(0, w²)."""
    states = list(zero_states(zeroed.equations))
    width = np.array([zeroed.equations.states[k].start_std for k in states])
    reach = THRESHOLDS.largest_encoder_zero_in_std * width
    return all(bool(np.all(np.abs(x0[states]) <= reach)) for x0 in zeroed.x0.values())


def _over_noise_unseen(fit: Fit) -> float:
    """RMS residual over the noise on the runs that no fit saw; 0 where there are none."""
    unseen = [score.over_noise for score in fit.runs if score.use != "fit"]
    return rms(unseen) if unseen else 0.0


def encoder_zeros(fit: Fit) -> dict[str, Array]:
    """Return the encoder zeros of a fit.

    Parameters
    ----------
    fit
        Any fit.

    Returns
    -------
    dict
        Reading at position 0 of every joint, shape (n_joints,), [rad] or [m], by the file of the run; empty where
        readings are positions. The parts of a file that is fitted in one part and held out in the other share theirs.
    """
    states = list(zero_states(fit.equations))
    if not states:
        return {}
    held_out = {score.file: score.x0[states] for score in fit.runs}
    return held_out | {file: x0[states] for file, x0 in fit.x0.items()}


def correct_readings(runs: Sequence[Run], zeros: Mapping[str, Array]) -> tuple[Run, ...]:
    """Take the encoder's zero out of the readings of every run.

    Parameters
    ----------
    runs
        Runs of one configuration.
    zeros
        Reading at position 0 of every joint, shape (n_joints,), [rad] or [m], by the file of the run.

    Returns
    -------
    tuple of Run
        The same runs with positions y − z₀ in place of readings; runs without a known zero as they are.
    """
    return tuple(replace(run, y=run.y - zeros[run.file]) if run.file in zeros else run for run in runs)


def in_positions(fit: Fit) -> Fit:
    """Turn a fit of readings into the same fit of positions, for runs that `correct_readings` has corrected.

    Parameters
    ----------
    fit
        Fit with encoder zeros, or without.

    Returns
    -------
    Fit
        Its initial states have positions for readings, and no zeros.
    """
    states = list(zero_states(fit.equations))
    if not states:
        return fit

    def turn(x0: Array) -> Array:
        positions = x0.copy()
        positions[: len(states)] -= x0[states]
        return np.delete(positions, states)

    return fit.but(
        equations=without_encoder_zeros(fit.equations),
        x0={file: turn(x0) for file, x0 in fit.x0.items()},
        runs=tuple(replace(score, x0=turn(score.x0)) for score in fit.runs),
    )


def _sentences(fit: Fit) -> tuple[str, ...]:
    zeros = np.array([zero for _, zero in sorted(encoder_zeros(fit).items())])
    parts = [
        f"joint {joint} {low:.3g} to {high:.3g}"
        for joint, low, high in zip(fit.equations.joints, zeros.min(axis=0), zeros.max(axis=0), strict=True)
    ]
    unit = fit.equations.states[0].unit
    return (f"readings at position 0, fitted run by run: {', '.join(parts)} {unit}",)
