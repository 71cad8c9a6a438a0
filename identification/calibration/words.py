"""What a calibration says: `Outcome` and `Calibration` in, sentences and the command's summary out."""

from __future__ import annotations

import numpy as np

from haptid.identification.calibration.calibrate import Calibration
from haptid.identification.calibration.remarks import remarks_on
from haptid.identification.calibration.simulator import ForeignSimulator
from haptid.identification.output.priors import tell_priors
from haptid.identification.result.outcome import Outcome, tell_status
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.support.tables import Table, Told

SENTENCES = {
    Outcome.CONVERGED: "several starts agree on the best minimum, and what is left is the outputs' noise",
    Outcome.ABOVE_NOISE: (
        "several starts agree on the best minimum, but the residual stays above the noise: the model lacks something, "
        "a start value is not that of the run, or the noise is stated too small"
    ),
    Outcome.SINGLE_START: (
        "only one start reached the best minimum, which leaves the noise; raise --starts to be sure that it is the best"
    ),
    Outcome.LONELY: (
        "only one start reached the best minimum, and it lies above the noise; look whether columns, units and start "
        "values are right, then raise --starts"
    ),
    Outcome.FIXED: "no parameter is free, so that nothing was fitted: the scores are those of the FMU as it is stated",
    Outcome.UNSEEN: (
        "the fitted runs are at the noise, but runs that no fit saw are not: look whether their columns and start "
        "values are right"
    ),
    Outcome.TOO_FEW_ROWS: (
        "the fitted runs hold too few rows for so many parameters, so that a small residual says nothing: measure "
        "longer, or fix parameters"
    ),
}
"""Sentence of each outcome that a calibration may have."""
HEADER = ("variable", "value", "std", "unit", "status")
RUNS = ("run", "use", "output", "RMS", "RMS / noise")
CHECKED = ("run", "use", "rows", "seconds", "output", "range", "noise")


def sentence_of(outcome: Outcome) -> str:
    """Return the sentence of an outcome, without joints and torques.

    Parameters
    ----------
    outcome
        Outcome of a fit.

    Returns
    -------
    str
        Words of `SENTENCES`, or the outcome's value where it has none there.
    """
    return SENTENCES.get(outcome, outcome.value)


def parameter_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """Return the cells of `HEADER`, a row for each parameter.

    Parameters
    ----------
    calibration
        A calibrated FMU.

    Returns
    -------
    list of tuple of str
        Name, value, standard deviation (empty where it is 0), unit and status.
    """
    fit = calibration.fit
    rows: list[tuple[str, ...]] = []
    for q, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True):
        told = tell_status(fit.statuses[q.id], fit.outcome.label)
        rows.append((q.structured, f"{value:.6g}", f"{std:.2g}" if std else "", q.unit, told))
    return rows


def run_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """Return the cells of `RUNS`, a row for each run and output.

    Parameters
    ----------
    calibration
        A calibrated FMU.

    Returns
    -------
    list of tuple of str
        File, use, output, RMSE in the output's unit, and RMSE over the noise.
    """
    rows: list[tuple[str, ...]] = []
    sigma = {run.file: run.sensor_std for run in calibration.campaign.runs}
    for score in calibration.fit.runs:
        for name, rmse, noise in zip(calibration.campaign.outputs, score.rmse, sigma[score.file], strict=True):
            rows.append((score.file, score.use, name, f"{rmse:.3g}", f"{rmse / noise:.2f}"))
    return rows


def tell_check(campaign: ForeignCampaign, simulator: ForeignSimulator) -> Told:
    """Tell what `measurement.check` says of a campaign about an FMU.

    Parameters
    ----------
    campaign
        Runs and variables.
    simulator
        The FMU, whose variables were checked.

    Returns
    -------
    list
        Head, and a table with a row for each run and output; "~" marks a noise that was estimated. Last, what the FMU's
        description says against its use.
    """
    fmu, parameters = simulator.fmu, simulator.equations.parameters
    kind = "co-simulation" if fmu.interface == "CoSimulation" else "model exchange"
    by_use = [f"{sum(run.use == use for run in campaign.runs)} {use}" for use in ("fit", "validate", "excluded")]
    rows = []
    for run in campaign.runs:
        for k, name in enumerate(campaign.outputs):
            mark = "" if campaign.noise_given[name] else "~"
            size, noise = f"{np.ptp(run.y[:, k]):.3g}", f"{mark}{run.sensor_std[k]:.2g}"
            rows.append((run.file, run.use, str(run.t.size), f"{run.t[-1]:.4g}", name, size, noise))
    free = ", ".join(q.structured for q in parameters if not q.fixed) or "none"
    head = (
        f"{campaign.title}\n{fmu.path.name} (FMI {fmu.description.fmiVersion}, {kind}), {campaign.label} data, "
        f"{len(campaign.runs)} runs ({', '.join(by_use)}), inputs {', '.join(campaign.inputs) or 'none'}, "
        f"parameters to fit {free}"
    )
    remarks = (f"\n{remark}" for remark in remarks_on(campaign, fmu))
    return [f"{head}\n", Table(header=CHECKED, rows=rows, ruled=True), *remarks]


def attention(calibration: Calibration) -> list[str]:
    """List what needs attention: parameters, runs to check on, the FMU's description.

    Parameters
    ----------
    calibration
        A calibrated FMU.

    Returns
    -------
    list of str
        A sentence each; empty where nothing needs attention.
    """
    said = []
    for status, words in (
        ("at_bound", "at a bound"),
        ("unidentifiable", "not identifiable from these runs"),
    ):
        ids = [q.structured for q in calibration.fit.equations.parameters if calibration.fit.statuses[q.id] == status]
        if ids:
            said.append(f"{words}: {', '.join(ids)}")
    said += tell_priors(calibration.fit, {q.id: q.structured for q in calibration.fit.equations.parameters})
    if not any(run.use == "validate" for run in calibration.campaign.runs):
        said.append('no run has use = "validate": nothing tells how well the FMU predicts')
    return [*said, *calibration.remarks]


def tell_summary(calibration: Calibration) -> Told:
    """Tell what the command tells at its end: parameters, runs, outcome, and what needs attention.

    Parameters
    ----------
    calibration
        A calibrated FMU.

    Returns
    -------
    list
        Tables and sentences with a blank line between them.
    """
    fit = calibration.fit
    reached = f"{len(fit.basins[0].starts)} of {fit.starts} starts share the best minimum, " if fit.free else ""
    how = f"{reached}{fit.simulations} simulations, {fit.wall_s:.1f} s"
    told: list[str | Table] = []
    if fit.equations.parameters:
        told += [Table(header=HEADER, rows=parameter_rows(calibration), ruled=True), ""]
    told += [Table(header=RUNS, rows=run_rows(calibration), ruled=True), "", f"{sentence_of(fit.outcome)} ({how})"]
    for sentence in attention(calibration):
        told += ["", sentence]
    return told
