"""The style of all figures: matplotlib figures without a display in; SVG, PNG or ``data:`` URIs out."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation, NullFormatter

MEASURED, SIMULATED, RESIDUAL, BAND, ACCENT = "#1f2933", "#0b7285", "#c92a2a", "#99e9f2", "#e8590c"
_TEXT, _AXIS, _GRID = "#343a40", "#868e96", "#e9ecef"
INKS: dict[str, tuple[str, str, str]] = {
    "measured": (MEASURED, "#1f2933", "#e6edf3"),
    "simulated": (SIMULATED, "#0b7285", "#4dd0e1"),
    "residual": (RESIDUAL, "#c92a2a", "#ff8787"),
    "band": (BAND, "#99e9f2", "#17505b"),
    "accent": (ACCENT, "#d9480f", "#ffa94d"),
    "text": (_TEXT, "#343a40", "#ced4da"),
    "axis": (_AXIS, "#868e96", "#868e96"),
    "grid": (_GRID, "#e9ecef", "#2b3138"),
}
"""Colours by role: as a figure names it, on light paper, on dark paper."""
_RC: dict[str, Any] = {
    "font.size": 9,
    "font.sans-serif": ["DejaVu Sans", "sans-serif"],
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": _GRID,
    "grid.linewidth": 0.6,
    "axes.edgecolor": _AXIS,
    "text.color": _TEXT,
    "axes.labelcolor": _TEXT,
    "axes.titlecolor": _TEXT,
    "xtick.color": _AXIS,
    "ytick.color": _AXIS,
    "xtick.labelcolor": _TEXT,
    "ytick.labelcolor": _TEXT,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "figure.dpi": 110,
    "text.parse_math": False,  # a file's name may hold dollars
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "haptid",  # the same figure, the same ids
}
_NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))
"""Entries of an SVG that would hold versions and times."""
_RASTER_DPI = 160
"""Resolution of the clouds of points within an SVG [dots/inch]."""
_SVG_DPI = 72
"""Resolution at which matplotlib writes an SVG, and at which the layout has to measure texts [dots/inch]."""
_GEOMETRY, _LONG_NUMBER = re.compile(r'\b(?:d|x|y)="[^"]*"'), re.compile(r"(\.\d\d)\d+")
_PATH, _SPACES = re.compile(r'\bd="[^"]*"'), re.compile(r"\s*([A-Za-z\"])\s*")


@contextmanager
def style() -> Iterator[None]:
    """Apply the style of all figures within the block."""
    with mpl.rc_context(_RC):  # type: ignore[arg-type] # the stubs know the keys only as literals
        yield


def figure(width: float = 8.0, height: float = 3.0) -> Figure:
    """Return an empty figure that belongs to no display; ``width`` and ``height`` in inches.

    Parameters
    ----------
    width, height
        Size [inch].

    Returns
    -------
    Figure
        Empty, with constrained layout.
    """
    made = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(made)
    return made


def png(made: Figure) -> bytes:
    """Render a figure to PNG bytes; the same figure gives the same bytes.

    Parameters
    ----------
    made
        Figure to render.

    Returns
    -------
    bytes
        Content of a PNG file without matplotlib's version.
    """
    stream = io.BytesIO()
    made.savefig(stream, format="png", metadata={"Software": None})  # the entry would hold matplotlib's version
    return stream.getvalue()


def inks_css() -> str:
    """Return the colours of `INKS` as variables of a style sheet, for light and for dark paper.

    Returns
    -------
    str
        Rules of CSS.
    """
    light = "".join(f"--{role}:{on_light};" for role, (_, on_light, _) in INKS.items())
    dark = "".join(f"--{role}:{on_dark};" for role, (*_, on_dark) in INKS.items())
    return f":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"


def svg(made: Figure) -> bytes:
    """Render a figure to an SVG that follows the reader's light or dark paper; the same figure gives the same bytes.

    Parameters
    ----------
    made
        Figure to render.

    Returns
    -------
    bytes
        Content of an SVG file with a transparent background.
    """
    for axis in (one for axes in made.axes for one in (axes.xaxis, axes.yaxis)):
        if isinstance(axis.get_major_formatter(), LogFormatterSciNotation):
            # Powers of ten would be formulas, which are off for the sake of names with dollars.
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
    with style():
        text = _draw_once(made)
    # Two decimals are a hundredth of a point; the rest would double the size of a page.
    text = _GEOMETRY.sub(lambda found: _LONG_NUMBER.sub(r"\1", found[0]), text)
    # Letters part the numbers of a path already: blanks and line ends beside them would make up a quarter of it.
    text = _PATH.sub(lambda found: "d=" + _SPACES.sub(r"\1", found[0][2:]), text)
    for role, (named, *_) in INKS.items():
        text = text.replace(named, f"var(--{role})")
    return text.replace('<style type="text/css">', f'<style type="text/css">{inks_css()}', 1).encode()


def _draw_once(made: Figure) -> str:
    """Write a figure as SVG on a transparent background, as ``savefig`` does it, but drawn once.

    ``savefig`` draws a figure with a layout twice: to place its axes, and then to write it. Here the layout places the
    axes by itself, which saves a quarter of the time; the bytes are the same.
    """
    canvas, stream = FigureCanvasSVG(made), io.StringIO()
    for patch in (made.patch, *(axes.patch for axes in made.axes)):
        patch.set(facecolor="none", edgecolor="none")
    layout = made.get_layout_engine()
    made.set_dpi(_SVG_DPI)
    if made.axes and layout is not None:
        layout.execute(made)
    made.set_layout_engine("none")
    made.set_dpi(_RASTER_DPI)
    canvas.print_svg(stream, metadata=_NO_METADATA)  # type: ignore[no-untyped-call] # matplotlib's stubs leave it out
    return stream.getvalue()


def data_uri(made: Figure) -> str:
    """Render a figure to a ``data:`` URI for a self-contained page.

    Parameters
    ----------
    made
        Figure to render.

    Returns
    -------
    str
        SVG in base64 with its prefix.
    """
    return "data:image/svg+xml;base64," + base64.b64encode(svg(made)).decode("ascii")
