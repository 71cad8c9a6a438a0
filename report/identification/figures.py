"""Figures of an identification: traces in, pictures of measured and simulated positions with their residuals out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.identification.output.traces import Trace
from haptid.identification.verification.result import RunCheck
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Picture
from haptid.report.common.style import BAND, MEASURED, RESIDUAL, SIMULATED, figure, style
from haptid.support.linear_algebra import largest_magnitude
from haptid.support.numbers import choose_unit


def run_picture(traces: Sequence[Trace], title: str) -> Picture:
    """Draw measured and simulated signals of runs with their residuals.

    Parameters
    ----------
    traces
        One trace per run, all of the same joints.
    title
        Start of the caption.

    Returns
    -------
    Picture
        Its caption names the files with their uses.
    """
    files = ", ".join(f"{t.score.file} ({t.score.use})" for t in traces)
    caption = (
        f"{title}: measured (wide, grey) and simulated (narrow, blue) above, measured minus simulated (red) with the "
        f"sensor's ±2σ (shaded) below. Runs: {files}."
    )
    made = run_figure(traces)
    return picture_of(made, caption=caption, alt=f"{title}, measured against simulated, with residuals")


def run_figure(traces: Sequence[Trace]) -> Figure:
    """Draw each run in a column: positions above, residual with the noise's ±2σ below.

    Parameters
    ----------
    traces
        One trace per run, all of the same joints.

    Returns
    -------
    Figure
        Two rows of panels a joint.
    """
    rows = 2 * traces[0].measured.shape[1]
    with style():
        made = figure(3.0 * max(len(traces), 2) + 1.0, 1.7 * rows)
        axes = made.subplots(rows, len(traces), sharex="col", squeeze=False, height_ratios=[2, 1] * (rows // 2))
        largest = [max(largest_residual(trace, k) for trace in traces) for k in range(len(traces[0].joints))]
        for column, trace in enumerate(traces):
            for k in range(len(trace.joints)):
                draw_signal(axes[2 * k][column], trace, k, first=column == 0)
                draw_residual(axes[2 * k + 1][column], trace, k, first=column == 0, largest=largest[k])
            axes[0][column].set_title(title_of(trace), fontsize=8)
            axes[-1][column].set_xlabel("time [s]")
        _legend(made, axes[0][0])
    return made


def _legend(made: Figure, axis: Axes) -> None:
    handles, labels = axis.get_legend_handles_labels()
    made.legend(handles, labels, loc="outside lower center", ncols=2)


def title_of(trace: Trace) -> str:
    """Return the run's file, its use and its RMS over the noise, on two lines.

    Parameters
    ----------
    trace
        Signals of the run with its score.

    Returns
    -------
    str
        Title of a panel.
    """
    return f"{trace.score.file}\n{trace.score.use}: RMS = {trace.score.over_noise:.2f} × noise"


def draw_over(axis: Axes, t: Array, measured: Array, simulated: Array) -> None:
    """Draw a simulated signal over a measured one so that both are seen where they agree, in grey as well.

    Parameters
    ----------
    axis
        Axes to draw on.
    t
        Times [s], shape (n_t,).
    measured, simulated
        Signals, shape (n_t,) each.
    """
    axis.plot(t, measured, color=MEASURED, label="measured", linewidth=3.0, alpha=0.35)
    axis.plot(t, simulated, color=SIMULATED, label="simulated", linewidth=1.1)


def draw_signal(axis: Axes, trace: Trace, k: int = 0, *, first: bool = True) -> None:
    """Draw the measured and the simulated signal of one joint over time.

    Parameters
    ----------
    axis
        Axes to draw on.
    trace
        Signals of the run.
    k
        Index of the joint among the free ones.
    first
        Whether the axes get the label of the signal.
    """
    joint = trace.joints[k]
    draw_over(axis, trace.t, trace.measured[:, k], trace.simulated[:, k])
    if first:
        what = "torque" if trace.unit.startswith("N") else "position"
        axis.set_ylabel(f"{what} {joint} [{trace.unit}]")


def largest_residual(trace: Trace, k: int = 0) -> float:
    """Return the largest residual of a joint in a run.

    Parameters
    ----------
    trace
        Signals of the run.
    k
        Index of the joint among the free ones.

    Returns
    -------
    float
        Magnitude in the unit of the trace.
    """
    return largest_magnitude(trace.measured[:, k] - trace.simulated[:, k])


def draw_residual(axis: Axes, trace: Trace, k: int = 0, *, first: bool = True, largest: float | None = None) -> None:
    """Draw measured minus simulated signal of one joint over time, with the sensor's ±2σ.

    Parameters
    ----------
    axis, trace, k, first
        As `draw_signal` takes them.
    largest
        Largest residual of all panels that share the label, which chooses its unit; None for this panel alone.
    """
    unit, factor = choose_unit(largest_residual(trace, k) if largest is None else largest, trace.unit)
    axis.axhspan(-2 * factor * trace.sigma[k], 2 * factor * trace.sigma[k], color=BAND, linewidth=0)
    r = factor * (trace.measured[:, k] - trace.simulated[:, k])
    axis.plot(trace.t, r, color=RESIDUAL, linewidth=0.5)
    _limits(axis, r)
    if trace.scored_from > 0:
        axis.axvline(trace.scored_from, color=MEASURED, linewidth=0.8, linestyle=":")
    if first:
        axis.set_ylabel(f"residual [{unit}]")


def _limits(axis: Axes, r: Array) -> None:
    reach = float(np.nanmax(np.abs(r))) if np.isfinite(r).any() else 1.0
    axis.set_ylim(-1.1 * reach, 1.1 * reach)


def whole_picture(check: RunCheck) -> Picture:
    """Draw measured and simulated positions of all joints in one run of the whole model, each above its residual.

    Parameters
    ----------
    check
        Verification of the whole model on the run.

    Returns
    -------
    Picture
        A panel a joint with its RMS error; the caption says how the run was simulated.
    """
    n = check.measured.shape[1]
    with style():
        rows = (n + 1) // 2
        made = figure(9.0, 2.6 * rows + 0.6)
        axes = made.subplots(2 * rows, 2, sharex=True, squeeze=False, height_ratios=[2, 1] * rows)
        for k, one in enumerate(check.joints):
            above: Axes = axes[2 * (k // 2)][k % 2]
            below: Axes = axes[2 * (k // 2) + 1][k % 2]
            unit = unit_for("rad", [one.prismatic])
            draw_over(above, check.t, check.measured[:, k], check.simulated[:, k])
            above.set_title(f"joint {one.joint}: RMS = {one.rmse_rad:.2g} {unit}", fontsize=8)
            above.set_ylabel(f"position [{unit}]")
            missed = check.measured[:, k] - check.simulated[:, k]
            shown, factor = choose_unit(largest_magnitude(missed), unit)
            noise = factor * one.rmse_rad / one.rmse_over_noise
            if np.isfinite(noise):
                below.axhspan(-2 * noise, 2 * noise, color=BAND, linewidth=0)
            r = factor * missed
            below.plot(check.t, r, color=RESIDUAL, linewidth=0.7)
            _limits(below, r)
            below.set_ylabel(f"residual [{shown}]")
        if n % 2:
            for axis in axes[-2:, 1]:
                axis.set_visible(False)
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        _legend(made, axes[0][0])
    kind = check.mode.replace("_", " ")
    return picture_of(
        made, caption=f"{check.file}, {kind}: {check.sentence}.", alt=f"all joints of {check.file}, {kind}"
    )
