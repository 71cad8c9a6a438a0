"""Marks of a still picture: what a figure tells at a point in, where a page tells it out."""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.report.common.page import Mark

Along = Literal["point", "row", "column"]
"""Where a pointer is at a mark: near its point, or anywhere in its row or column of the axis, as for a bar."""


class Told(Artist):
    """A text at a point of an axis, which a page tells and no picture draws.

    Parameters
    ----------
    x, y
        Point in the data of the axis.
    text
        What a reader is told there.
    along
        Where a pointer is there.
    """

    def __init__(self, x: float, y: float, text: str, along: Along) -> None:
        super().__init__()
        self.point = (x, y)
        self.text = text
        self.along = along
        self.set_in_layout(False)


def tell(axis: Axes, x: float, y: float, text: str, along: Along = "point") -> None:
    """Let a page tell a text at a point of an axis, as a bar's value at its end.

    Parameters
    ----------
    axis
        Axes with the bar.
    x, y
        Point in the data of the axis.
    text
        Name and value.
    along
        Where a pointer is there.
    """
    axis.add_artist(Told(x, y, text, along))


def marks_of(drawn: Figure) -> tuple[Mark, ...]:
    """Find the marks of a figure.

    Parameters
    ----------
    drawn
        Figure that has been rendered, so that its axes have their places.

    Returns
    -------
    tuple of Mark
        In the order in which they were told; those beyond an axis stand at its end.
    """
    return tuple(_mark_of(drawn, axis, told) for axis in drawn.axes for told in axis.artists if isinstance(told, Told))


def _mark_of(drawn: Figure, axis: Axes, told: Told) -> Mark:
    within = axis.transAxes.inverted().transform(axis.transData.transform(told.point))
    x, y = np.clip(np.nan_to_num(within), 0.0, 1.0)
    columns = (0.0, 1.0) if told.along == "row" else (x, x)
    lines = (0.0, 1.0) if told.along == "column" else (y, y)
    corners = axis.transAxes.transform([(x, y), (columns[0], lines[1]), (columns[1], lines[0])])
    places = drawn.transFigure.inverted().transform(corners)
    # A page counts from the top.
    (x, y), (left, top), (right, bottom) = np.round(np.abs(places - (0.0, 1.0)), 4).tolist()
    return Mark(x=x, y=y, text=told.text, box=(left, top, right, bottom))
