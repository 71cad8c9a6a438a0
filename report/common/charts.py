"""Pictures of a page: matplotlib `Figure` in; `Picture` out, static and, where it has only curves, interactive.

The figure is the one source of both: what a test finds in its axes is what a reader sees, with and without scripts.
"""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import LogFormatter, ScalarFormatter

from haptid.measurement.values.run import Array
from haptid.report.common.decimation import Rows, dots_to_draw, points_to_draw, rows_to_draw
from haptid.report.common.marks import marks_of
from haptid.report.common.page import Curve, Fill, Numbers, Panel, Picture
from haptid.report.common.style import INKS, data_uri

COLUMNS, COLUMNS_BESIDE, LINES = 1000, 600, 400
"""Width of a panel on a screen, alone and beside another, and its height [pixel]; an interactive curve keeps the
extremes of each column."""
MOST_VECTOR_DOTS = 500
"""Most dots of a curve that a still picture draws one by one; more become pixels."""
LARGEST_STEP = 65534
"""Number of steps from the least to the greatest number of a curve; one more means none."""
LEAST_LETTERS = 10.0
"""Least size of the letters of a still picture on a phone, which are hard to read below it [pixel]."""
WIDTH_ON_A_PHONE = 4.0
"""Width of a figure that is drawn for phones: its letters of 8 pt have 10 pixels on a phone of 390 pixels [inch]."""
POINTS_PER_INCH = 72
"""Points in which letters are measured."""
STATIC_COLUMNS = 300
"""Columns of a static panel, of which a figure has two or three side by side [pixel]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Area:
    """What `Axes.fill_between` drew: the ends at every abscissa."""

    x: Array
    low: Array
    high: Array
    ink: str
    opacity: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Content:
    """What the axes of a figure hold, and whether that is all."""

    curves: tuple[Line2D, ...]
    levels: tuple[float, ...]
    marks: tuple[float, ...]
    bands: tuple[tuple[float, float], ...]
    areas: tuple[_Area, ...]
    complete: bool


def picture_of(made: Figure, *, caption: str, alt: str, for_phones: Figure | None = None) -> Picture:
    """Render a figure for a page.

    Parameters
    ----------
    made
        Figure; its long curves are thinned.
    caption
        Text below the picture.
    alt
        Text for readers who cannot see the picture.
    for_phones
        The same figure for a page as narrow as a phone; None where the one figure scrolls there.

    Returns
    -------
    Picture
        With panels for an interactive view where every axis holds only curves, level lines and shaded bands, and with
        the marks that `tell` has put there.
    """
    panels = panels_of(made)
    thin_curves(made)
    uri = data_uri(made)
    uri_for_phones = "" if for_phones is None else data_uri(for_phones)
    width = readable_width(made if for_phones is None else for_phones)
    return Picture(
        uri=uri,
        caption=caption,
        alt=alt,
        panels=panels,
        uri_for_phones=uri_for_phones,
        readable_width=width,
        marks=marks_of(made),
        marks_for_phones=() if for_phones is None else marks_of(for_phones),
    )


def readable_width(drawn: Figure) -> int:
    """Return the width at which the smallest letters of a figure can be read.

    Parameters
    ----------
    drawn
        Figure that has been rendered, so that it has all its letters.

    Returns
    -------
    int
        Least width at which no letter is smaller than `LEAST_LETTERS` [pixel]; 0 where there are no letters.
    """
    letters = [
        float(text.get_fontsize())
        for text in drawn.findobj(Text)
        if isinstance(text, Text) and text.get_visible() and text.get_text()
    ]
    if not letters:
        return 0
    return math.ceil(LEAST_LETTERS * POINTS_PER_INCH * float(drawn.get_figwidth()) / min(letters))


def panels_of(made: Figure) -> tuple[Panel, ...]:
    """Read the curves of a figure.

    Parameters
    ----------
    made
        Figure that is drawn.

    Returns
    -------
    tuple of Panel
        One for each visible axis, column by column; none where an axis holds something else.
    """
    shown = [axis for axis in made.axes if axis.get_visible()]
    contents = [_content_of(axis) for axis in shown]
    if not shown or not all(content.complete and content.curves and _fits(content) for content in contents):
        return ()
    panels = [_panel_of(axis, content) for axis, content in zip(shown, contents, strict=True)]
    return tuple(sorted(panels, key=lambda panel: panel.column))


def thin_curves(made: Figure) -> None:
    """Keep of every long curve of a figure what each column of pixels, or each pixel, shows.

    Parameters
    ----------
    made
        Figure, which is changed.
    """
    for axis in made.axes:
        for line in axis.lines:
            if line.get_transform() != axis.transData or line.get_rasterized():
                continue
            x, y = _coordinates(line)
            rows = _rows_of([(x, y)], STATIC_COLUMNS, STATIC_COLUMNS, dots=_is_dotted(line))
            line.set_data(x[rows], y[rows])
            # Each dot of a vector picture costs a hundred characters.
            line.set_rasterized(_is_dotted(line) and len(rows) > MOST_VECTOR_DOTS)
        for collection in axis.collections:
            area = _area_of(collection)
            if area is not None and isinstance(collection, PolyCollection):
                _thin_area(collection, area)


def _thin_area(collection: PolyCollection, area: _Area) -> None:
    rows = rows_to_draw(np.column_stack([area.low, area.high]), STATIC_COLUMNS)
    x, low, high = area.x[rows], area.low[rows], area.high[rows]
    collection.set_verts([np.column_stack([np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]])])])


def _content_of(axis: Axes) -> _Content:
    """Sort the artists of an axis."""
    curves, levels, marks = [], [], []
    for line in axis.lines:
        x, y = _coordinates(line)
        if line.get_transform() == axis.transData:
            curves.append(line)
        elif line.get_transform() == axis.get_yaxis_transform():
            levels.append(float(y[0]))
        elif line.get_transform() == axis.get_xaxis_transform():
            marks.append(float(x[0]))
    bands = [ends for patch in axis.patches if (ends := _band_of(axis, patch)) is not None]
    areas = [area for one in axis.collections if (area := _area_of(one)) is not None]
    others = len(axis.collections) - len(areas) + len(axis.images) + len(axis.texts)
    clouds = any(line.get_rasterized() for line in axis.lines)
    numbered = _has_numbers(axis.xaxis) and _has_numbers(axis.yaxis)
    # Bars, images and names in place of numbers stay as they were drawn.
    complete = others == 0 and len(bands) == len(axis.patches) and numbered and not clouds
    return _Content(
        curves=tuple(curves),
        levels=tuple(levels),
        marks=tuple(marks),
        bands=tuple(bands),
        areas=tuple(areas),
        complete=complete,
    )


def _fits(content: _Content) -> bool:
    """Say whether all areas lie over the abscissa of the curves."""
    x, _ = _coordinates(content.curves[0])
    return all(np.array_equal(area.x, x) for area in content.areas)


def _has_numbers(axis: Axis) -> bool:
    """Say whether an axis is linear or logarithmic, without names in place of its numbers."""
    return axis.get_scale() in ("linear", "log") and isinstance(
        axis.get_major_formatter(), ScalarFormatter | LogFormatter
    )


def _band_of(axis: Axes, patch: Patch) -> tuple[float, float] | None:
    """Return the ends of a horizontal band over the whole width; None for another patch."""
    if not isinstance(patch, Rectangle) or patch.get_data_transform() != axis.get_yaxis_transform():
        return None
    low = float(patch.get_y())
    return low, low + float(patch.get_height())


def _area_of(collection: Collection) -> _Area | None:
    """Read the ends of a filled area back; None for another collection."""
    paths = collection.get_paths()
    if not isinstance(collection, PolyCollection) or len(paths) != 1:
        return None
    corners = np.asarray(paths[0].vertices, dtype=float)
    n, odd = divmod(len(corners) - 3, 2)
    # `fill_between` goes along one end, back along the other, and has a corner of its own at either turn.
    there, back = corners[1 : n + 1], corners[n + 2 : 2 * n + 2][::-1]
    if odd or n < 1 or not np.array_equal(there[:, 0], back[:, 0]):
        return None
    low, high = np.minimum(there[:, 1], back[:, 1]), np.maximum(there[:, 1], back[:, 1])
    red, green, blue, opacity = np.atleast_2d(np.asarray(collection.get_facecolor(), dtype=float))[0].tolist()
    return _Area(x=there[:, 0], low=low, high=high, ink=_ink(to_hex((red, green, blue))), opacity=opacity)


def _panel_of(axis: Axes, content: _Content) -> Panel:
    over = [_coordinates(line) for line in content.curves]
    ends = [(area.x, end) for area in content.areas for end in (area.low, area.high)]
    joint = all(x.shape == over[0][0].shape and np.array_equal(x, over[0][0]) for x, _ in over)
    # Curves over one increasing abscissa share its rows; others are curves in a plane, each with its own.
    joint = joint and bool((np.diff(over[0][0]) > 0).all())
    place = axis.get_subplotspec()
    columns = COLUMNS if place is None or place.get_gridspec().ncols == 1 else COLUMNS_BESIDE
    shared = _rows_of([*over, *ends], columns, LINES) if joint else None
    curves = []
    for line, (x, y) in zip(content.curves, over, strict=True):
        rows = shared if shared is not None else _rows_of([(x, y)], columns, LINES, dots=_is_dotted(line))
        curves.append(_curve_of(line, x[rows], y[rows]))
    return Panel(
        title=" ".join(f"{axis.get_title()} {axis.get_title(loc='left')}".split()),
        x_label=_x_label(axis),
        y_label=_y_label(axis),
        column=0 if place is None else place.colspan.start,
        joint=joint,
        x_log=axis.get_xscale() == "log",
        y_log=axis.get_yscale() == "log",
        y_range=_pair(axis.get_ylim()),
        x_range=_pair(axis.get_xlim()),
        bands=content.bands,
        levels=content.levels,
        marks=content.marks,
        curves=tuple(curves),
        fills=tuple(_fill_of(area, shared) for area in content.areas if shared is not None),
    )


def _fill_of(area: _Area, rows: Rows) -> Fill:
    return Fill(ink=area.ink, opacity=area.opacity, low=_pack(area.low[rows]), high=_pack(area.high[rows]))


def _x_label(axis: Axes) -> str:
    """Return the label of the abscissa, which the lowest of several panels of a column has for all."""
    return axis.get_xlabel() or next((one.get_xlabel() for one in _beside(axis, "colspan") if one.get_xlabel()), "")


def _y_label(axis: Axes) -> str:
    """Return the label of the ordinate, which the first panel of a row may have for all."""
    return axis.get_ylabel() or next((one.get_ylabel() for one in _beside(axis, "rowspan") if one.get_ylabel()), "")


def _beside(axis: Axes, span: Literal["colspan", "rowspan"]) -> list[Axes]:
    """Return the axes that begin in the same column or row of a figure's grid."""
    place, others = axis.get_subplotspec(), []
    for one in axis.figure.axes:
        other = one.get_subplotspec()
        if place is not None and other is not None and getattr(other, span).start == getattr(place, span).start:
            others.append(one)
    return others


def _is_dotted(line: Line2D) -> bool:
    return line.get_linestyle() in ("None", "none", "", " ")


def _rows_of(curves: list[tuple[Array, Array]], columns: int, lines: int, *, dots: bool = False) -> Rows:
    """Choose the rows of curves over one abscissa, or of one curve in a plane."""
    x, y = curves[0]
    if len(x) > 1 and bool((np.diff(x) > 0).all()):
        return rows_to_draw(np.column_stack([y for _, y in curves]), columns)
    return (dots_to_draw if dots else points_to_draw)(x, y, columns, lines)


def _curve_of(line: Line2D, x: Array, y: Array) -> Curve:
    label = str(line.get_label())
    return Curve(
        label="" if label.startswith("_") else label,
        ink=_ink(to_hex(line.get_color())),
        width=float(line.get_linewidth()),
        opacity=1.0 if line.get_alpha() is None else float(line.get_alpha() or 0.0),
        dashed=line.get_linestyle() in ("--", ":", "-."),
        dots=_is_dotted(line),
        x=_pack(x),
        y=_pack(y),
    )


def _ink(colour: str) -> str:
    """Return the role of a colour; the colour itself where it has none."""
    return next((role for role, (named, *_) in INKS.items() if named == colour), colour)


def _coordinates(line: Line2D) -> tuple[Array, Array]:
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def _pack(values: Array) -> Numbers:
    known = np.isfinite(values)
    low, high = (float(end(values[known])) if known.any() else 0.0 for end in (np.min, np.max))
    share = (np.where(known, values, low) - low) / ((high - low) or 1.0)
    steps = np.where(known, np.round(LARGEST_STEP * share), LARGEST_STEP + 1).astype("<u2")
    return Numbers(low=low, high=high, steps=base64.b64encode(steps.tobytes()).decode("ascii"))


def _pair(ends: tuple[float, float]) -> tuple[float, float]:
    return float(ends[0]), float(ends[1])
