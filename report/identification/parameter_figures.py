"""How well each parameter is known, and with which it is confounded: `Fit` in; picture and table out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from haptid.identification.result.fit import Fit
from haptid.measurement.values.run import Array
from haptid.report.common.charts import WIDTH_ON_A_PHONE, picture_of
from haptid.report.common.marks import tell
from haptid.report.common.numbers import HALF_WIDTH_95
from haptid.report.common.page import Picture, Table
from haptid.report.common.style import ACCENT, MEASURED, SIMULATED, figure, style

WIDTH = 8.5
"""Width of the figure of the intervals on a screen [inch]."""
LEAST_DRAWN, LARGEST_DRAWN = 1e-3, 1e3
"""Least and largest half width that is drawn, in percent of the value."""
LARGEST_TOLD = 1e5
"""Largest half width that is told by its number, in percent of the value."""


def half_widths(fit: Fit) -> tuple[list[str], Array]:
    """Compute the half width of each fitted parameter's 95 % interval.

    Parameters
    ----------
    fit
        Fit with its covariance.

    Returns
    -------
    ids : list of str
        Parameters with a positive standard deviation, as they were fitted.
    widths : ndarray, shape (n,)
        1.96 standard deviations in percent of the absolute value; infinite for one that is next to 0.
    """
    known = [id for id in fit.free if fit.std[fit.index(id)] > 0]
    rows = [fit.index(id) for id in known]
    values = np.maximum(np.abs(np.asarray(fit.theta)[rows]), np.finfo(float).tiny)
    with np.errstate(over="ignore"):  # a value of 0 has no percent
        return known, 100 * HALF_WIDTH_95 * np.asarray(fit.std)[rows] / values


def interval_picture(fit: Fit, title: str, uncertain: Sequence[str] = ()) -> Picture | None:
    """Draw how well each parameter is known.

    Parameters
    ----------
    fit
        Fit with its covariance.
    title
        Name of the configuration.
    uncertain
        Identified parameters of a model that does not fit, which are not drawn as known.

    Returns
    -------
    Picture or None
        None where nothing was fitted.
    """
    ids, widths = half_widths(fit)
    if not ids:
        return None
    caption = (
        f"{title}: half width of the 95 % interval in percent of the value, the least known on top; orange where the "
        "status is not identified, or the model does not fit. Beyond 100 % not even the sign is known; of a gravity or "
        "spring near 0 that may be all there is to know, and its status counts by the largest torque."
    )
    known = [fit.statuses[id] == "identified" and id not in uncertain for id in ids]
    made = interval_figure(ids, widths, known)
    narrow = interval_figure(ids, widths, known, WIDTH_ON_A_PHONE)
    alt = f"{title}, width of each parameter's interval"
    return picture_of(made, caption=caption, alt=alt, for_phones=narrow)


def interval_figure(ids: list[str], widths: Array, identified: list[bool], width: float = WIDTH) -> Figure:
    """Draw the half width of each interval.

    Parameters
    ----------
    ids
        Parameters.
    widths
        Half widths in percent of the value, shape (n,).
    identified
        Whether each has the status identified.
    width
        Width of the figure [inch].

    Returns
    -------
    Figure
        A bar a parameter on a logarithmic axis, the best known at the bottom.
    """
    order = np.argsort(widths, kind="stable")
    with style():
        made = figure(width, 0.26 * len(ids) + 0.8)
        axis = made.subplots()
        axis.axvline(100.0, color=MEASURED, lw=0.8, ls="--")
        for row, i in enumerate(order):
            shown = float(np.clip(widths[i], LEAST_DRAWN, LARGEST_DRAWN))
            colour, sign = (SIMULATED, "o") if identified[i] else (ACCENT, "D")
            axis.plot([LEAST_DRAWN, shown], [row, row], color=colour, lw=1.2)
            axis.plot([shown], [row], sign, ms=5, color=colour)
            rounded = float(f"{widths[i]:.2g}")
            told = f"± {rounded:g} %" if widths[i] <= LARGEST_TOLD else f"> {LARGEST_TOLD:g} %"
            axis.text(1.15 * LARGEST_DRAWN, row, told, va="center", fontsize=8)
            doubt = "" if identified[i] else " (not identified, or the model does not fit)"
            tell(axis, shown, row, f"{ids[i]}: {told} of the value{doubt}", "row")
        axis.set_xscale("log")
        axis.set_xlim(LEAST_DRAWN, LARGEST_DRAWN)
        axis.set_yticks(range(len(ids)), [ids[i] for i in order], fontsize=8)
        axis.set_xlabel("95 % half width in percent of the value")
        axis.grid(visible=False, axis="y")
    return made


def correlation_table(fit: Fit) -> Table:
    """Write the correlations of the fitted parameters.

    Parameters
    ----------
    fit
        Fit with its covariance.

    Returns
    -------
    Table
        A row and a column a parameter, cells coloured by size and sign; without rows for fewer than two parameters.
    """
    std = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    known = [k for k in range(len(fit.free)) if std[k] > 0]
    if len(known) < 2:
        return Table(header=("",), rows=())
    correlation = (fit.covariance / np.outer(std, std).clip(min=np.finfo(float).tiny))[np.ix_(known, known)]
    ids = [fit.free[k] for k in known]
    rows = [(id, *(f"{c:+.2f}" for c in row)) for id, row in zip(ids, correlation, strict=True)]
    shades = [[float(c) if i != j else 0.0 for j, c in enumerate(row)] for i, row in enumerate(correlation)]
    caption = "Correlations: near ±1, the runs know a combination of both better than each"
    return Table(header=("", *ids), rows=rows, caption=caption, shades=shades)
