"""Summary that the command prints: `Step`s and verification in, tables and sentences out.

It has one line per configuration, sentences on what needs attention, and the scores of the whole model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from haptid.identification.fit.zeros_fit import encoder_zeros
from haptid.identification.output.plain_comparison import (
    constant_torques,
    tell_comparison,
    tell_constant_torques,
    tell_delay,
    tell_over_noise,
)
from haptid.identification.output.priors import tell_device_inertia, tell_priors, tell_unused_priors
from haptid.identification.result.fit import RunScore
from haptid.identification.result.outcome import UNCERTAIN, Outcome, tell_status
from haptid.identification.sequence.outcome_sentence import structured_run, tell_outcome
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.units import unit_for
from haptid.support.numbers import plain, says_nothing
from haptid.support.tables import Table, Told

HEADER = ("configuration", "fit/noise", "validate/noise", "starts", "best basin", "fit [s]", "outcome")
"""Headings of the configurations. ``fit [s]`` is `Fit.wall_s`, which is not the time of the command."""
PARAMETER_HEADER = ("parameter", "value", "std", "unit", "status")


def step_row(step: Step) -> tuple[str, ...]:
    """Return the cells of one configuration.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    tuple of str
        Cells in the order of `HEADER`; the scores are the largest RMS over noise of the fitted and validation runs, as
        `tell_over_noise` writes it.
    """
    fit = step.fit
    return (
        step.configuration.name + (" (torque)" if step.torque_scored else ""),
        _worst(step, "fit"),
        _worst(step, "validate"),
        str(fit.starts),
        f"{len(fit.basins[0].starts)} of {fit.starts}",
        f"{fit.wall_s:.1f}",
        fit.outcome.label,
    )


def parameter_rows(step: Step) -> list[tuple[str, ...]]:
    """Return the cells of the parameters of one configuration.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    list of tuple of str
        A row a parameter, and one a constant torque where the plain model is the result, with cells in the order of
        `PARAMETER_HEADER`; no number for one that the runs do not tell,
        and ``uncertain`` in place of ``identified`` where the model does not fit.
    """
    fit = step.fit
    rows: list[tuple[str, ...]] = []
    for quantity, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True):
        status = fit.statuses[quantity.id]
        width = f"{std:.2g}" if std > 0.0 and not says_nothing(std, quantity.lower, quantity.upper) else "-"
        told = ("-", "-") if status == "unidentifiable" else (f"{value:.6g}", width)
        rows.append((quantity.id, *told, quantity.unit, tell_status(status, fit.outcome.label)))
    for one in constant_torques(step):
        known = np.isfinite(one.std)
        rows.append((one.id, *((f"{one.value:.6g}", f"{one.std:.2g}") if known else ("-", "-")), one.unit, one.status))
    return rows


def worst_score(step: Step) -> RunScore | None:
    """Return the score of the run that a fit misses most.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    RunScore or None
        Among the runs that no fit saw, else among the fitted ones; None where there is neither.
    """
    unseen = [score for score in step.fit.runs if score.use == "validate"]
    return max(unseen or step.fit.runs, key=lambda score: score.over_noise, default=None)


def uncertain_ids(step: Step) -> list[str]:
    """List the parameters that the data determine, but in a model that does not fit, as `tell_status` tells.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    list of str
        Empty where the residual is at the noise, and where another outcome says how the fit was made.
    """
    fit = step.fit
    return [id for id, status in fit.statuses.items() if tell_status(status, fit.outcome.label) == UNCERTAIN]


LARGE = 1.5
"""Times the noise from which two digits tell it: 1.14 is no 1.1."""


def tell_uncertain(step: Step) -> str:
    """Say why values of a model that does not fit are uncertain.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str
        As ``uncertain: the model leaves 7.7 times the noise in its worst run``; where the fit is no free simulation,
        that one drifts from the runs.
    """
    if step.fit.outcome in (Outcome.OBSERVED, Outcome.TORQUE_SCORED):
        return "uncertain: a free simulation drifts from the runs"
    worst = worst_score(step)
    if worst is None:
        return "uncertain: the model leaves more than the noise"
    fitted = max((score.over_noise for score in step.fit.runs if score.use == "fit"), default=0.0)
    most, where = max((worst.over_noise, "in its worst run"), (fitted, "in its worst fitted run"))
    return f"uncertain: the model leaves {plain(most, 2 if most >= LARGE else 3)} times the noise {where}"


def _worst(step: Step, use: str) -> str:
    scores = [score for score in step.fit.runs if score.use == use]
    return tell_over_noise(max(scores, key=lambda score: score.over_noise), residual_unit(step)) if scores else "-"


def residual_unit(step: Step) -> str:
    """Return the unit of a step's residual: of position, or of torque where the torque was fitted.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    str
    """
    return unit_for("N m" if step.torque_scored else "rad", step.configuration.runs[0].prismatic)


def tell_summary(steps: Sequence[Step], verification: Mapping[str, Any]) -> Told:
    """Tell what came out of a campaign.

    Parameters
    ----------
    steps
        Fitted configurations.
    verification
        Table ``verification`` of identification.json.

    Returns
    -------
    list
        Table of configurations, the parameters where there is one configuration, the comparison with the plain model,
        sentences that need attention, and the whole model's scores where it was verified.
    """
    told: list[str | Table] = [Table(header=HEADER, rows=[step_row(step) for step in steps], ruled=True)]
    if len(steps) == 1:  # of several joints the table would be longer than a screen; the report has it
        told.append(Table(header=PARAMETER_HEADER, rows=parameter_rows(steps[0]), ruled=True))
    for step in steps:
        compared = tell_comparison(step)
        sentences = [*([] if compared is None else [compared]), *attention(step)]
        told += [f"{step.configuration.name}: {sentence}" for sentence in sentences]
    runs = verification.get("runs", [])
    if runs:
        told.append(
            "Whole model (all joints free), RMS over noise by joint; in brackets over what noise and the uncertainty "
            "of the parameters explain: about 1, and as their error is one draw for a whole run, by chance up to "
            f"{plain(THRESHOLDS.largest_residual_over_expected)}:"
        )
        rows = []
        for run in runs:
            by_joint = [_whole(one) for one in run["joints"]]
            rows.append((run["file"], run["mode"].replace("_", " "), *by_joint))
        numbers = [f"joint {one['joint']}" for one in runs[0]["joints"]]
        told.append(Table(header=("run", "simulated in", *numbers), rows=rows, ruled=True))
    if verification.get("outcome") == "uncertain":
        told.append(
            "Whole model: uncertain: the parameters leave so much open that their spread would hide whatever the model "
            "lacks; run tests in the lock postures that haptid plan (python -m model.plan in a clone) proposes"
        )
    return told


def _whole(joint: Mapping[str, Any]) -> str:
    noise, expected = joint["rmse_over_noise"], joint.get("rmse_over_expected")
    if noise is None:
        return "diverged"
    return f"{noise:.2f}" if expected is None else f"{noise:.2f} ({expected:.2f})"


def attention(step: Step) -> list[str]:
    """List what needs attention in a fit.

    Parameters
    ----------
    step
        Configuration with its fit.

    Returns
    -------
    list of str
        Sentences on outcome, delay of the torque, constant torques of a plain model, parameters at bounds,
        unidentifiable ones, priors that hold or that the runs contradict, an inertia unlike that of the device's file,
        contradictions and missing excitation.
    """
    fit = step.fit
    delay = tell_delay(step)
    quiet = fit.outcome.label == "converged" and structured_run(step) is None
    said = [] if quiet else [tell_outcome(step)]
    said += [] if delay is None else [delay]
    said += tell_constant_torques(step)
    for status, words in (
        ("at_bound", "at the end of the range"),
        ("unidentifiable", "not identifiable from these runs"),
    ):
        ids = [id for id, s in fit.statuses.items() if s == status]
        if ids:
            said.append(f"{words}: {', '.join(ids)}")
    said += tell_priors(fit)
    said += tell_unused_priors(fit)
    said += tell_device_inertia(fit, step.device_inertia)
    uncertain = uncertain_ids(step)
    if uncertain:
        said.append(f"{tell_uncertain(step)}, and what the model lacks may have moved {', '.join(uncertain)}")
    said += [f"contradicts an earlier test: {a.name} (p = {a.p:.1e})" for a in step.agreements if a.contradicts]
    zeros = encoder_zeros(fit)
    if zeros:
        spread = np.ptp(np.array(list(zeros.values())), axis=0)
        far = ", ".join(f"{value:.2g}" for value in spread)
        said.append(f"the encoders' zeros differ by up to {far} {fit.equations.states[0].unit}, fitted run by run")
    return said + list(fit.warnings)
