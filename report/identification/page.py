"""The page of ``identification.run``: steps, traces and verification in, `Page` out.

It shows, for each joint, measured and simulated positions, parameters with their status, and remedies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from haptid.identification.links.consistency import summary as consistency_summary
from haptid.identification.output.plain_comparison import tell_size_and_share
from haptid.identification.output.summary import HEADER, attention, residual_unit, step_row, worst_score
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.outcome_sentence import structured_run
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.verification.result import Verification
from haptid.measurement.values.units import unit_for
from haptid.report.common.numbers import in_thousandths, with_error
from haptid.report.common.page import Cell, Page, Section, Table, word_cell
from haptid.report.identification.campaign_comparison import comparison_table
from haptid.report.identification.figures import whole_picture
from haptid.report.identification.glance import glance_table, worst_joint
from haptid.support.numbers import plain

METHOD = (
    "Residuals are measured minus simulated position over the sensor's noise √(noise² + resolution²/12); 1.00 is the "
    "noise. The initial position of every run, validation runs included, is fitted with the prior N(first sample, "
    "noise²). Standard deviations take the residuals' correlation into account. Status: identified; prior (the data "
    "did not halve the prior's width); unidentifiable (known only within 50 %, or in combinations); at_bound "
    "(stopped at the end of the range that it may take); fixed; "
    "uncertain (identified, but in a model that leaves more than the noise)."
)
MOST_UNFOLDED = 2
"""Most configurations whose sections are open when the page is; of more, the first screen links to each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """What lies beside the page of an identification.

    Parameters
    ----------
    files
        FMUs and parameter sets that were written, relative to the page.
    embedded
        Name of the embedded campaign that was identified, whose whole model is shown beside that of the other; None for
        any other campaign.
    """

    files: tuple[str, ...] = ()
    embedded: str | None = None


ALONE = Beside()
"""A page with nothing beside it."""


def identification_page(
    title: str,
    steps: Sequence[Step],
    configurations: Sequence[Sequence[Section]],
    data: Mapping[str, Any],
    verification: Verification,
    beside: Beside = ALONE,
) -> Page:
    """Render the page of an identification.

    Parameters
    ----------
    title
        Heading of the page.
    steps
        Steps of the identification, in locking order.
    configurations
        `configuration_sections` of every step.
    data
        Content of identification.json: remarks, links, command, software, measured.
    verification
        Check of the whole model on runs with all joints free; its section is left out where there are none.
    beside
        What lies beside the page.

    Returns
    -------
    Page
        Content of the page.
    """
    sections = [_overview(steps), *_remarks(data.get("remarks", ()))]
    folded = len(steps) > MOST_UNFOLDED
    sections += [replace(one, folded=one.folded or folded) for parts in configurations for one in parts]
    if verification.runs:
        sections.append(_whole(verification, beside.embedded))
    if data["links"]:
        sections.append(_links(data["links"]))
    sections.append(_consistency(steps))
    footer = (
        f"Command: {data['command']}",
        "Software: " + ", ".join(f"{name} {number}" for name, number in data["software"].items()),
    )
    return Page(
        title=title,
        lead=_lead(steps, verification),
        sections=sections,
        synthetic=not data["measured"],
        footer=footer,
        glance=glance_table(steps, verification, beside.files),
    )


def _lead(steps: Sequence[Step], verification: Verification) -> str:
    good, structured, poor = _by_residual(steps)
    words = []
    if good:
        all_of_many = len(good) == len(steps) > MOST_UNFOLDED
        where = f"in all {len(good)} configurations" if all_of_many else "; ".join(good)
        words.append(f"On runs that no fit saw, what is left is the sensor's noise: {where}.")
    if structured:
        words.append(f"What is left is little more than the noise, but not white: {'; '.join(structured)}.")
    if poor:
        words.append(f"The residual stays above the noise: {'; '.join(poor)}.")
    if verification.runs:
        planned = any(step.configuration.locked for step in steps)
        words.append(_whole_sentence(verification, planned=planned))
    return " ".join(words)


def _by_residual(steps: Sequence[Step]) -> tuple[list[str], list[str], list[str]]:
    """Name the configurations by what is left of runs that no fit saw: noise; structure near the noise; more."""
    good, structured, poor = [], [], []
    for step in steps:
        worst = worst_score(step)
        if worst is None or worst.use != "validate":
            continue
        quiet = worst.over_noise <= THRESHOLDS.largest_residual_as_noise
        over = f" ({plain(worst.over_noise, 3)} × noise)"
        # A run's own noise varies about the pooled one: the outcome has judged that, and its word stands below.
        if structured_run(step) is not None:
            structured.append(step.configuration.name + over)
        elif quiet and step.fit.outcome in (Outcome.ABOVE_NOISE, Outcome.LONELY):
            fitted = plain(step.fit.basins[0].over_noise, 3)
            poor.append(f"{step.configuration.name} ({fitted} × noise on the fitted runs)")
        elif quiet or step.fit.outcome in (Outcome.CONVERGED, Outcome.SINGLE_START):
            good.append(step.configuration.name + ("" if quiet else over))
        else:
            size = tell_size_and_share(worst, residual_unit(step))
            poor.append(f"{step.configuration.name}{over}{size}")
    return good, structured, poor


def _whole_sentence(verification: Verification, *, planned: bool) -> str:
    """Say how large the whole model's residual is, and whether the uncertainty of the parameters explains it.

    ``planned`` says whether joints were locked anywhere but at home.
    """
    joints = [j for run in verification.runs for j in run.joints]
    if verification.outcome == "diverged":
        return "The simulation of the whole model does not stay finite on runs with all joints free."
    scores = ("rmse_over_noise", "over_expected")
    worst, excess = (float(np.nanmax([getattr(j, of) for j in joints])) for of in scores)
    _, one = worst_joint(verification)
    size = in_thousandths(one.rmse_rad, unit_for("rad", [one.prismatic]))
    said = (
        f"The whole model predicts runs with all joints free to {size} (joint {one.joint}), "
        f"within {plain(worst, 3)} × noise on the worst joint"
    )
    closed = [j.rmse_over_noise for run in verification.runs if run.mode == "closed_loop" for j in run.joints]
    if closed and max(closed) < worst:
        said += f", through the stated controller within {plain(max(closed), 3)} × noise"
    if verification.outcome == "as_noise":
        return f"{said}."
    which = "more tests in" if planned else "tests in the"
    postures = f"{which} lock postures that haptid plan (python -m model.plan in a clone) proposes"
    if verification.outcome == "explained":
        return (
            f"{said}; what these tests leave open explains it (RMS over expected at most {excess:.2f}, where one draw "
            f"of it for a whole run gives up to {plain(THRESHOLDS.largest_residual_over_expected)}): {postures} would "
            "close it."
        )
    if verification.outcome == "uncertain":
        widest = max(j.spread_over_noise for j in joints)
        by = f"spreads by {plain(widest)} × noise" if np.isfinite(widest) else "has no known spread"
        return (
            f"{said}. That is uncertain: these tests leave the parameters so open that the prediction {by}, which "
            f"would hide whatever the model lacks; {postures} would narrow it."
        )
    return (
        f"{said}, {plain(excess, 3)} × what noise and the spread of the parameters explain: something is missing in it."
    )


def _overview(steps: Sequence[Step]) -> Section:
    rows: list[tuple[str | Cell, ...]] = []
    for step in steps:
        *cells, outcome = step_row(step)
        rows.append((*cells, word_cell("fit", outcome)))
    table = Table(header=HEADER, rows=rows)
    look = [f"{step.configuration.name.capitalize()}: {sentence}." for step in steps for sentence in attention(step)]
    sentences = [(sentence.replace("..", "."),) for sentence in look]
    tables = (table, Table(header=("worth a second look",), rows=sentences)) if sentences else (table,)
    return Section(title="Overview", anchor="overview", paragraphs=(METHOD,), tables=tables)


def _remarks(remarks: Sequence[str]) -> list[Section]:
    """Return the section of remarks on the data; none where there are no remarks."""
    if not remarks:
        return []
    table = Table(header=("remark",), rows=[(remark,) for remark in remarks])
    words = "What was remarked of the runs before any fit. A slip of units, signs or columns makes every figure wrong."
    return [Section(title="Remarks on the data", anchor="remarks", paragraphs=(words,), tables=(table,))]


def _whole(verification: Verification, embedded: str | None) -> Section:
    rows = [
        (
            run.file,
            run.mode.replace("_", " "),
            str(j.joint),
            f"{j.rmse_rad:.3g}",
            f"{j.rmse_over_noise:.2f}",
            f"{j.spread_rad:.2g}",
            f"{j.over_expected:.2f}",
        )
        for run in verification.runs
        for j in run.joints
    ]
    unit = unit_for("rad", [j.prismatic for run in verification.runs for j in run.joints])
    spread = f"parameter spread [{unit}]"
    header = ("run", "simulated in", "joint", f"RMS [{unit}]", "RMS / noise", spread, "RMS / expected")
    closed = [run for run in verification.runs if run.mode == "closed_loop"] or list(verification.runs)
    text = [f"Controller: {verification.law}."] if verification.law else []
    text.append("Expected is √(noise² + parameter spread²).")
    beside = () if embedded is None else (comparison_table(verification, embedded),)
    return Section(
        title="Whole model",
        anchor="whole",
        paragraphs=tuple(text),
        pictures=tuple(whole_picture(run) for run in closed),
        tables=(*beside, Table(header=header, rows=rows)),
    )


def _links(links: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> Section:
    rows = [
        (link, id, with_error(one["value"], one["std"]), one["unit"], one["status"])
        for link, table in links.items()
        for id, one in table.items()
    ]
    text = (
        "Masses, centroids and inertias that agree with every test, are those of some distribution of mass, and lie "
        "nearest to the first guesses. Single link parameters often stay open where their combinations are known."
    )
    header = ("link", "parameter", "value ± std", "unit", "status")
    return Section(
        title="Links", anchor="links", paragraphs=(text,), tables=(Table(header=header, rows=rows),), folded=True
    )


def _consistency(steps: Sequence[Step]) -> Section:
    agreements = [a for step in steps for a in step.agreements]
    rows = [
        (
            a.name,
            with_error(*a.earlier) if a.earlier else "",
            with_error(*a.later) if a.later else "",
            with_error(*a.pooled) if a.pooled else "",
            f"{a.chi2:.2f} ({a.dof})",
            f"{a.p:.2g}",
            "yes" if a.contradicts else "no",
        )
        for a in agreements
    ]
    header = ("quantity", "earlier test", "later test", "pooled", "χ² (degrees)", "p", "contradicts")
    tables = (Table(header=header, rows=rows),) if rows else ()
    text = consistency_summary(agreements)
    return Section(title="Agreement between tests", anchor="agreement", paragraphs=(text,), tables=tables)
