"""The page of a search for missing physics: `Finding` in, `Page` out; verdict first, pictures next, statistics last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from haptid.discrepancy.detect.localise import AXES, Map, describe_regions
from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.fit.solution import SCATTER
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.unnamed.missing_torque import Shape
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.identification.output.cycle_amplitudes import cycle_amplitudes
from haptid.measurement.values.units import unit_for
from haptid.report.common.charts import picture_of
from haptid.report.common.cycles import cycles_picture
from haptid.report.common.numbers import round_to_error, with_error
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.common.style import ACCENT, BAND, MEASURED, RESIDUAL, SIMULATED, figure, style
from haptid.report.discrepancy.glance import is_scatter_alone, position_glance
from haptid.support.numbers import plain

RUNS_IN_A_ROW = 2
"""Most runs of one picture."""
LARGEST_CHANGE_UNTOLD = 5e-4
"""Largest relative change of a parameter that counts as none: a table would show it as 0.0 %."""
LEAST_SHARE_EXPLAINED = 0.5
"""Share of the model discrepancy below which a torque over one or two variables does not explain most of it [1]."""


def before_after_pictures(curves: tuple[Curve, ...]) -> list[Picture]:
    """Draw all runs, two in a picture.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    list of Picture
        As `before_after_picture` draws them.
    """
    return [before_after_picture(curves[k : k + RUNS_IN_A_ROW]) for k in range(0, len(curves), RUNS_IN_A_ROW)]


def before_after_picture(curves: tuple[Curve, ...]) -> Picture:
    """Draw position and residual of the nominal and the final model.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    Picture
        What `before_after_figure` draws.
    """
    unseen = all(curve.run.use == "validate" for curve in curves)
    runs = "Runs that no fit saw" if unseen else "Fitted runs (the campaign has none to validate on)"
    caption = f"{runs}. Above: the motion. Below: what the simulation misses, before and after."
    made = before_after_figure(curves)
    return picture_of(made, caption=caption, alt="measured and simulated position, before and after")


def before_after_figure(curves: tuple[Curve, ...]) -> Figure:
    """Draw position and residual of the nominal and the final model on the first two runs.

    Parameters
    ----------
    curves
        Runs with their simulations before and after the search.

    Returns
    -------
    Figure
        A column a run: positions above, residuals with the sensor's ±2σ below.
    """
    shown = curves[:RUNS_IN_A_ROW]
    with style():
        made = figure(8.5, 4.4)
        axes = made.subplots(2, len(shown), squeeze=False, sharex="col", sharey="row", height_ratios=(1, 1.5))
        for column, curve in enumerate(shown):
            several = len({c.run.free_joints for c in curves}) > 1
            draw_motion(axes[0, column], curve)
            title = curve.run.file + f", joint {curve.run.free_joints[0]}" * several
            axes[0, column].set_title(title, fontsize=8)
            draw_residuals(axes[1, column], curve)
            axes[1, column].set_xlabel("time [s]")
        slides = [p for curve in shown for p in curve.run.prismatic]
        axes[0, 0].set_ylabel(f"position [{unit_for('rad', slides)}]")
        axes[1, 0].set_ylabel(f"residual [{unit_for('mrad', slides)}]")
        for row in axes:
            row[0].legend(fontsize=7, ncols=3, loc="upper center")
            low, high = row[0].get_ylim()
            row[0].set_ylim(low, high + 0.2 * (high - low))
    return made


def _cycles(finding: Finding) -> list[Picture]:
    """Draw the amplitudes of the cycles where their scatter is what is missing."""
    if not any(effect.id.endswith(SCATTER) for effect in finding.judgement.effects):
        return []
    found = [cycle_amplitudes(curve.run, curve.after) for curve in finding.curves]
    amplitudes = [one for one in found if one is not None]
    return [cycles_picture(amplitudes, finding.search.study.title)] if amplitudes else []


def draw_motion(axis: Axes, curve: Curve) -> None:
    """Draw measured position and the simulations before and after the search, over time.

    Parameters
    ----------
    axis
        Axes to draw on.
    curve
        Run of one joint with its simulations.
    """
    axis.plot(curve.run.t, curve.run.y[:, 0], color=MEASURED, label="measured", lw=3.0, alpha=0.35)
    axis.plot(curve.run.t, curve.before, color=ACCENT, ls="--", label="simulated before")
    axis.plot(curve.run.t, curve.after, color=SIMULATED, label="simulated after")


def draw_residuals(axis: Axes, curve: Curve) -> None:
    """Draw what the simulations before and after the search miss, with the sensor's ±2σ, over time.

    Parameters
    ----------
    axis
        Axes to draw on.
    curve
        Run of one joint with its simulations.
    """
    t, y = curve.run.t, curve.run.y[:, 0]
    axis.plot(t, 1e3 * (y - curve.before), color=ACCENT, lw=0.7, label="before")
    axis.plot(t, 1e3 * (y - curve.after), color=SIMULATED, lw=0.7, label="after")
    band = [2e3 * s * curve.run.sensor_std[0] for s in (-1, 1)]
    axis.axhspan(*band, color=BAND, alpha=0.5, lw=0, label="±2σ of the sensor")


def where_picture(maps: tuple[Map, ...], prismatic: Sequence[bool]) -> Picture:
    """Draw the residual localisation: the shares of excess residual energy and of samples in every bin of a variable.

    Parameters
    ----------
    maps
        Excess of residual energy over the noise, one map per variable.
    prismatic
        Whether each joint is prismatic, for the units.

    Returns
    -------
    Picture
        What `where_figure` draws.
    """
    return picture_of(
        where_figure(maps, prismatic),
        caption="Where the base model misses: each bar's share of the squared residual above the sensor's noise. Where "
        "a bar stands above the line, the gap is larger than the share of samples (of the spectrum, over frequency).",
        alt="residual energy over position, speed, torque, time, cycle, direction, run and frequency",
    )


def where_figure(maps: tuple[Map, ...], prismatic: Sequence[bool]) -> Figure:
    """Draw the shares of excess residual energy and of samples in every bin of each variable.

    Parameters
    ----------
    maps, prismatic
        As `where_picture` takes them.

    Returns
    -------
    Figure
        A panel a variable, shares in %.
    """
    with style():
        made = figure(8.5, 4.4)
        axes = made.subplots(2, -(-len(maps) // 2), sharey=True)
        for axis, m in zip(axes.ravel(), maps, strict=True):
            draw_shares(axis, m, prismatic)
        for row in axes:
            row[0].set_ylabel("share [%]")
        axes[0, 0].legend(fontsize=7)
    return made


def draw_shares(axis: Axes, m: Map, prismatic: Sequence[bool]) -> None:
    """Draw the shares of excess residual energy and of samples in every bin of a variable.

    Parameters
    ----------
    axis
        Axes to draw on.
    m
        Excess of residual energy over one variable.
    prismatic
        Whether each joint is prismatic, for the units.
    """
    gap, rows = (100 * part / max(part.sum(), 1e-300) for part in (np.maximum(m.excess, 0.0), m.rows))
    edges = m.edges + 1.0 if m.variable == "cycle" else m.edges
    axis.bar(edges[:-1], gap, np.diff(edges), align="edge", color=RESIDUAL, alpha=0.75, label="of the gap")
    axis.stairs(rows, edges, color=MEASURED, lw=0.8, label="of the samples")
    name, unit = AXES[m.variable]
    axis.set_xlabel(f"{name} [{unit_for(unit, prismatic)}]" if unit else name, fontsize=8)
    _ticks(axis, m)


def _ticks(axis: Axes, m: Map) -> None:
    if m.labels:
        axis.set_xticks((m.edges[:-1] + m.edges[1:]) / 2, [x.split(".csv")[0] for x in m.labels])
    if m.variable == "cycle":
        axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    if m.variable == "run":
        axis.tick_params(axis="x", rotation=90, labelsize=6)
    if m.variable == "frequency_rad_s":
        axis.set_xscale("log")


def _effects(finding: Finding) -> Table:
    rows = [
        (
            *(e.id, e.formula, id, _with_unit(with_error(x.value, x.std), x.unit)),
            *(_ends(x), f"{e.evidence:.0f}", write_share(finding.stability, e.key)),
        )
        for e in finding.judgement.effects
        for id, x in e.parameters.items()
    ]
    header = ("effect", "formula", "parameter", "value ± std", "95 % interval", "evidence", "named in bags of runs")
    return Table(header=header, rows=rows)


def write_share(stability: Mapping[str, float], key: str) -> str:
    """Write the share of bags in which an effect keeps its name; a dash where it has no fitted amplitude.

    Parameters
    ----------
    stability
        Shares [1] by key.
    key
        Key of the effect.

    Returns
    -------
    str
        In per cent.
    """
    share = stability.get(key)
    return "–" if share is None else f"{100 * share:.0f} %"


def _ends(estimate: Estimate) -> str:
    return " to ".join(round_to_error(end, estimate.std) for end in estimate.interval)


def _with_unit(number: str, unit: str) -> str:
    return number if unit == "1" else f"{number} {unit}"


def _ranking(finding: Finding) -> list[Table]:
    found = finding.search
    before = found.plain.candidate
    rows = [
        (
            " + ".join(t.solution.keys) or "noise alone",
            f"{before.bic - t.candidate.bic:.0f}",
            f"{2 * (t.candidate.prediction.score - before.prediction.score):.0f}",
            "yes" if t.adequate else "with other parameters in every run" if t.varies else "no",
            "yes" if t is found.best else "",
        )
        for t in sorted(found.trials, key=lambda t: t.candidate.criterion)
    ]
    return [
        Table(
            header=("effects", "gain in BIC", "evidence on unseen runs", "leaves only noise", "taken"),
            rows=list(dict.fromkeys(rows)),  # a model that two ways led to stands there once
            caption=f"Refitted with all parameters, over the base model, which leaves noise with p = "
            f"{np.nanmin([found.plain.left.p, found.plain.left_p]):.2g}",
        )
    ]


def _slides(finding: Finding) -> tuple[bool, ...]:
    return finding.search.study.fitted[0].prismatic


def _in_words(finding: Finding) -> list[str]:
    """Say the residual RMS before and after the search, over the sensor's noise."""
    name = next(name for name in ("sealed", "validate", "fit") if name in finding.gaps)
    runs = "the fitted runs (there are no others)" if name == "fit" else "runs that no fit saw"
    gap, unit = finding.gaps[name], unit_for("mrad", _slides(finding))
    before = (
        f"Without a change, the simulation misses {runs} by {1e3 * gap.before:.3g} {unit} (RMS), "
        f"{plain(gap.before / gap.noise)} times the sensor's noise of {1e3 * gap.noise:.3g} {unit}."
    )
    if not finding.judgement.effects or finding.judgement.verdict == "nothing_missing":
        return [before]
    if is_scatter_alone(finding):
        sizes = {effect.id: next(iter(effect.parameters.values())) for effect in finding.judgement.effects}
        told = ", ".join(f"{id} {100 * one.value:.2g} % ± {100 * one.std:.1g} %" for id, one in sizes.items())
        return [
            before,
            f"What is missing is random: the amplitude of each cycle differs from the last by chance ({told}, one "
            "standard deviation). No simulation can follow it, so the residual stays as it is. What changes is the "
            "noise model: intervals and bands that leave the scatter out are too narrow.",
        ]
    share, beside = gap.closed_beside_scatter, "" if gap.beside is None else " that is no scatter of the amplitude"
    stand_in = finding.judgement.verdict == "unlisted"
    closed = "" if share is None or stand_in else f", which closes {100 * share:.1f} % of the gap{beside}"
    what = "With the stand-in" if stand_in else "With what was found"
    after = f"{what}, it misses them by {1e3 * gap.after:.3g} {unit}, {plain(gap.after / gap.noise)} times"
    made = [f"The rebuilt model: fmu/{finding.rebuilt.fmu.path.name}."] if finding.rebuilt else []
    return [f"{before} {after} the noise{closed}.", *made]


def _gaps(finding: Finding) -> Table:
    names = {
        "fit": "fitted runs",
        "validate": "runs that no fit saw, which chose among candidates",
        "sealed": "sealed runs, which took part in no choice",
    }
    unlisted = finding.judgement.verdict == "unlisted"
    rows = [
        (
            names[name], f"{1e3 * g.before:.3g}", f"{1e3 * g.after:.3g}", f"{1e3 * g.noise:.3g}",
            "–" if unlisted or g.closed_beside_scatter is None else f"{100 * g.closed_beside_scatter:.1f} %",
        )
        for name, g in finding.gaps.items()
    ]  # fmt: skip
    unit = f"[{unit_for('mrad', _slides(finding))}]"
    return Table(header=("", f"missed before {unit}", f"after {unit}", f"sensor noise {unit}", "gap closed"), rows=rows)


def _scores(finding: Finding) -> Table:
    rows = [
        (
            s.key,
            f"{s.T:.0f}",
            f"{s.dof}",
            "below 1e-12" if s.family_p < 1e-12 else f"{s.family_p:.2g}",
            _write_flipped(s),
        )
        for s in finding.search.scan.scores
    ]
    tests = finding.search.scan.tests
    caption = (
        f"p over the whole catalogue, which amounts to {tests:.0f} independent tests, before anything was added: by "
        "the noise model, and without one, by random signs of stretches of what is left "
        f"(at least 1/{THRESHOLDS.detect.random_draws + 1})"
    )
    return Table(header=("entry", "score", "degrees of freedom", "p", "p by signs"), rows=rows, caption=caption)


def _write_flipped(score: Score) -> str:
    return "–" if score.flipped_p is None else f"{score.flipped_p:.2g}"


def _detectable(finding: Finding) -> Section:
    rows = [(d.key, d.parameter, _with_unit(f"{d.size:.2g}", d.unit)) for d in finding.search.scan.detectable]
    none = finding.judgement.verdict == "nothing_missing"
    return Section(
        title="How small an effect would have been seen", anchor="detectable", folded=not none,
        paragraphs=[
            "Nine in ten effects of this size would have been found in these runs at a false-alarm rate of 1 % over "
            "the whole catalogue (to first order, at the shape at which the effect shows best)."
        ],
        tables=[Table(header=("entry", "parameter", "smallest size"), rows=rows)],
    )  # fmt: skip


def _make_parameter_table(finding: Finding) -> Table:
    base, final = finding.search.plain.solution.values, finding.search.best.solution.values
    rows = [
        (
            p.id,
            f"{base[p.id]:.5g}",
            f"{final[p.id]:.5g}",
            f"{100 * (final[p.id] / base[p.id] - 1):+.1f} %" if base[p.id] else "–",
            p.unit,
        )
        for p in finding.search.plain.solution.equations.parameters
        if not p.fixed
    ]
    return Table(header=("parameter", "before", "after", "change", "unit"), rows=rows)


def _moved(finding: Finding) -> Section:
    """Return the table of the parameters before and after; a sentence where none moved."""
    base, final = finding.search.plain.solution.values, finding.search.best.solution.values
    free = [p.id for p in finding.search.plain.solution.equations.parameters if not p.fixed]
    title, anchor = "Parameters that moved", "moved"
    if all(abs(final[id] - base[id]) <= LARGEST_CHANGE_UNTOLD * abs(base[id]) for id in free):
        return Section(title=title, anchor=anchor, paragraphs=["No parameter moved by as much as 0.05 %."])
    return Section(title=title, anchor=anchor, tables=[_make_parameter_table(finding)])


def _settle(finding: Finding) -> list[str]:
    proposal = finding.judgement.next_experiment
    if proposal is None:
        return []
    run, separation = proposal.as_json()["run"], proposal.separation
    which = "The run that would tell" if proposal.tells else "The run that comes nearest"
    once = (
        f"; refitted to it, the rivals still differ by {plain(separation)} times the noise"
        if proposal.repeats == 1
        else ""
    )
    return [f"{which}: {run}{once}."]


def _describe_unnamed(shape: Shape, runs: str, finding: Finding) -> Section:
    """Return the section on the missing torque as a function of one or two variables."""
    names = " and ".join(AXES[variable][0] for variable in shape.variables)
    prismatic = [_slides(finding)[finding.joints.index(shape.joint)]]
    joint = f" in joint {shape.joint}" if len(finding.joints) > 1 else ""
    closed = _write_closed(shape)
    lines = [f"As a torque{joint} over {names} alone, what is missing would close {closed} of the gap on {runs}."]
    if shape.alone:
        lines.append(f"Over {AXES[shape.alone.variables[0]][0]} alone it would close {_write_closed(shape.alone)}.")
    if len(finding.joints) > 1 and "position_rad" in shape.variables:
        lines.append("Gravity in the base bends with position too: the base may hold a part of the bend.")
    if shape.closed < LEAST_SHARE_EXPLAINED:
        lines.append("Most of it does not live there: it depends on other variables, or has a state of its own.")
    if shape.suggestion:
        lines.append(f"A formula that follows it, a suggestion and no finding: {shape.suggestion}.")
    return Section(
        title="What is missing, without a name",
        anchor="shape",
        paragraphs=lines,
        pictures=[shape_picture(shape, prismatic)],
        tables=[] if shape.alone else [_curve(shape, prismatic)],
    )


def _write_closed(shape: Shape) -> str:
    return f"{100 * max(shape.closed, 0.0):.1f} %"


def _curve(shape: Shape, prismatic: Sequence[bool]) -> Table:
    rows = zip(shape.knots[0], shape.torque, shape.std, strict=True)
    return Table(
        header=(_axis(shape.variables[0], prismatic), f"torque ± std [{unit_for('N m', prismatic)}]"),
        rows=[(f"{x:.4g}", with_error(y, std)) for x, y, std in rows],
    )


def _axis(variable: str, prismatic: Sequence[bool]) -> str:
    name, turning = AXES[variable]
    return f"{name} [{unit_for(turning, prismatic)}]"


def shape_picture(shape: Shape, prismatic: Sequence[bool]) -> Picture:
    """Draw the missing torque over one variable with a band of two standard errors, or over two beside its error.

    Parameters
    ----------
    shape
        Torque with its standard error over one or two variables.
    prismatic
        Whether the joint is prismatic, for the units.

    Returns
    -------
    Picture
        Its caption says what the nominal model can hold and is left out.
    """
    names = " and ".join(AXES[variable][0] for variable in shape.variables)
    with style():
        made = figure(8.5 if shape.alone else 5.6, 2.8)
        draw = _surface if shape.alone else _line
        draw(made, shape, prismatic)
    band = "its standard error beside it" if shape.alone else "with ±2 standard errors"
    caption = (
        f"The torque that the base model lacks, counted as the drive's is, as a function of {names} fitted together "
        f"with all its parameters, {band}. What springs, friction and gain of the base hold, a constant and straight "
        "lines over position, speed or torque, is left out."
    )
    return picture_of(made, caption=caption, alt=f"missing torque over {names}")


def _line(made: Figure, shape: Shape, prismatic: Sequence[bool]) -> None:
    axis, (knots,) = made.subplots(), shape.knots
    axis.axhline(0.0, color=MEASURED, lw=0.5)
    axis.fill_between(
        knots, shape.torque - 2 * shape.std, shape.torque + 2 * shape.std, color=RESIDUAL, alpha=0.3, lw=0
    )
    axis.plot(knots, shape.torque, color=RESIDUAL, marker="o", ms=2.5, lw=1)
    axis.set_xlabel(_axis(shape.variables[0], prismatic))
    axis.set_ylabel(f"missing torque [{unit_for('N m', prismatic)}]")


def _surface(made: Figure, shape: Shape, prismatic: Sequence[bool]) -> None:
    unit, largest = unit_for("N m", prismatic), float(np.abs(shape.torque).max())
    parts = (
        (shape.torque, f"missing torque [{unit}]", {"cmap": "RdBu_r", "vmin": -largest, "vmax": largest}),
        (shape.std, f"standard error [{unit}]", {"cmap": "Greys", "vmin": 0.0}),
    )
    first, second = shape.knots
    for axis, (values, label, look) in zip(made.subplots(1, 2, sharey=True), parts, strict=True):
        drawn = axis.pcolormesh(second, first, values, shading="gouraud", **look)
        made.colorbar(drawn, ax=axis, label=label)
        axis.set_xlabel(_axis(shape.variables[1], prismatic))
        axis.set_ylabel(_axis(shape.variables[0], prismatic))


def discrepancy_page(finding: Finding, title: str, *, measured: bool) -> Page:
    """Render the page of one study.

    Parameters
    ----------
    finding
        Search, judgement and curves of the study.
    title
        Title of the campaign, which follows the study's title.
    measured
        Whether the data are measured (else the page says SYNTHETIC DATA).

    Returns
    -------
    Page
        Content of the page, without sections that have no content.
    """
    j = finding.judgement
    named = bool(j.effects) and j.verdict != "nothing_missing"
    joint = f" of joint {finding.gap_joint}" if len(finding.joints) > 1 else ""
    where = describe_regions(finding.regions, _slides(finding), joint)
    evidence = (
        "Evidence is twice the gain in log predictive score on runs that no fit saw; BIC charges each parameter ln n."
    )
    what = "What stands in for it" if j.verdict == "unlisted" else "What is missing"
    runs = "runs that no fit saw" if finding.search.study.unseen else "the fitted runs"
    unnamed = [_describe_unnamed(j.shape, runs, finding)] if j.shape else []
    where_pictured = where_picture(finding.maps, _slides(finding))
    sections = [
        Section(
            title="Before and after", anchor="gap", paragraphs=_in_words(finding),
            pictures=[*before_after_pictures(finding.curves), *_cycles(finding)], tables=[_gaps(finding)],
        ),
        *unnamed,
        Section(title=what, anchor="what", tables=[_effects(finding)] if named else []),
        Section(title="What would settle it", anchor="settle", paragraphs=_settle(finding)),
        Section(title="Where the gap was", anchor="where", paragraphs=where, pictures=[where_pictured]),
        Section(title="What was tried", anchor="tried", paragraphs=[evidence], tables=_ranking(finding)),
        _detectable(finding),
        _moved(finding),
        Section(title="Scores of the whole catalogue", folded=True, tables=[_scores(finding)]),
    ]  # fmt: skip
    best, tried = finding.search.base.reached, len(finding.search.base.costs)
    footer = [
        f"{best} of {tried} starts reached the base model's best minimum; "
        f"{finding.search.simulations} runs simulated in the search's fits; {finding.wall_s:.0f} s in all."
    ]
    return Page(
        title=f"{finding.search.study.title}: {title}",
        lead=j.sentence,
        sections=[s for s in sections if s.paragraphs or s.pictures or any(t.rows for t in s.tables)],
        synthetic=not measured,
        footer=footer,
        glance=position_glance(finding),
    )
