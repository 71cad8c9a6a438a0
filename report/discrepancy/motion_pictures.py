"""Pictures of runs before and after: `Curve`s in; measured and simulated motion with residuals out."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.discrepancy.finding.finding import Curve
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Picture
from haptid.report.common.style import ACCENT, BAND, MEASURED, SIMULATED, figure, style
from haptid.support.linear_algebra import largest_magnitude
from haptid.support.numbers import choose_unit

RUNS_IN_A_ROW = 2
"""Most runs of one picture."""


def before_after_pictures(curves: tuple[Curve, ...]) -> list[Picture]:
    """Draw all runs, two in a picture.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    list of Picture
        As `before_after_picture` draws them.
    """
    return [before_after_picture(curves[k : k + RUNS_IN_A_ROW]) for k in range(0, len(curves), RUNS_IN_A_ROW)]


def before_after_picture(curves: tuple[Curve, ...]) -> Picture:
    """Draw position and residual of the nominal and the final model.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    Picture
        What `before_after_figure` draws.
    """
    unseen = all(curve.run.use == "validate" for curve in curves)
    runs = "Runs that no fit saw" if unseen else "Fitted runs (the campaign has none to validate on)"
    caption = f"{runs}. Above: the motion. Below: what the simulation misses, before and after."
    made = before_after_figure(curves)
    return picture_of(made, caption=caption, alt="measured and simulated position, before and after")


def before_after_figure(curves: tuple[Curve, ...]) -> Figure:
    """Draw position and residual of the nominal and the final model on the first two runs.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    Figure
        A column a run: positions above, residuals with the sensor's ±2σ below.
    """
    shown = curves[:RUNS_IN_A_ROW]
    with style():
        made = figure(8.5, 4.4)
        axes = made.subplots(2, len(shown), squeeze=False, sharex="col", sharey="row", height_ratios=(1, 1.5))
        slides = [p for curve in shown for p in curve.run.prismatic]
        unit, factor = residual_unit(shown)
        for column, curve in enumerate(shown):
            several = len({c.run.free_joints for c in curves}) > 1
            draw_motion(axes[0, column], curve)
            title = curve.run.file + f", joint {curve.run.free_joints[0]}" * several
            axes[0, column].set_title(title, fontsize=8)
            draw_residuals(axes[1, column], curve, factor)
            axes[1, column].set_xlabel("time [s]")
        axes[0, 0].set_ylabel(f"position [{unit_for('rad', slides)}]")
        axes[1, 0].set_ylabel(f"residual [{unit}]")
        for row in axes:
            row[0].legend(fontsize=7, ncols=3, loc="upper center")
            low, high = row[0].get_ylim()
            row[0].set_ylim(low, high + 0.2 * (high - low))
    return made


def draw_motion(axis: Axes, curve: Curve) -> None:
    """Draw measured position and the simulations before and after the search, over time.

    Parameters
    ----------
    axis
        Axes to draw on.
    curve
        Run of one joint with its simulations.
    """
    axis.plot(curve.run.t, curve.run.y[:, 0], color=MEASURED, label="measured", lw=3.0, alpha=0.35)
    axis.plot(curve.run.t, curve.before, color=ACCENT, ls="--", label="simulated before")
    axis.plot(curve.run.t, curve.after, color=SIMULATED, label="simulated after")


def residual_unit(curves: Sequence[Curve]) -> tuple[str, float]:
    """Choose the unit in which what the simulations of runs miss is drawn, in panels of one axis.

    Parameters
    ----------
    curves
        Runs with their simulations.

    Returns
    -------
    unit : str
    factor : float
        As `choose_unit` has them, for what is missed before and after.
    """
    missed = [curve.run.y[:, 0] - simulated for curve in curves for simulated in (curve.before, curve.after)]
    slides = [p for curve in curves for p in curve.run.prismatic]
    return choose_unit(largest_magnitude(*missed), unit_for("rad", slides))


def draw_residuals(axis: Axes, curve: Curve, factor: float) -> None:
    """Draw what the simulations before and after the search miss, with the sensor's ±2σ, over time.

    Parameters
    ----------
    axis
        Axes to draw on.
    curve
        Run of one joint with its simulations.
    factor
        Number in the unit of the axis over the number in rad or m.
    """
    t, y = curve.run.t, curve.run.y[:, 0]
    axis.plot(t, factor * (y - curve.before), color=ACCENT, lw=0.7, label="before")
    axis.plot(t, factor * (y - curve.after), color=SIMULATED, lw=0.7, label="after")
    band = [2 * factor * s * curve.run.sensor_std[0] for s in (-1, 1)]
    axis.axhspan(*band, color=BAND, alpha=0.5, lw=0, label="±2σ of the sensor")
