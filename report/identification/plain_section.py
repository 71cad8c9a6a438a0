"""Section 'Against the plain model': `Step` with the figures of both models in, `Section` out."""

from __future__ import annotations

import math

import numpy as np

from haptid.identification.baseline.baseline import Baseline
from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.figures import Figures
from haptid.identification.baseline.plain_parameters import parameter_ids
from haptid.identification.baseline.prediction import Prediction
from haptid.identification.output.plain_comparison import tell_delay, tell_result
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.result_json import tell_why
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.report.common.numbers import HALF_WIDTH_95, with_error
from haptid.report.common.page import Section, Table
from haptid.report.identification.plain_pictures import plain_picture
from haptid.support.numbers import plain, write_interval

EXPLANATION = (
    "The plain model is inertia, gravity, Coulomb and viscous friction and a constant torque, by least squares of the "
    "torque along the measured motion. Free simulation: RMS of measured minus simulated position of one simulation "
    "from the measured start under the recorded torque. Torque: RMS of measured minus computed torque along the "
    "measured motion, also over the RMS of the measured torque. Horizons: RMS of simulations of 0.1, 1 and 10 s, each "
    "from the measured state."
)


def plain_section(step: Step, baseline: Baseline, compared: Compared, prediction: Prediction | None) -> Section:
    """Show a fit beside the plain model.

    Parameters
    ----------
    step
        Configuration with its fit.
    baseline
        The plain model.
    compared
        Figures of both models.
    prediction
        Signals of an unseen run by both models; None where there is none.

    Returns
    -------
    Section
    """
    why = tell_why(step.fit, torque_scored=step.torque_scored)
    delay = tell_delay(step)
    late = () if delay is None else (f"{delay[0].upper()}{delay[1:]}.",)
    return Section(
        title=f"Against the plain model: {step.configuration.name}",
        anchor=f"{step.configuration.anchor}-plain",
        paragraphs=(f"{tell_result(step)} Why this residual: {why}.", *late, EXPLANATION),
        pictures=() if prediction is None else (plain_picture(prediction),),
        tables=(_run_table(step, compared), _parameter_table(step, baseline, compared)),
    )


def _run_table(step: Step, compared: Compared) -> Table:
    prismatic = step.configuration.runs[0].prismatic
    position, torque = unit_for("rad", prismatic), unit_for("N m", prismatic)
    rows = []
    for (file, use), both in compared.figures.items():
        rows += [(file, use, label, *_cells(both[name])) for name, label in (("model", "fit"), ("baseline", "plain"))]
    header = (
        *("run", "use", "model", f"free simulation [{position}]", f"torque [{torque}]", "torque [%]"),
        *(f"{h:g} s [{position}]" for h in THRESHOLDS.horizons_of_prediction_s),
    )
    return Table(header=header, rows=rows, caption="Errors of both models by run")


def _cells(figures: Figures) -> tuple[str, ...]:
    horizons = [figures.horizon_rmse.get(f"{h:g}") for h in THRESHOLDS.horizons_of_prediction_s]
    return (
        _numbers(figures.free_rmse),
        _numbers(figures.torque_rmse),
        _numbers(100.0 * figures.torque_error, without="-"),
        *("" if rmse is None else _numbers(rmse) for rmse in horizons),
    )


def _numbers(values: Array, *, without: str = "diverged") -> str:
    """Write a number a joint, and ``without`` where there is none."""
    return ", ".join(plain(float(x), 3) if np.isfinite(x) else without for x in values)


def _parameter_table(step: Step, baseline: Baseline, compared: Compared) -> Table:
    """List the plain model's parameters beside those of the fit that mean the same."""
    model = compared.models["model"]
    fitted = dict(zip((q.id for q in model.simulator.equations.parameters), model.theta.tolist(), strict=True))
    names = parameter_ids(baseline, model.simulator.equations.friction)
    # Where the plain model replaced the fit, the errors in the result are those of the plain model.
    known = () if step.fit.outcome is Outcome.PLAIN else step.fit.free
    regressor, estimate = baseline.regressor, baseline.estimate
    rows = []
    for id, unit, value, std in zip(regressor.ids, regressor.units, estimate.theta, estimate.std, strict=True):
        own = names.get(id, "")
        beside = ("", "", "")
        if own in fitted:
            error = step.fit.std[step.fit.index(own)] if own in known else math.nan
            beside = (own, with_error(fitted[own], error), _interval(fitted[own], error))
        rows.append((id, with_error(value, std), _interval(value, std), *beside, unit))
    header = ("parameter", "plain model ± std", "95 % interval", "in the fit", "fit ± std", "95 % interval", "unit")
    return Table(header=header, rows=rows, caption="Parameters of the plain model and of the fit")


def _interval(value: float, std: float) -> str:
    if not (math.isfinite(std) and std > 0):
        return ""
    return write_interval(value - HALF_WIDTH_95 * std, value + HALF_WIDTH_95 * std, 4)
