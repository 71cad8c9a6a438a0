"""Results in notebooks and figures: tables as HTML, and axes for those who bring none."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from markupsafe import escape
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase

from haptid.report.common.style import style
from haptid.support.errors import InputError


def html_of(title: str, sentence: str, tables: Mapping[str, pd.DataFrame], *, measured: bool) -> str:
    """Return a result as HTML for a notebook.

    Parameters
    ----------
    title
        Heading.
    sentence
        What an engineer reads first.
    tables
        Tables by caption.
    measured
        Whether the data were measured; else the result says SYNTHETIC DATA.

    Returns
    -------
    str
        HTML without scripts; texts of users are escaped.
    """
    label = "" if measured else " <b>SYNTHETIC DATA</b>"
    parts = [f"<h4>{escape(title)}{label}</h4>", f"<p>{escape(sentence)}</p>"]
    for caption, table in tables.items():
        body = table.to_html(float_format=lambda x: f"{x:.4g}", na_rep="–", border=0)
        parts.append(f"<details open><summary>{escape(caption)}</summary>{body}</details>")
    return "".join(parts)


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the axes to draw on.

    Parameters
    ----------
    ax
        Axes of the caller; None for new ones in a figure of pyplot, which notebooks show.

    Returns
    -------
    matplotlib.axes.Axes
        The given or the new ones.

    Raises
    ------
    InputError
        Where a figure, or several axes, are given.
    """
    if ax is not None:
        given: object = ax
        if isinstance(given, Axes):
            return given
        figure = isinstance(given, FigureBase)
        todo = (
            "give figure.gca()" if figure else "of several axes give one, as axes[0] of figure, axes = plt.subplots(2)"
        )
        raise InputError("ax", expected="Axes of matplotlib", got=f"one {type(given).__name__}", todo=todo)
    from matplotlib import pyplot as plt  # noqa: PLC0415 (commands draw without it)

    with style():
        _, new = plt.subplots(figsize=(8.0, 3.0), layout="constrained")
    return new
