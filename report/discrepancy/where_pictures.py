"""Pictures of where a gap is: `Map`s in; its shares over position, speed, torque and time out."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from haptid.discrepancy.detect.localise import AXES, Map
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.marks import tell
from haptid.report.common.page import Picture
from haptid.report.common.style import MEASURED, RESIDUAL, figure, style


def localisation_picture(maps: tuple[Map, ...], prismatic: Sequence[bool]) -> Picture:
    """Draw the residual localisation: the shares of excess residual energy and of samples in every bin of a variable.

    Parameters
    ----------
    maps
        Excess of residual energy over the noise, one map per variable.
    prismatic
        Whether each joint is prismatic, for the units.

    Returns
    -------
    Picture
        What `localisation_figure` draws.
    """
    names = [AXES[m.variable][0].partition(" [")[0] for m in _drawn(maps)]
    return picture_of(
        localisation_figure(maps, prismatic),
        caption="Where the nominal model misses: each bar's share of the squared residual above the sensor's noise. "
        "Where a bar stands above the line, the gap is larger than the share of samples (of the spectrum, over "
        "frequency).",
        alt=f"residual energy over {', '.join(names)}",
    )


def _drawn(maps: Sequence[Map]) -> list[Map]:
    """Return the maps that say something: all of the gap lies in the only cycle, and in the only run."""
    return [m for m in maps if m.excess.size > 1]


def localisation_figure(maps: tuple[Map, ...], prismatic: Sequence[bool]) -> Figure:
    """Draw the shares of excess residual energy and of samples in every bin of each variable.

    Parameters
    ----------
    maps, prismatic
        As `localisation_picture` takes them.

    Returns
    -------
    Figure
        A panel a variable of more than one bin, shares in %.
    """
    drawn = _drawn(maps)
    with style():
        made = figure(8.5, 4.4)
        axes = made.subplots(2, -(-len(drawn) // 2), sharey=True, squeeze=False)
        for axis, m in zip(axes.ravel(), drawn, strict=False):
            draw_shares(axis, m, prismatic)
        for axis in axes.ravel()[len(drawn) :]:
            axis.remove()
        for row in axes:
            row[0].set_ylabel("share [%]")
        axes[0, 0].legend(fontsize=7)
    return made


def draw_shares(axis: Axes, m: Map, prismatic: Sequence[bool]) -> None:
    """Draw the shares of excess residual energy and of samples in every bin of a variable.

    Parameters
    ----------
    axis
        Axes to draw on.
    m
        Excess of residual energy over one variable.
    prismatic
        Whether each joint is prismatic, for the units.
    """
    gap, rows = (100 * part / max(part.sum(), 1e-300) for part in (np.maximum(m.excess, 0.0), m.rows))
    edges = m.edges + 1.0 if m.variable == "cycle" else m.edges
    axis.bar(edges[:-1], gap, np.diff(edges), align="edge", color=RESIDUAL, alpha=0.75, label="of the gap")
    axis.stairs(rows, edges, color=MEASURED, lw=0.8, label="of the samples")
    name, unit = AXES[m.variable]
    shown = f"{name} [{unit_for(unit, prismatic)}]" if unit else name
    axis.set_xlabel(shown, fontsize=8)
    for k, (low, high) in enumerate(pairwise(edges)):
        told = f"{shown} {_place(m, k, low, high)}: {gap[k]:.1f} % of the gap, {rows[k]:.1f} % of the samples"
        tell(axis, (low + high) / 2, gap[k], told, "column")
    _ticks(axis, m)


def _place(m: Map, k: int, low: float, high: float) -> str:
    """Write where a bin is: its name, its cycle, or its ends."""
    if m.labels:
        return m.labels[k]
    if m.variable == "cycle":
        return f"{(low + high) / 2:.3g}"
    return f"{low:.3g} to {high:.3g}"


def _ticks(axis: Axes, m: Map) -> None:
    if m.labels:
        axis.set_xticks((m.edges[:-1] + m.edges[1:]) / 2, [x.split(".csv")[0] for x in m.labels])
    if m.variable == "cycle":
        axis.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    if m.variable == "run":
        axis.tick_params(axis="x", rotation=90, labelsize=6)
    if m.variable == "frequency_rad_s":
        axis.set_xscale("log")
