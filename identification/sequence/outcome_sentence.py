"""Say how a fitted configuration ended, as summary, report and identification.json do: `Step` in, a sentence out."""

from __future__ import annotations

from haptid.identification.baseline.delay import Delay
from haptid.identification.result.fit import RunScore
from haptid.identification.result.outcome import LONELY_NEAR_THE_DATA, MODEL_DOES_NOT_FIT, Outcome
from haptid.identification.sequence.step import Step
from haptid.identification.statistics.score import residual_over_motion
from haptid.identification.thresholds import THRESHOLDS
from haptid.support.numbers import plain

LINEAR_HOLD = 'hold = "linear" in campaign.toml (or haptid init --hold linear)'
"""What to state where the torque runs linearly between its rows."""
LITTLE_MORE_THAN_NOISE = {
    Outcome.CONVERGED: "converged: several starts agree on the best minimum; {}: haptid missing may name it",
    Outcome.SINGLE_START: "only one start reached the best minimum; {}: raise --starts, then try haptid missing",
}
"""Sentences of outcomes at the noise where a run leaves structure as well."""


def tell_outcome(step: Step) -> str:
    """Say how the fit ended; where the torque seems to be held by mistake, this takes the place of the usual remedies.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str
        Without a full stop.
    """
    outcome = step.fit.outcome
    structured = structured_run(step)
    if structured is not None:
        left = plain(structured.unexplained, 3)
        over = f"{structured.file} leaves {left} times the noise, and what is left is not white"
        return LITTLE_MORE_THAN_NOISE[outcome].format(over)
    if outcome not in MODEL_DOES_NOT_FIT or not seems_held_by_mistake(step):
        return LONELY_NEAR_THE_DATA if outcome is Outcome.LONELY and follows_motion(step) else outcome.value
    return f"{outcome.value.partition(';')[0]}; first state {LINEAR_HOLD}"


def structured_run(step: Step) -> RunScore | None:
    """Return a run of which a fit at the noise leaves somewhat more than noise, and not by chance.

    Outcomes allow a run that its noise differs from the pooled one; noise that differs is white all the same.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    RunScore or None
        The one with the largest residual over the noise, of those that no fit saw where there are such; None where it
        leaves the noise, or white noise of another size.
    """
    if step.fit.outcome not in LITTLE_MORE_THAN_NOISE:
        return None
    unseen = [score for score in step.fit.runs if score.use == "validate"]
    worst = max(unseen or step.fit.runs, key=lambda score: score.unexplained, default=None)
    if worst is None or worst.unexplained <= THRESHOLDS.largest_residual_as_noise or not worst.is_correlated:
        return None
    return worst


def follows_motion(step: Step) -> bool:
    """Say whether a fit leaves so little of the motion that columns and units must be right.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    bool
        False for a residual torque, which is no share of a motion.
    """
    files = {score.file for score in step.fit.runs if score.use == "fit"}
    runs = [run for run in step.configuration.runs if run.use == "fit" and run.file in files]
    if step.torque_scored or not runs:
        return False
    return residual_over_motion(runs, step.fit.runs) <= THRESHOLDS.largest_residual_near_the_data_over_motion


def seems_held_by_mistake(step: Step) -> bool:
    """Say whether a torque that is held between rows acts half a row early, as one does that runs linearly there.

    The hold then is the whole of the delay. A delay of which it may be a part is told beside the plain model alone.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    bool
        False also where no delay earned its place.
    """
    delay = delay_of_held_torque(step)
    return delay is not None and rows_from_linear(delay) <= THRESHOLDS.largest_distance_from_half_a_row


def delay_of(step: Step) -> Delay | None:
    """Return the delay between torque and motion.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    Delay or None
        None where none earned its place.
    """
    return None if step.baseline is None else step.baseline.delay


def delay_of_held_torque(step: Step) -> Delay | None:
    """Return the delay of a torque that is held between its rows in every fitted run.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    Delay or None
        None where the torque is not held, or no delay earned its place.
    """
    is_held = all(run.hold == "zero" for run in step.configuration.runs if run.use == "fit")
    return delay_of(step) if is_held else None


def rows_from_linear(delay: Delay) -> float:
    """Return the distance between a delay and that of a torque that runs linearly but is held: half a row early.

    Parameters
    ----------
    delay
        Delay between torque and motion.

    Returns
    -------
    float
        Distance in rows [1].
    """
    return abs(delay.rows + 0.5)
