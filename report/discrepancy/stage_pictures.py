"""Pictures of the stages of the search for missing physics: `Staged` or `Finding` in, pictures and PNG files out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from haptid.discrepancy.detect.score_tests import Scan
from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.finding.stages import Staged
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.report.common.charts import picture_of
from haptid.report.common.marks import tell
from haptid.report.common.page import Picture
from haptid.report.common.style import ACCENT, BAND, RESIDUAL, figure, png, style
from haptid.report.discrepancy.motion_pictures import before_after_figure, residual_unit
from haptid.report.discrepancy.where_pictures import localisation_figure
from haptid.support.files.files import write_bytes

MOST_SCORES_SHOWN = 15
"""Most catalogue effects in the picture of the scores."""
SMALLEST_P_DRAWN = 1e-16
"""Smallest family-wise p-value that is drawn; smaller ones, 0 among them, are drawn as this [1]."""


def gap_picture(curves: Sequence[Curve]) -> Picture:
    """Draw the residual of the nominal model over time, with the sensor's ±2σ.

    Parameters
    ----------
    curves
        Runs with their simulations by the nominal model.

    Returns
    -------
    Picture
        What `gap_figure` draws.
    """
    caption = "What the nominal model misses; the band is ±2σ of the sensor."
    return picture_of(gap_figure(curves), caption=caption, alt="residual of the nominal model over time")


def gap_figure(curves: Sequence[Curve]) -> Figure:
    """Draw the residual of the nominal model over time on the first two runs.

    Parameters
    ----------
    curves
        Runs with their simulations by the nominal model.

    Returns
    -------
    Figure
        A panel a run, with the sensor's ±2σ.
    """
    shown = list(curves)[:2]
    unit, factor = residual_unit(shown)
    with style():
        made = figure(8.5, 2.8)
        for axis, curve in zip(made.subplots(1, len(shown), squeeze=False, sharey=True)[0], shown, strict=True):
            axis.plot(curve.run.t, factor * (curve.run.y[:, 0] - curve.before), color=ACCENT, lw=0.7)
            band = [2 * factor * s * curve.run.sensor_std[0] for s in (-1, 1)]
            axis.axhspan(*band, color=BAND, alpha=0.5, lw=0)
            axis.set_title(f"{curve.run.file}, joint {curve.run.free_joints[0]}", fontsize=8)
            axis.set_xlabel("time [s]")
        made.axes[0].set_ylabel(f"measured − simulated [{unit}]")
    return made


def scores_picture(scan: Scan) -> Picture:
    """Draw the family-wise p-values of the catalogue, before any refit.

    Parameters
    ----------
    scan
        Score tests of the whole catalogue, the best first.

    Returns
    -------
    Picture
        What `scores_figure` draws.
    """
    caption = "How unlikely noise alone would look this much like each entry; beyond the line it counts."
    return picture_of(scores_figure(scan), caption=caption, alt="scores of the catalogue")


def scores_figure(scan: Scan) -> Figure:
    """Draw the family-wise p-values of the first `MOST_SCORES_SHOWN` scores.

    Parameters
    ----------
    scan
        Score tests of the whole catalogue, the best first.

    Returns
    -------
    Figure
        Bars of −log₁₀ p, the best on top, with the line beyond which an effect counts.
    """
    shown = scan.scores[:MOST_SCORES_SHOWN][::-1]
    with style():
        made = figure(6.5, 0.6 + 0.22 * len(shown))
        axis = made.subplots()
        bars = axis.barh(
            [s.key for s in shown], [-np.log10(max(s.family_p, SMALLEST_P_DRAWN)) for s in shown], color=RESIDUAL
        )
        for row, (bar, score) in enumerate(zip(bars.patches, shown, strict=True)):
            tell(axis, bar.get_width(), row, f"{score.key}: p = {score.family_p:.2g}", "row")
        axis.axvline(-np.log10(THRESHOLDS.candidate.family_wise_p_value), color=ACCENT, ls="--")
        axis.tick_params(axis="y", labelsize=7)
        axis.set_xlabel("−log₁₀ p over the whole catalogue")
    return made


def stage_figure(staged: Staged) -> Figure:
    """Draw one stage: scores where it has a scan, else the localisation, else the residual.

    Parameters
    ----------
    staged
        Result of one stage.

    Returns
    -------
    Figure
    """
    if staged.scan is not None:
        return scores_figure(staged.scan)
    return (
        localisation_figure(staged.maps, staged.study.fitted[0].prismatic) if staged.maps else gap_figure(staged.curves)
    )


def write_pictures(finding: Finding, folder: Path) -> None:
    """Write the pictures of all stages beside the page.

    Parameters
    ----------
    finding
        Result of the search.
    folder
        Folder of the files ``<study>_<stage>.png``.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    drawn = {
        "gap": gap_figure(finding.curves),
        "where": localisation_figure(finding.maps, finding.search.study.fitted[0].prismatic),
        "what": scores_figure(finding.search.scan),
        "after": before_after_figure(finding.curves),
    }
    for stage, made in drawn.items():
        save(made, folder / f"{finding.search.study.name}_{stage}.png")


def save(made: Figure, path: Path) -> Path:
    """Write a figure as a PNG file, whole or not at all, and return its path.

    Parameters
    ----------
    made
        Figure to write.
    path
        PNG file to write.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    InputError
        Where the place cannot be written (exit code 2).
    WritingError
        Where the disk is full or fails (exit code 1).
    """
    return write_bytes(path, png(made))
