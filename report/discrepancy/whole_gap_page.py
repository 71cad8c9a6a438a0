"""The page of the runs with all joints free: `WholeFinding` in, `Page` with the residuals before and after out."""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.finding.full_model import Missed, WholeFinding
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.common.style import ACCENT, MEASURED, SIMULATED, figure, style
from haptid.report.discrepancy.glance import whole_glance
from haptid.support.linear_algebra import largest_magnitude
from haptid.support.numbers import choose_unit, plain


def missed_picture(finding: WholeFinding) -> Picture:
    """Draw the residual RMS of every joint before and after the search, with the RMS expected of noise and parameters.

    Parameters
    ----------
    finding
        Residuals of every run and joint.

    Returns
    -------
    Picture
        Bars by joint, run after run, on a logarithmic axis.
    """
    unit, factor = _unit(finding)
    with style():
        made = figure(8.5, 2.8)
        axis = made.subplots()
        x = np.arange(len(finding.rows))
        axis.bar(x - 0.2, [factor * r.before for r in finding.rows], 0.4, color=ACCENT, label="before")
        axis.bar(x + 0.2, [factor * r.after for r in finding.rows], 0.4, color=SIMULATED, label="after")
        axis.plot(x, [factor * r.expected for r in finding.rows], "_", ms=14, color=MEASURED, label="expected")
        axis.set_yscale("log")
        axis.set_xticks(x, [str(r.joint) for r in finding.rows], fontsize=7)
        axis.set_xlabel("joint, run after run")
        axis.set_ylabel(f"missed [{unit}]")
        axis.legend(fontsize=7, ncols=3)
    caption = (
        "RMS of measured − simulated of every joint on runs that no fit saw, and what noise and the parameters' "
        "uncertainty give together."
    )
    return picture_of(made, caption=caption, alt="what every joint misses before and after")


def whole_gap_page(finding: WholeFinding, title: str, *, measured: bool) -> Page:
    """Render the page.

    Parameters
    ----------
    finding
        Residuals of every run and joint, and the effects that were added.
    title
        Title of the campaign.
    measured
        Whether the data are measured (else the page says SYNTHETIC DATA).

    Returns
    -------
    Page
        Content of the page.
    """
    unit, factor = _unit(finding)
    rows = [
        (r.file, r.mode.replace("_", " "), f"{r.joint}", *(plain(factor * x, 3) for x in _numbers(r)))
        for r in finding.rows
    ]
    numbers = (f"{what} [{unit}]" for what in ("missed before", "after", "expected", "noise"))
    header = ("run", "simulated", "joint", *numbers)
    none = "No effect was named in a joint: before and after agree."
    with_names = f"After: with {', '.join(finding.names)}." if finding.names else none
    return Page(
        title=f"All joints: {title}",
        lead=finding.sentence,
        sections=[
            Section(
                title="Before and after", anchor="gap", paragraphs=[with_names], pictures=[missed_picture(finding)],
                tables=[Table(header=header, rows=rows)],
            )
        ],
        synthetic=not measured,
        footer=["Nothing was fitted to these runs."],
        glance=whole_glance(finding),
    )  # fmt: skip


def _unit(finding: WholeFinding) -> tuple[str, float]:
    """Choose the unit of all residuals of the page, with its factor."""
    largest = largest_magnitude(*(x for row in finding.rows for x in _numbers(row)))
    return choose_unit(largest, unit_for("rad", [r.prismatic for r in finding.rows]))


def _numbers(row: Missed) -> tuple[float, float, float, float]:
    return row.before, row.after, row.expected, row.noise
