"""Confusion matrix of a blind study: rows what was hidden, columns the verdict."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.report.common.style import figure, style

Counts = dict[str, dict[str, int]]
RIGHT, WRONG = "#0b7285", "#c92a2a"
WORDS = ("nothing", "ambiguous, truth among", "ambiguous", "unlisted", "failed")
"""Verdicts that are no name, in the order of their columns after the names."""


def columns_of(counts: Counts) -> list[str]:
    """Return the columns of a matrix: the names that were told, then the other verdicts.

    Parameters
    ----------
    counts
        Counts by what was hidden, then by verdict.

    Returns
    -------
    list of str
        Names in alphabetical order, sets of several names, then the verdicts of `WORDS`.
    """
    told = {column for row in counts.values() for column in row}
    several = sorted(c for c in told if c.startswith("several"))
    words = [w for w in WORDS if w in told]
    return [*sorted(told - set(several) - set(words)), *several, *words]


def confusion_picture(cases: Counts, left_out: Counts) -> Figure:
    """Draw the matrix of the cases and, beside it, of those worked through without their true entry.

    Parameters
    ----------
    cases
        Counts of the cases, by what was hidden, then by verdict.
    left_out
        Counts of the cases without their true entry. Counts that are empty get no panel.

    Returns
    -------
    Figure
    """
    panels = [(counts, title) for counts, title in (
        (cases, "whole catalogue"), (left_out, "true entry left out"),
    ) if counts]  # fmt: skip
    widths = [len(columns_of(counts)) + 8 for counts, _ in panels]
    height = max(len(counts) for counts, _ in panels)
    with style():
        made = figure(0.24 * sum(widths) + 1.0, 0.2 * height + 3.0)
        axes = made.subplots(1, len(panels), squeeze=False, width_ratios=widths)[0]
        for axis, (counts, title) in zip(axes, panels, strict=True):
            _matrix(axis, counts, title, right=title == "whole catalogue")
    return made


def _matrix(axis: Axes, counts: Counts, title: str, *, right: bool) -> None:
    rows, columns = list(counts), columns_of(counts)
    axis.set_title(title, fontsize=9, loc="left")
    axis.set_xticks(np.arange(len(columns)), columns, rotation=90, fontsize=7)
    axis.set_yticks(np.arange(len(rows)), rows, fontsize=7)
    axis.set_xlim(-0.5, len(columns) - 0.5)
    axis.set_ylim(len(rows) - 0.5, -0.5)
    for i, row in enumerate(rows):
        for column, n in counts[row].items():
            good = _good(row, column) if right else column in ("unlisted", "ambiguous")
            colour = RIGHT if good else WRONG
            axis.text(
                columns.index(column), i, str(n), color=colour, ha="center", va="center", fontsize=8, weight="bold"
            )


def _good(row: str, column: str) -> bool:
    outside = column in ("unlisted", "ambiguous") and row.startswith("outside")
    return row == column or column in ("several, exact", "ambiguous, truth among") or outside
