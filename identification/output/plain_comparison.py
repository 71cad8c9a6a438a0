"""The fit beside the plain model, in words: `Step` in, sentences out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.figures import Figures
from haptid.identification.result.fit import RunScore
from haptid.identification.result.outcome import Outcome, tell_status
from haptid.identification.sequence.outcome_sentence import (
    LINEAR_HOLD,
    delay_of,
    delay_of_held_torque,
    rows_from_linear,
    seems_held_by_mistake,
)
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.units import unit_for
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.support.linear_algebra import column_rms
from haptid.support.numbers import plain, with_prefix


def is_above_noise(step: Step) -> bool:
    """Say whether the fit leaves more than the sensor's noise on a run of any use.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    bool
        True also where a simulation is not finite.
    """
    largest = max((score.over_noise for score in step.fit.runs), default=0.0)
    # Written with `not … <=`: a NaN of a simulation that is not finite counts as above the noise.
    return not largest <= THRESHOLDS.largest_residual_as_noise


def tell_comparison(step: Step) -> str | None:
    """Write torque error and free simulation of both models on the runs that no fit saw.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str or None
        As ``torque error 4.0 % (plain model 4.1 %), free simulation 6.1 mm (6.9 mm) on unseen runs``; None where the
        fit is at the noise or nothing was compared. Several joints are separated by slashes.
    """
    if step.compared is None or step.compared.baseline is None or not is_above_noise(step):
        return None
    use = "validate" if any(use == "validate" for _, use in step.compared.figures) else "fit"
    figures = [both for (_, of), both in step.compared.figures.items() if of == use]
    prismatic = step.configuration.runs[0].prismatic
    if not any(np.isfinite(one.torque_error).any() for both in figures for one in both.values()):
        return None  # a free swing has no torque that an error is a share of
    torque, free = {}, {}
    for name in ("model", "baseline"):
        own = [both[name] for both in figures]
        torque[name] = _percentages(own)
        free[name] = _positions(own, prismatic)
    return (
        f"torque error {torque['model']} (plain model {torque['baseline']}), "
        f"free simulation {free['model']} ({free['baseline']}) on {'unseen' if use == 'validate' else 'fitted'} runs"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantTorque:
    """The constant torque of a joint in a plain model that is the result.

    Parameters
    ----------
    id
        ``offset``, with the joint's number where several are free.
    value, std
        Torque [N m] ([N]) and its standard deviation, NaN where the runs do not tell the torque.
    unit
        Unit of both.
    carried_by
        What carries it in the parameters of the equations and in the FMU: ``Ks`` and ``epos``, or ``gravity_cos``.
    """

    id: str
    value: float
    std: float
    unit: str
    carried_by: tuple[str, ...]

    @property
    def status(self) -> str:
        """Word that is told of it, as of every parameter of the plain model."""
        return tell_status("identified" if np.isfinite(self.std) else "unidentifiable", Outcome.PLAIN.label)


def constant_torques(step: Step) -> list[ConstantTorque]:
    """Return the constant torques of a plain model that is the result: the equations have no parameter of that name.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    list of ConstantTorque
        One a joint; empty where the plain model is not the result, or is not at hand.
    """
    baseline = step.baseline
    if step.fit.outcome is not Outcome.PLAIN or baseline is None:
        return []
    ids = {q.id for q in step.fit.equations.parameters}
    regressor, estimate = baseline.regressor, baseline.estimate
    found = []
    for k, suffix in enumerate(id_suffixes(regressor.joints)):
        at = regressor.ids.index(f"offset{suffix}")
        spring = (f"Ks{suffix}", f"epos{suffix}")
        slides = step.configuration.runs[0].prismatic[k] and f"gravity_cos{suffix}" in ids
        found.append(
            ConstantTorque(
                id=f"offset{suffix}",
                value=float(estimate.theta[at]),
                std=float(estimate.std[at]),
                unit=regressor.units[at],
                carried_by=(f"gravity_cos{suffix}",) if slides else spring,
            )
        )
    return found


def tell_constant_torques(step: Step) -> list[str]:
    """Say which parameters stand for the constant torques, whose values would be read as those of a spring.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    list of str
        As ``Ks and epos stand for the constant torque offset = -Ks·epos = 0.061 ± 0.002 N m: …``, one a joint; a slide
        has its constant force in ``gravity_cos``.
    """
    told = []
    for one in constant_torques(step):
        spread = f" ± {plain(one.std, 2)}" if np.isfinite(one.std) else ""
        size = f"{plain(one.value, 3)}{spread} {one.unit}"
        if len(one.carried_by) == 1:
            told.append(f"{one.carried_by[0]} holds the constant force {one.id} = {size}, too")
            continue
        stiffness, end = one.carried_by
        told.append(
            f"{stiffness} and {end} stand for the constant torque {one.id} = -{stiffness}·{end} = {size}: no such "
            "spring was found, and its end is no place of the joint"
        )
    return told


def _may_run_linearly(step: Step) -> bool:
    """Say whether the torque would have less of a delay if it ran linearly, as far as the delay's error tells."""
    delay = delay_of_held_torque(step)
    if delay is None:
        return False
    std_rows = delay.std * abs(delay.rows / delay.value) if delay.value else 0.0
    return rows_from_linear(delay) + std_rows <= THRESHOLDS.nearer_to_half_a_row


def tell_delay(step: Step) -> str | None:
    """Tell the delay between torque and motion, where one earned its place.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str or None
        As ``the torque acts 2.1 ± 0.3 ms (1.05 rows) after it is recorded``, and whether the fit has it, or what to
        state where it is that of a torque that runs linearly between rows; None without a delay.
    """
    delay = delay_of(step)
    if delay is None:
        return None
    late = "after" if delay.value > 0 else "before"
    size, rows = with_prefix(abs(delay.value), "s", 2), plain(abs(delay.rows))
    acts = f"the torque acts {size} ± {with_prefix(delay.std, 's', 2)} ({rows} rows) {late} it is recorded"
    if seems_held_by_mistake(step):
        return f'{acts}, as one that runs smoothly between rows does where hold = "zero" holds it: state {LINEAR_HOLD}'
    has = step.torque_scored or step.fit.outcome is Outcome.PLAIN
    told = "fit and plain model have this delay" if has else "the plain model has this delay, the fit has none"
    if _may_run_linearly(step):
        return (
            f'{acts}: {told}; a torque that runs smoothly between rows, held by hold = "zero", acts half a row before: '
            f"try {LINEAR_HOLD}"
        )
    if delay.value < 0:
        return (
            f"{acts}: {told}. No torque acts before it is there: the recording filters or dates the two differently, "
            "or what the model lacks looks like it"
        )
    return f"{acts}: {told}; an exported FMU wants the torque at the time at which it acts"


def _percentages(figures: list[Figures]) -> str:
    # A free swing has no torque that an error is a share of.
    known = [one.torque_error for one in figures if np.isfinite(one.torque_error).all()]
    shares = column_rms(known or [one.torque_error for one in figures])
    return "/".join(plain(100 * share) if np.isfinite(share) else "-" for share in shares) + " %"


def _positions(figures: list[Figures], prismatic: tuple[bool, ...]) -> str:
    positions = column_rms([one.free_rmse for one in figures])
    told = [tell_size(x, unit_for("rad", [slides])) for x, slides in zip(positions, prismatic, strict=True)]
    return "/".join(told)


def tell_size(value: float, unit: str) -> str:
    """Write a quantity with its unit.

    Parameters
    ----------
    value
        Quantity in ``unit``.
    unit
        SI unit without prefix.

    Returns
    -------
    str
        Two digits with a prefix that suits, or ``diverged`` where the value is not finite.
    """
    return with_prefix(value, unit, 2) if np.isfinite(value) else "diverged"


def tell_result(step: Step) -> str:
    """Say which of the two models is the result, and why.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str
        A sentence.
    """
    compared = step.compared
    if compared is None or compared.baseline is None:
        return "The fit is the result: the fitted runs have too few rows for the plain model."
    if step.fit.outcome is Outcome.PLAIN:
        return (
            "The plain model is the result: it predicts the torque and the next second of motion of the runs that no "
            f"fit saw better than the fit does{_tell_of_farther(compared)}."
        )
    if not is_above_noise(step):
        return "The fit is the result: what it leaves is the sensor's noise."
    if not np.isfinite(compared.badness("model", "validate")):
        return "The fit is the result: neither model could be judged on runs that no fit saw."
    drive = step.fit.equations.drive
    by_motor = drive is not None and not drive.commands_torque
    return f"The fit is the result: {_tell_of_unseen(compared, by_motor=by_motor)}."


def _tell_of_farther(compared: Compared) -> str:
    """Say where the plain model, which is the result, strays farther in a free simulation of whole unseen runs."""
    unseen = [both for (_, use), both in compared.figures.items() if use == "validate"]
    if any("model" not in both or "baseline" not in both for both in unseen):
        return ""
    fitted, plain_model = (column_rms([both[name].free_rmse for both in unseen]) for name in ("model", "baseline"))
    if not np.all(plain_model <= fitted):  # one that does not stay finite strays farther, too
        return "; simulated freely over whole runs it strays farther"
    return ""


def _tell_of_unseen(compared: Compared, *, by_motor: bool) -> str:
    """Say what the runs that no fit saw tell of both models, where the fit is the result."""
    if compared.plain_is_better and by_motor:
        return (
            "the plain model predicts torque and one second of motion of the runs that no fit saw better, but stands "
            "on the torque that this fit gives the drive, so that it cannot replace it"
        )
    if compared.plain_is_better:
        return (
            "its residual on the fitted runs is the sensor's noise, although the plain model predicts torque and one "
            "second of motion of the runs that no fit saw better"
        )
    if compared.badness("baseline", "validate") < compared.badness("model", "validate"):
        return (
            "it simulates the runs that no fit saw better than the plain model does, which predicts their torque better"
        )
    return "it predicts the runs that no fit saw better than the plain model does"


def tell_over_noise(score: RunScore, unit: str) -> str:
    """Write the residual of a run over the noise and, where that says little, as a quantity and a share of the motion.

    Parameters
    ----------
    score
        Score of the run.
    unit
        Unit of its residual.

    Returns
    -------
    str
        As ``1.02`` or ``207 (61 mm, 12 % of the range)``.
    """
    over = score.over_noise
    shown = f"{over:.0f}" if over > THRESHOLDS.largest_residual_in_noise else f"{over:.3f}"
    return shown + tell_size_and_share(score, unit)


def tell_size_and_share(score: RunScore, unit: str) -> str:
    """Write a residual far above the noise as a quantity and a share of the motion.

    Parameters
    ----------
    score
        Score of the run.
    unit
        Unit of its residual.

    Returns
    -------
    str
        As `` (61 mm, 12 % of the range)``; empty where the residual over the noise is small enough to say something.
    """
    if not score.over_noise > THRESHOLDS.largest_residual_in_noise:
        return ""
    return f" ({tell_size(score.rmse_rad, unit)}, {plain(100 * score.nrmse)} % of the range)"
