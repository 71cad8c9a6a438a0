"""The page of a search for missing physics: `Finding` in, `Page` out; verdict first, pictures next, statistics last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.localise import describe_regions
from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.finding.finding import Finding
from haptid.discrepancy.finding.gap import Gap, tell_share
from haptid.discrepancy.fit.solution import SCATTER
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.identification.output.cycle_amplitudes import cycle_amplitudes
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.measurement.values.units import unit_for
from haptid.model.equations.quantity import Quantity
from haptid.report.common.cycles import cycles_picture
from haptid.report.common.numbers import in_thousandths, round_to_error, with_error, write_gain
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.discrepancy.alarm import tell_small_alarm
from haptid.report.discrepancy.glance import is_scatter_alone, position_glance
from haptid.report.discrepancy.motion_pictures import before_after_pictures
from haptid.report.discrepancy.unnamed_section import unnamed_section
from haptid.report.discrepancy.where_pictures import localisation_picture
from haptid.support.linear_algebra import largest_magnitude
from haptid.support.numbers import choose_unit, plain, times, with_unit

LARGEST_ERROR_OF_KNOWN = 0.5
"""Largest standard error over the value [1] at which a parameter counts as known, as the statuses of a fit have it."""
LARGEST_CHANGE_UNTOLD = 5e-4
"""Largest relative change of a parameter that counts as none: a table would show it as 0.0 %."""


class HasFormula(Protocol):
    """An effect as a page names it."""

    @property
    def id(self) -> str:
        """Id in the catalogue."""

    @property
    def formula(self) -> str:
        """Formula as a reader writes it."""


def _cycles(finding: Finding) -> list[Picture]:
    """Draw the amplitudes of the cycles where their scatter is what is missing."""
    if not any(effect.id.endswith(SCATTER) for effect in finding.judgement.effects):
        return []
    found = [cycle_amplitudes(curve.run, curve.after) for curve in finding.curves]
    amplitudes = [one for one in found if one is not None]
    return [cycles_picture(amplitudes, finding.search.study.title)] if amplitudes else []


def _effects(finding: Finding) -> Table:
    rows = [
        (
            *(e.id, id, with_unit(with_error(x.value, x.std), x.unit)),
            *(_ends(x), write_gain(e.evidence), write_share(finding.stability, e.key)),
        )
        for e in finding.judgement.effects
        for id, x in e.parameters.items()
    ]
    header = ("effect", "parameter", "value ± std", "95 % interval", "evidence for it", "named in bags of runs")
    return Table(header=header, rows=rows)


def write_formulas(effects: Sequence[HasFormula]) -> list[str]:
    """Write the formula of each effect once, however many parameters it has.

    Parameters
    ----------
    effects
        Effects of a verdict.

    Returns
    -------
    list of str
        A line an effect: id and formula.
    """
    return [f"{id}: {formula}" for id, formula in dict.fromkeys((e.id, e.formula) for e in effects)]


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


def _ranking(finding: Finding) -> list[Table]:
    found = finding.search
    before, taken = found.before.candidate, _taken_among(found)
    tried = found.trials if _is_among(taken, found.trials) else (*found.trials, taken)
    rows = [
        (
            " + ".join(t.solution.keys) or "noise alone",
            write_gain(before.bic - t.candidate.bic),
            write_gain(2 * (t.candidate.prediction.score - before.prediction.score)),
            _write_adequacy(t),
            "yes" if t is taken else "",
        )
        for t in sorted(tried, key=lambda t: t.candidate.criterion)
    ]
    return [
        Table(
            header=("effects", "gain in BIC", "evidence over the nominal model", "leaves only noise", "taken"),
            rows=list(dict.fromkeys(rows)),  # a model that two ways led to stands there once
            caption=f"Refitted with all parameters{_law_in_words(found)}, over the nominal model, which leaves noise "
            f"{_tell_tests(found.before)}",
        )
    ]


def _tell_tests(before: Trial) -> str:
    """Say how likely noise alone leaves as much as a model, by the tests of its residual and by the scores."""
    told = f"with p = {before.left.p:.2g}"
    if np.isnan(before.left_p):
        return told
    refuted = ", which no refit bore out" if before.refuted else ""
    return f"{told}, and with p = {before.left_p:.2g} by the scores of the catalogue{refuted}"


def _taken_among(found: Search) -> Trial:
    """Return the trial whose model the search ended with; its end itself where no trial has that model.

    The end is judged again after the trials, at a finer step or against what it leaves out, and is another object then.
    """
    best = found.best
    same = [trial for trial in found.trials if _model_of(trial) == _model_of(best)]
    nearest = min(same, key=lambda t: abs(t.candidate.criterion - best.candidate.criterion), default=best)
    return best if _is_among(best, found.trials) else nearest


def _is_among(trial: Trial, trials: Sequence[Trial]) -> bool:
    """Say whether a trial is one of some trials: models of the same effects hold arrays, which have no one equality."""
    return any(one is trial for one in trials)


def _write_adequacy(trial: Trial) -> str:
    """Say whether a trial leaves only noise, and which parameter differs most where only its values by run do."""
    if trial.adequate or not trial.varies:
        return "yes" if trial.adequate else "no"
    return "with other parameters in every run" + (f", {trial.varying} most" if trial.varying else "")


def _model_of(trial: Trial) -> tuple[frozenset[str], tuple[str, ...]]:
    """Return effects and friction laws, which make two trials the same model."""
    return frozenset(trial.solution.keys), trial.solution.equations.friction


def _law_in_words(found: Search) -> str:
    """Name the friction law of the trials where it is not the one that was asked for, which the nominal model has."""
    if found.law is None:
        return ""
    asked = ", ".join(dict.fromkeys(found.before.solution.equations.friction))
    return f" under the friction law {found.law.id} in place of {asked}"


def _prismatic(finding: Finding) -> tuple[bool, ...]:
    return finding.search.study.fitted[0].prismatic


def _in_words(finding: Finding) -> list[str]:
    """Say the residual RMS before and after the search, over the sensor's noise."""
    name = next(name for name in ("sealed", "validate", "fit") if name in finding.gaps)
    runs = "the fitted runs (there are no others)" if name == "fit" else "runs that no fit saw"
    gap, unit = finding.gaps[name], unit_for("rad", _prismatic(finding))
    before = (
        f"Without a change, the simulation misses {runs} by {in_thousandths(gap.before, unit)} (RMS), "
        f"{times(gap.before / gap.noise)} the sensor's noise of {in_thousandths(gap.noise, unit)}."
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
    closed = "" if share is None else f", which closes {tell_share(share)} of the gap{beside}"
    what = "With the stand-in" if finding.judgement.is_stand_in else "With what was found"
    after = f"{what}, it misses them by {in_thousandths(gap.after, unit)}, {times(gap.after / gap.noise)} the noise"
    made = [f"The rebuilt model: fmu/{finding.rebuilt.fmu.path.name}."] if finding.rebuilt else []
    return [f"{before} {after}{closed}.", *made]


def gap_rows(
    gaps: Mapping[str, Gap], shares: Mapping[str, str], scored: str, unit: str, beside: float = 0.0
) -> tuple[str, list[tuple[str, ...]]]:
    """Return the rows of a table of gaps with the unit of their numbers.

    Parameters
    ----------
    gaps
        RMS before and after by ``fit``, ``validate`` and ``sealed``.
    shares
        What is told of the share that is closed, by the same names.
    scored
        What fits and choices saw: ``runs`` or ``stretches``.
    unit
        SI unit of the gaps, without prefix.
    beside
        Size of what the gaps are read beside, as the drive's torque, in ``unit``.

    Returns
    -------
    unit : str
        Unit of the RMS in the rows, as `choose_unit` chooses it for all of them.
    rows : list of tuple of str
        Which runs, RMS before, after and of the noise, and the share.
    """
    names = {
        "fit": f"fitted {scored}",
        "validate": f"{scored} that no fit saw, which chose among candidates",
        "sealed": "sealed runs, which took part in no choice",
    }
    sizes_of_gaps = [(gap.before, gap.after, gap.noise) for gap in gaps.values()]
    shown, factor = choose_unit(largest_magnitude(*sizes_of_gaps, beside), unit)
    rows = []
    for name, gap in gaps.items():
        sizes = [plain(factor * rms, 3) for rms in (gap.before, gap.after, gap.noise)]
        rows.append((names[name], *sizes, shares[name]))
    return shown, rows


def _tell_merged_rows(finding: Finding) -> list[str]:
    """Say how many rows of the recording each row of the search stands for; nothing where it is one."""
    every = finding.search.study.rows_merged
    if every == 1:
        return []
    return [f"Searched with one row in the place of {every}: no reading that was kept shows the difference."]


def _gaps(finding: Finding) -> Table:
    shares = {name: tell_share(gap.closed_beside_scatter) for name, gap in finding.gaps.items()}
    shown, rows = gap_rows(finding.gaps, shares, "runs", unit_for("rad", _prismatic(finding)))
    unit = f"[{shown}]"
    with_what = " with the stand-in" if finding.judgement.is_stand_in else ""
    header = (
        "", f"missed before {unit}", f"after{with_what} {unit}", f"sensor noise {unit}", f"gap closed{with_what}",
    )  # fmt: skip
    return Table(header=header, rows=rows)


def _scores(finding: Finding) -> Table:
    rows = [
        (
            s.key,
            write_gain(s.T),
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
    rows = [(d.key, d.parameter, with_unit(f"{d.size:.2g}", d.unit)) for d in finding.search.scan.detectable]
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
    base, final = finding.search.before.solution.values, finding.search.best.solution.values
    rows = [
        (
            p.id,
            f"{base[p.id]:.5g}" if p.id in base else "–",  # the parameter of a friction law that is new
            f"{final[p.id]:.5g}",
            f"{final[p.id] - base[p.id]:+.2g}" if p.id in base else "–",
            p.unit,
            _why_unknown(finding, p) or _change_in_percent(final[p.id], base.get(p.id)),
        )
        for p in finding.search.plain.solution.equations.parameters
        if not p.fixed
    ]
    return Table(header=("parameter", "before", "after", "change", "unit", "change in percent"), rows=rows)


def _change_in_percent(after: float, before: float | None) -> str:
    return f"{100 * (after / before - 1):+.1f} %" if before else "–"


def _why_unknown(finding: Finding, quantity: Quantity) -> str:
    """Say why the change of a parameter says nothing; nothing where the runs determine the parameter."""
    value, std = finding.search.best.solution.values[quantity.id], finding.errors.get(quantity.id, 0.0)
    ends = np.array([quantity.lower, value, quantity.upper])
    if quantity.scale == "log":
        ends = np.log(ends)
    if min(np.diff(ends)) <= IDENTIFICATION.largest_bound_distance_over_range * (ends[2] - ends[0]):
        return "not known: at its bound"
    return f"not known: its error is {std:.2g}" if std > LARGEST_ERROR_OF_KNOWN * abs(value) else ""


def _parameters_section(finding: Finding) -> Section:
    """Return the table of the parameters before and after; a sentence where none moved."""
    base, final = finding.search.before.solution.values, finding.search.best.solution.values
    free = [p.id for p in finding.search.plain.solution.equations.parameters if not p.fixed]
    known = [p.id for p in finding.search.plain.solution.equations.parameters if not _why_unknown(finding, p)]
    title, anchor = "Parameters that moved", "moved"
    if all(
        id in base and abs(final[id] - base[id]) <= LARGEST_CHANGE_UNTOLD * abs(base[id]) for id in free if id in known
    ):
        return Section(
            title=title, anchor=anchor, paragraphs=["No parameter that the runs determine moved by as much as 0.05 %."]
        )
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
    where = describe_regions(finding.regions, _prismatic(finding), joint)
    evidence = (
        "Evidence is twice the gain in log predictive score on runs that no fit saw: of a named effect over the best "
        "model without it, here over the nominal model. BIC charges each parameter ln n."
    )
    what = "What stands in for it" if j.verdict == "unlisted" else "What is missing"
    runs = "runs that no fit saw" if finding.search.study.unseen else "the fitted runs"
    unnamed = [unnamed_section(j.shape, runs, finding.joints, _prismatic(finding))] if j.shape else []
    where_pictured = localisation_picture(finding.maps, _prismatic(finding))
    sections = [
        Section(
            title="Before and after", anchor="gap", paragraphs=_in_words(finding),
            pictures=[*before_after_pictures(finding.curves), *_cycles(finding)], tables=[_gaps(finding)],
        ),
        *unnamed,
        Section(
            title=what, anchor="what", paragraphs=write_formulas(j.effects) if named else [],
            tables=[_effects(finding)] if named else [],
        ),
        Section(title="What would settle it", anchor="settle", paragraphs=_settle(finding)),
        Section(title="Where the gap was", anchor="where", paragraphs=where, pictures=[where_pictured]),
        Section(title="What was tried", anchor="tried", paragraphs=[evidence], tables=_ranking(finding)),
        _detectable(finding),
        _parameters_section(finding),
        Section(title="Scores of the whole catalogue", folded=True, tables=[_scores(finding)]),
    ]  # fmt: skip
    best, tried = finding.search.base.reached, len(finding.search.base.costs)
    footer = [
        f"{best} of {tried} starts reached the nominal model's best minimum; "
        f"{finding.search.simulations} runs simulated in the search's fits; {finding.wall_s:.0f} s in all.",
        *_tell_merged_rows(finding),
    ]
    return Page(
        title=f"{finding.search.study.title}: {title}",
        lead=" ".join(filter(None, (j.sentence, tell_small_alarm(finding)))),
        sections=[s for s in sections if s.paragraphs or s.pictures or any(t.rows for t in s.tables)],
        synthetic=not measured,
        footer=footer,
        glance=position_glance(finding),
    )
