"""What is missing without a name: `Shape` in; the section on a torque over one or two variables out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from haptid.discrepancy.detect.localise import AXES
from haptid.discrepancy.unnamed.missing_torque import Shape
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import with_error
from haptid.report.common.page import Picture, Section, Table
from haptid.report.common.style import MEASURED, RESIDUAL, figure, style

LEAST_SHARE_EXPLAINED = 0.5
"""Share of the model discrepancy below which a torque over one or two variables does not explain most of it [1]."""


def unnamed_section(shape: Shape, runs: str, joints: Sequence[int], slides: Sequence[bool]) -> Section:
    """Show the missing torque as a function of one or two variables.

    Parameters
    ----------
    shape
        Torque with its standard error.
    runs
        Runs on which its share of the gap was measured, in words.
    joints
        Free joints of the study.
    slides
        Whether each of them is prismatic.

    Returns
    -------
    Section
    """
    names = " and ".join(AXES[variable][0] for variable in shape.variables)
    prismatic = [slides[joints.index(shape.joint)]]
    joint = f" in joint {shape.joint}" if len(joints) > 1 else ""
    closed = _write_closed(shape)
    missing, whole = ("what the named effects leave", "it") if shape.beside else ("what is missing", "the gap")
    lines = [f"As a torque{joint} over {names} alone, {missing} would close {closed} of {whole} on {runs}."]
    if shape.alone:
        lines.append(f"Over {AXES[shape.alone.variables[0]][0]} alone it would close {_write_closed(shape.alone)}.")
    if len(joints) > 1 and "position_rad" in shape.variables:
        lines.append(
            "Gravity in the nominal model bends with position too: the nominal model may hold a part of the bend."
        )
    if shape.closed < LEAST_SHARE_EXPLAINED:
        lines.append("Most of it does not live there: it depends on other variables, or has a state of its own.")
    if shape.suggestion:
        lines.append(f"A formula that follows it, a suggestion and no finding: {shape.suggestion}.")
    return Section(
        title="What is left, without a name" if shape.beside else "What is missing, without a name",
        anchor="shape",
        paragraphs=lines,
        pictures=[shape_picture(shape, prismatic)],
        tables=[] if shape.alone else [_curve(shape, prismatic)],
    )


def _write_closed(shape: Shape) -> str:
    return f"{100 * max(shape.closed, 0.0):.1f} %"


def _curve(shape: Shape, prismatic: Sequence[bool]) -> Table:
    rows = zip(shape.knots[0], shape.torque, shape.std, strict=True)
    return Table(
        header=(_axis(shape.variables[0], prismatic), f"torque ± std [{unit_for('N m', prismatic)}]"),
        rows=[(f"{x:.4g}", with_error(y, std)) for x, y, std in rows],
    )


def _axis(variable: str, prismatic: Sequence[bool]) -> str:
    name, turning = AXES[variable]
    return f"{name} [{unit_for(turning, prismatic)}]"


def shape_picture(shape: Shape, prismatic: Sequence[bool]) -> Picture:
    """Draw the missing torque over one variable with a band of two standard errors, or over two beside its error.

    Parameters
    ----------
    shape
        Torque with its standard error over one or two variables.
    prismatic
        Whether the joint is prismatic, for the units.

    Returns
    -------
    Picture
        Its caption says what the nominal model can hold and is left out.
    """
    names = " and ".join(AXES[variable][0] for variable in shape.variables)
    with style():
        made = figure(8.5 if shape.alone else 5.6, 2.8)
        draw = _surface if shape.alone else _line
        draw(made, shape, prismatic)
    band = "its standard error beside it" if shape.alone else "with ±2 standard errors"
    lacks = "the named effects leave" if shape.beside else "the nominal model lacks"
    caption = (
        f"The torque that {lacks}, counted as the drive's is, as a function of {names} fitted together "
        f"with all its parameters, {band}. What springs, friction and gain of the nominal model hold, a constant "
        "and straight lines over position, speed or torque, is left out."
    )
    return picture_of(made, caption=caption, alt=f"missing torque over {names}")


def _line(made: Figure, shape: Shape, prismatic: Sequence[bool]) -> None:
    axis, (knots,) = made.subplots(), shape.knots
    axis.axhline(0.0, color=MEASURED, lw=0.5)
    axis.fill_between(
        knots, shape.torque - 2 * shape.std, shape.torque + 2 * shape.std, color=RESIDUAL, alpha=0.3, lw=0
    )
    axis.plot(knots, shape.torque, color=RESIDUAL, marker="o", ms=2.5, lw=1)
    axis.set_xlabel(_axis(shape.variables[0], prismatic))
    axis.set_ylabel(f"missing torque [{unit_for('N m', prismatic)}]")


def _surface(made: Figure, shape: Shape, prismatic: Sequence[bool]) -> None:
    unit, largest = unit_for("N m", prismatic), float(np.abs(shape.torque).max())
    parts = (
        (shape.torque, f"missing torque [{unit}]", {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest}),
        (shape.std, f"standard error [{unit}]", {"cmap": "Greys", "vmin": 0.0}),
    )
    first, second = shape.knots
    for axis, (values, label, look) in zip(made.subplots(1, 2, sharey=True), parts, strict=True):
        drawn = axis.pcolormesh(second, first, values, shading="gouraud", **look)
        made.colorbar(drawn, ax=axis, label=label)
        axis.set_xlabel(_axis(shape.variables[1], prismatic))
        axis.set_ylabel(_axis(shape.variables[0], prismatic))
