"""The style of all figures: matplotlib figures without a display in, PNG bytes or ``data:`` URIs out."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

MEASURED, SIMULATED, RESIDUAL, BAND, ACCENT = "#1f2933", "#0b7285", "#c92a2a", "#99e9f2", "#e8590c"
_RC: dict[str, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e9ecef",
    "grid.linewidth": 0.6,
    "axes.edgecolor": "#868e96",
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "figure.dpi": 110,
    "text.parse_math": False,  # a file's name may hold dollars
}


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


def data_uri(made: Figure) -> str:
    """Render a figure to a ``data:`` URI for a self-contained page.

    Parameters
    ----------
    made
        Figure to render.

    Returns
    -------
    str
        PNG in base64 with its prefix.
    """
    return "data:image/png;base64," + base64.b64encode(png(made)).decode("ascii")
