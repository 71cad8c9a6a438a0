"""The page of ``identification.run``: steps, traces and verification in, `Page` out.

It shows, for each joint, measured and simulated positions, parameters with their status, and remedies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from haptid.identification.baseline.friction_loop import friction_loop
from haptid.identification.baseline.prediction import Prediction
from haptid.identification.links.consistency import summary as consistency_summary
from haptid.identification.output.cycle_amplitudes import cycle_amplitudes
from haptid.identification.output.plain_comparison import tell_size_and_share
from haptid.identification.output.summary import HEADER, attention, residual_unit, step_row
from haptid.identification.output.traces import Trace
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.verification.result import Verification
from haptid.measurement.values.run import Run
from haptid.measurement.values.units import unit_for
from haptid.report.common.cycles import cycles_picture
from haptid.report.common.numbers import in_thousandths, with_error
from haptid.report.common.page import Cell, Page, Picture, Section, Table, word_cell
from haptid.report.identification.campaign_comparison import comparison_table
from haptid.report.identification.figures import run_picture, whole_picture
from haptid.report.identification.friction_figures import friction_picture
from haptid.report.identification.glance import (
    LARGEST_RESIDUAL_OVER_EXPECTED,
    glance_table,
    worst_joint,
    worst_score,
)
from haptid.report.identification.parameter_figures import correlation_table, interval_picture
from haptid.report.identification.plain_section import plain_section
from haptid.report.identification.residual_figures import correlation_picture

METHOD = (
    "Residuals are measured minus simulated position over the sensor's noise √(noise² + resolution²/12); 1.00 is the "
    "noise. The initial position of every run, validation runs included, is fitted with the prior N(first sample, "
    "noise²). Standard deviations take the residuals' correlation into account. Status: identified; prior (the data "
    "did not halve the prior's width); unidentifiable (known only within 50 %, or in combinations); at_bound; fixed."
)
FIRST_SHOWN, RUNS_IN_A_ROW = 3, 2
"""Runs that are drawn before the reader unfolds the others, and most runs of one picture."""
MOST_UNFOLDED = 2
"""Most configurations whose sections are open when the page is; of more, the first screen links to each."""
MOST_CORRELATED = 3
"""Most runs of the picture of correlations."""
LARGEST_P_OF_SCATTER = 1e-3
"""Largest p-value at which amplitudes of cycles are drawn: one run in a thousand scatters as much by chance."""


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
    traces: Sequence[Sequence[Trace]],
    predictions: Sequence[Prediction | None],
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
    traces
        Measured and simulated positions of every step's runs.
    predictions
        An unseen run of every step as fit and plain model predict it; None where there is none.
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
    for step, own, prediction in zip(steps, traces, predictions, strict=True):
        parts = [_configuration(step, own), *_further_runs(step, own), _diagnosis(step, own)]
        if step.compared is not None and step.compared.baseline is not None:
            parts.append(plain_section(step, step.compared.baseline, step.compared, prediction))
        sections += [replace(one, folded=one.folded or len(steps) > MOST_UNFOLDED) for one in parts]
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
    good, poor = [], []
    for step in steps:
        worst = worst_score(step)
        if worst is None or worst.use != "validate":
            continue
        if worst.over_noise <= THRESHOLDS.largest_residual_as_noise:
            good.append(step.configuration.name)
        else:
            size = tell_size_and_share(worst, residual_unit(step))
            poor.append(f"{step.configuration.name} ({worst.over_noise:.3g} × noise){size}")
    words = []
    if good:
        all_of_many = len(good) == len(steps) > MOST_UNFOLDED
        where = f"in all {len(good)} configurations" if all_of_many else "; ".join(good)
        words.append(f"On runs that no fit saw, what is left is the sensor's noise: {where}.")
    if poor:
        words.append(f"The residual stays above the noise: {'; '.join(poor)}.")
    if verification.runs:
        planned = any(step.configuration.locked for step in steps)
        words.append(_whole_sentence(verification, planned=planned))
    return " ".join(words)


def _whole_sentence(verification: Verification, *, planned: bool) -> str:
    """Say how large the whole model's residual is, and whether the uncertainty of the parameters explains it.

    ``planned`` says whether joints were locked anywhere but at home.
    """
    joints = [j for run in verification.runs for j in run.joints]
    worst, excess = (max(getattr(j, of) for j in joints) for of in ("rmse_over_noise", "over_expected"))
    _, one = worst_joint(verification)
    size = in_thousandths(one.rmse_rad, unit_for("rad", [one.prismatic]))
    said = (
        f"The whole model predicts runs with all joints free to {size} (joint {one.joint}), within {worst:.3g} × noise "
        "on the worst joint"
    )
    closed = [j.rmse_over_noise for run in verification.runs if run.mode == "closed_loop" for j in run.joints]
    if closed and max(closed) < worst:
        said += f", through the stated controller within {max(closed):.3g} × noise"
    if worst <= THRESHOLDS.largest_residual_as_noise:
        return f"{said}."
    if not excess > LARGEST_RESIDUAL_OVER_EXPECTED:
        which = "more tests in" if planned else "tests in the"
        return (
            f"{said}; what these tests leave open explains it (RMS over expected at most {excess:.2f}): {which} lock "
            "postures that haptid plan (python -m model.plan in a clone) proposes would close it."
        )
    return f"{said}, {excess:.3g} × what noise and the spread of the parameters explain: something is missing in it."


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


def _configuration(step: Step, traces: Sequence[Trace]) -> Section:
    fit = step.fit
    said = [f"Outcome: {fit.outcome.value}.", *attention(step)[(fit.outcome.label != "converged") :], *fit.notes]
    return Section(
        title=step.configuration.name.capitalize(),
        anchor=step.configuration.anchor,
        paragraphs=tuple(s for s in (step.configuration.locked, *said) if s),
        pictures=_run_pictures(step, _first_shown(traces)),
        tables=tuple(
            t for t in (_parameters(step), _profiles(step), _combinations(step), _runs(step), _basins(step)) if t.rows
        ),
    )


def _first_shown(traces: Sequence[Trace]) -> list[Trace]:
    """Return a fitted run and the first that no fit saw."""
    fitted = [t for t in traces if t.score.use == "fit"]
    others = [t for t in traces if t.score.use == "validate"]
    return (fitted[len(fitted) // 2 :][:1] + others)[:FIRST_SHOWN]


def _run_pictures(step: Step, traces: Sequence[Trace]) -> tuple[Picture, ...]:
    return tuple(
        run_picture(traces[k : k + RUNS_IN_A_ROW], step.configuration.name)
        for k in range(0, len(traces), RUNS_IN_A_ROW)
    )


def _further_runs(step: Step, traces: Sequence[Trace]) -> list[Section]:
    """Return the folded section of the runs that are not drawn first; none where all are."""
    shown = [id(trace) for trace in _first_shown(traces)]
    others = [trace for trace in traces if id(trace) not in shown]
    if not others:
        return []
    title = f"{step.configuration.name.capitalize()}: {len(others)} more run{'s' * (len(others) > 1)}"
    return [Section(title=title, pictures=_run_pictures(step, others), folded=True)]


def _diagnosis(step: Step, traces: Sequence[Trace]) -> Section:
    """Return the section on friction, what is left, and how well each parameter is known."""
    name = step.configuration.name
    runs: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in step.configuration.runs}
    shown = _first_shown(traces)
    pictures: list[Picture | None] = [_friction(step)]
    if shown:
        pictures.append(correlation_picture(shown[:MOST_CORRELATED], name))
    if len(step.configuration.free_joints) == 1 and not step.torque_scored:
        found = [cycle_amplitudes(runs[t.score.file, t.score.use], t.simulated[:, 0]) for t in traces]
        scattered = [one for one in found if one is not None and one.p_value < LARGEST_P_OF_SCATTER]
        pictures += [cycles_picture(scattered, name)] if scattered else []
    pictures.append(interval_picture(step.fit, name))
    return Section(
        title=f"{name.capitalize()}: friction, residual, intervals",
        anchor=f"{step.configuration.anchor}-diagnosis",
        pictures=[picture for picture in pictures if picture is not None],
        tables=[table for table in (correlation_table(step.fit),) if table.rows],
    )


def _friction(step: Step) -> Picture | None:
    """Draw the friction of every free joint in the worst run; None where there is no inverse dynamics."""
    worst = worst_score(step)
    if step.compared is None or worst is None:
        return None
    runs = [run for run in step.compared.runs if (run.file, run.use) == (worst.file, worst.use)]
    loops = [friction_loop(step.compared, run, k) for run in runs[:1] for k in range(len(run.free_joints))]
    return friction_picture(loops, step.configuration.name) if loops else None


def _parameters(step: Step) -> Table:
    fit = step.fit
    rows = [
        (
            q.id,
            with_error(value, std) if not q.fixed else f"{value:.4g}",
            q.unit,
            word_cell("status", fit.statuses[q.id]),
            f"{q.initial:.3g}",
            f"[{q.lower:.3g}, {q.upper:.3g}]" if not q.fixed else "",
            q.description,
        )
        for q, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True)
    ]
    header = ("parameter", "value ± std", "unit", "status", "first guess", "bounds", "meaning")
    return Table(header=header, rows=rows, caption="Parameters")


def _profiles(step: Step) -> Table:
    fit, rows = step.fit, []
    for id, one in fit.profiles.items():
        value, std, unit = fit.values[id], fit.std[fit.index(id)], fit.equations.parameter(id).unit
        ends = ["open" if end is None else f"{end:.6g}" for end in (one.lower, one.upper)]
        rows.append((id, *ends, f"{value - 1.96 * std:.6g} to {value + 1.96 * std:.6g}", unit))
    return Table(
        header=("parameter", "from", "to", "value ± 1.96 std", "unit"),
        rows=rows,
        caption="95 % intervals of the profile likelihood: all other parameters adapt to each end",
    )


def _combinations(step: Step) -> Table:
    rows = [
        (" + ".join(f"{c:.4g}·{id}" for id, c in one.coefficients.items()), with_error(one.value, one.std))
        for one in step.fit.combinations
    ]
    return Table(
        header=("combination", "value ± std"), rows=rows, caption="What the data alone know of open parameters"
    )


def _runs(step: Step) -> Table:
    unit = residual_unit(step)
    rows = [
        (s.file, s.use, ", ".join(f"{x:.3g}" for x in s.rmse), f"{s.over_noise:.3f}", f"{s.nrmse:.2e}")
        for s in step.fit.runs
    ]
    excluded = [(r.file, "excluded", "", "", r.reason) for r in step.configuration.runs if r.use == "excluded"]
    header = ("run", "use", f"RMS [{unit}]", "RMS / noise", "RMS / range")
    return Table(header=header, rows=[*rows, *excluded], caption="Runs")


def _basins(step: Step) -> Table:
    rows = [
        (f"{k + 1}", f"{b.over_noise:.4f}", ", ".join(map(str, b.starts)), str(b.simulations))
        for k, b in enumerate(step.fit.basins)
    ]
    header = ("minimum", "RMS / noise", "reached by starts", "simulations")
    return Table(header=header, rows=rows, caption="Minima that the starts reached")


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
