"""Picture of the friction over the speed: `FrictionLoop`s in, `Picture` out."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from haptid.identification.baseline.friction_loop import FrictionLoop
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Picture
from haptid.report.common.style import MEASURED, SIMULATED, figure, style


def friction_picture(loops: Sequence[FrictionLoop], title: str) -> Picture:
    """Draw friction over speed, as measured and as modelled.

    Parameters
    ----------
    loops
        A run or a joint each.
    title
        Name of the configuration.

    Returns
    -------
    Picture
    """
    files = ", ".join(dict.fromkeys(loop.file for loop in loops))
    caption = (
        f"{title}: friction over speed along the measured motion of {files}. Measured (wide): recorded torque less "
        "what the model needs for inertia, gravity and spring; model (narrow): its friction. Motion and torque are "
        "filtered alike."
    )
    return picture_of(friction_figure(loops), caption=caption, alt=f"{title}, friction torque over speed")


def friction_figure(loops: Sequence[FrictionLoop]) -> Figure:
    """Draw friction over speed.

    Parameters
    ----------
    loops
        As `friction_picture` takes them.

    Returns
    -------
    Figure
        A panel a loop.
    """
    with style():
        made = figure(4.25 * max(len(loops), 2), 3.0)
        axes = made.subplots(1, max(len(loops), 2), squeeze=False)[0]
        for axis in axes[len(loops) :]:
            axis.set_visible(False)
        for axis, loop in zip(axes, loops, strict=False):
            torque, speed = (unit_for(unit, [loop.prismatic]) for unit in ("N m", "rad/s"))
            axis.plot(loop.speed, loop.measured, color=MEASURED, lw=2.4, alpha=0.35, label="measured")
            axis.plot(loop.speed, loop.model, color=SIMULATED, lw=1.1, label="model")
            axis.set_title(f"joint {loop.joint}, {loop.file} ({loop.use})", fontsize=8)
            axis.set_xlabel(f"speed [{speed}]")
            axis.set_ylabel(f"friction [{torque}]")
        axes[0].legend(fontsize=7)
    return made
