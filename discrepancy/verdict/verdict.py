"""Turn a search into a verdict: `Search` in, `Judgement` out.

1. Decide between nothing missing, named, ambiguous, and unlisted.
2. Refit the named effects at a finer inner step, and compute their standard errors.
3. Widen these where the names leave more than noise, and withdraw a name whose amplitude is not distinguishable from
   zero.
4. Propose the next experiment for rivals, and fit a missing torque without a name for what is unlisted.
5. Say it in one sentence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.inner_step import at_step
from haptid.discrepancy.fit.discontinuity import around, torques
from haptid.discrepancy.fit.scatter import degrees_of_freedom
from haptid.discrepancy.fit.solution import SCATTER, Solution, solve
from haptid.discrepancy.fit.standard_errors import of_curvature, standard_errors
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.unnamed.missing_torque import Shape, missing
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.discrepancy.verdict.next_experiment import Proposal, propose
from haptid.identification.result.fit import Fit
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect, match_parameters
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import MISSING
from haptid.noise.correlation import Scatter
from haptid.support.listener import Progress, ignore_progress

Verdict = Literal["nothing_missing", "named", "partly_named", "ambiguous", "unlisted"]
"""The verdicts of INTERFACES."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedEffect:
    """An effect of the verdict.

    Parameters
    ----------
    id, key, title, formula
        Names of the catalogue effect, and its formula as a reader writes it.
    parameters
        Estimates by id.
    evidence
        Evidence for the effect, as `Search.evidence` defines it.
    """

    id: str
    key: str
    title: str
    formula: str
    parameters: dict[str, Estimate]
    evidence: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """The verdict with its grounds.

    Parameters
    ----------
    verdict
        One of the verdicts.
    effects
        Effects of the best model, nearest surrogates where the verdict is unlisted.
    alternatives
        Rivals, or the best other trials where there are none.
    next_experiment
        Run that separates rivals, for an ambiguous verdict on one joint alone.
    shape
        Missing torque without a name: all of it for an unlisted verdict, what named effects leave where they explain a
        part.
    sentence
        Sentence that an engineer reads first.
    """

    verdict: Verdict
    effects: tuple[NamedEffect, ...]
    alternatives: tuple[Trial, ...]
    next_experiment: Proposal | None
    shape: Shape | None
    sentence: str

    @property
    def is_stand_in(self) -> bool:
        """Whether the effects are no finding, but the nearest of the catalogue to what is unlisted."""
        return self.verdict == "unlisted" and bool(self.effects)

    def beside(self, refit: Fit) -> Judgement:
        """Widen the errors of effects that another fit of the same model finds elsewhere.

        Parameters
        ----------
        refit
            Fit of the model with the effects, through its FMU, from other initial states and without a model of the
            noise: it tells something of a model that leaves more than noise alone.

        Returns
        -------
        Judgement
            An estimate further than two standard errors from the refit's has their distance as standard error.
        """

        def reach(id: str, estimate: Estimate) -> Estimate:
            apart = abs(refit.values.get(id, estimate.value) - estimate.value)
            if apart <= THRESHOLDS.verdict.most_errors_between_fits * estimate.std:
                return estimate
            return Estimate.of_parameter(refit.equations.parameter(id), estimate.value, apart)

        effects = tuple(
            replace(e, parameters={id: reach(id, estimate) for id, estimate in e.parameters.items()})
            for e in self.effects
        )
        return replace(self, effects=effects)


def judge(study: Study, found: Search, tell: Progress = ignore_progress) -> Judgement:
    """Turn a search into a verdict.

    Parameters
    ----------
    study
        Study of the search.
    found
        Result of the search.
    tell
        Told of each step that takes seconds.

    Returns
    -------
    Judgement
        Verdict with effects, alternatives, next experiment or missing torque, and one sentence.
    """
    verdict, fine, solution = verdict_of(found), study, found.best.solution
    errors = of_curvature(solution)
    nothing: tuple[str, ...] = ()
    if verdict in ("named", "partly_named", "ambiguous"):
        tell("standard errors of the named effects")
        fine, at_first = finer(study, solution)
        solution, errors = standard_errors(fine, at_first, solution)
    if verdict == "partly_named":  # what the names leave moves their parameters by as much more than noise does
        errors = errors * found.best.left.over_noise
    # The search judges amplitudes by the curvature. The standard errors over all minima come only here, and may show
    # that the data do not hold the amplitude.
    if verdict in ("named", "partly_named") and (nothing := indistinguishable_from_zero(solution, errors, study.rows)):
        verdict = "unlisted"
    effects = named_effects(found, solution, errors)
    if verdict == "partly_named":  # a scatter may then stand for what has no name
        effects = tuple(e for e in effects if e.key not in solution.random)
    rivals = found.rivals if verdict == "ambiguous" else ()
    if rivals and study.alone:
        tell("a run that would tell the alternatives apart")
    proposal = _proposal(fine, solution, found, rivals) if rivals and study.alone else None
    if verdict in ("unlisted", "partly_named"):
        tell("the shape of what has no name")
    return Judgement(
        verdict=verdict,
        effects=effects,
        alternatives=rivals or _list_rivals(found),
        next_experiment=proposal,
        shape=_shape_of_rest(study, found, verdict),
        sentence=_sentence(verdict, effects, rivals, proposal, found, nothing),
    )


def _shape_of_rest(study: Study, found: Search, verdict: Verdict) -> Shape | None:
    """Fit what has no name: all that is missing, or what effects leave that explain a part, where that is much."""
    if verdict == "unlisted":
        return missing(study, found.plain.solution)
    much = verdict == "partly_named" and found.best.left.far
    return missing(study, found.best.solution, is_near=True) if much else None


def indistinguishable_from_zero(solution: Solution, errors: Array, n: int) -> tuple[str, ...]:
    """Return the first amplitudes that are not distinguishable from zero.

    Parameters
    ----------
    solution
        Fitted model.
    errors
        Standard error of every parameter, shape (n_p,).
    n
        Number of scored residuals.

    Returns
    -------
    tuple of str
        Ids of first amplitudes with lower bound 0 or above whose z² is below the ln n that BIC charges for a parameter.
    """
    std = dict(zip([p.id for p in solution.equations.parameters], errors, strict=True))
    first = [e.parameters[0] for e in solution.effects if not e.threshold]
    least = np.sqrt(np.log(n))
    return tuple(q.id for q in first if q.lower >= 0.0 and solution.values[q.id] < least * std[q.id])


def verdict_of(found: Search) -> Verdict:
    """Decide the verdict.

    Parameters
    ----------
    found
        Result of the search.

    Returns
    -------
    Verdict
        ``unlisted``, ``nothing_missing``, ``named``, ``partly_named`` or ``ambiguous``.

    Notes
    -----
    1. A best model that is not adequate is unlisted: something real is missing that no catalogue effect explains. Where
       its effects remove most of the model discrepancy and no other effect comes near them, it is partly named.
    2. An adequate model without effects means that nothing is missing, or only the friction law that it has.
    3. Several names are unlisted where one of them has little evidence, or where two are powers of one variable: they
       are terms of a series that follows any smooth curve.
    4. A name is unlisted where an effect of its kind that has no name predicts better.
    5. What is unlisted and hardly seen is nothing: where the nominal model leaves noise alone but for a score of the
       catalogue, and the best model predicts held-out runs better by less than rivals have to differ.
    6. Otherwise the effects are named, or ambiguous where rivals predict as well.
    7. A friction law beside which a scatter alone is needed, of which held-out runs show little, is partly named: that
       scatter stands for something smaller.
    """
    keys = found.best.solution.keys
    if (not found.best.adequate and found.standing) or _has_weak_scatter_alone(found):
        return "partly_named"
    weak = len(keys) > 1 and min(map(found.evidence, keys)) < THRESHOLDS.verdict.least_evidence_of_each_name
    if not found.best.adequate or weak or len(_powers(found)) > 1 or found.beaten_by is not None:
        return "nothing_missing" if _is_hardly_seen(found) else "unlisted"
    if not keys:
        return "nothing_missing" if found.law is None else "named"
    return "ambiguous" if found.rivals else "named"


def _has_weak_scatter_alone(found: Search) -> bool:
    """Say whether nothing but a scatter of little evidence stands beside another friction law."""
    if found.law is None or not found.best.adequate or found.beaten_by is not None:
        return False
    solution, least = found.best.solution, THRESHOLDS.verdict.least_evidence_of_each_name
    alone = bool(solution.random) and set(solution.keys) == set(solution.random)
    return alone and min(map(found.evidence, solution.random)) < least


def _is_hardly_seen(found: Search) -> bool:
    """Say whether held-out runs show next to nothing of what a score of the catalogue asked for."""
    best, before = found.best.candidate, found.before
    gain = 2.0 * (best.prediction.score - before.candidate.prediction.score)
    unseen = bool(found.study.unseen) and gain < THRESHOLDS.candidate.rival_criterion_gap
    return before.passes and unseen


def _list_rivals(found: Search) -> tuple[Trial, ...]:
    """Return the best trials with other effects, each set once; rivals of names that stand come first."""
    best: dict[tuple[str, ...], Trial] = {}
    for t in (*found.standing_rivals, *sorted(found.trials, key=lambda t: t.candidate.criterion)):
        if set(t.candidate.ids) != set(found.best.candidate.ids):
            best.setdefault(t.candidate.ids, t)
    return tuple(best.values())[: THRESHOLDS.verdict.most_alternatives_listed]


def _powers(found: Search) -> list[str]:
    """Return ids of the best model's effects that are a torque polynomial in the position."""
    return [e.id for e in found.best.solution.effects if e.polynomial]


def finer(study: Study, solution: Solution) -> tuple[Study, Solution]:
    """Refit at a finer inner step, with contacts sharpened.

    Parameters
    ----------
    study
        Study of the search.
    solution
        Best model.

    Returns
    -------
    study, solution
        Study at the finer step and the refitted model; both as given where the finer simulation is not finite.

    Notes
    -----
    An error of time that is invisible in the readings is no small share of a lag as short as a step.
    """
    divisor = THRESHOLDS.verdict.reported_step_divisor
    if solution.touching:
        divisor = THRESHOLDS.verdict.contact_step_divisor
    fine = at_step(study, min(study.factory.step, study.factory.coarse / divisor))
    sharper = THRESHOLDS.verdict.sharper_contact_factor
    effects = tuple(e.sharper_by(sharper) if e.touches else e for e in solution.effects)
    values = {id: p for id, p in solution.values.items() if id not in {e.edge for e in effects}}
    again = solve(fine, effects, solution.noise, values, x0=solution.x0)
    return (fine, again) if again.finite else (study, solution)


def named_effects(found: Search, solution: Solution, errors: Array) -> tuple[NamedEffect, ...]:
    """Return the effects of a model with their estimates and evidence.

    Parameters
    ----------
    found
        Result of the search.
    solution
        Best model, at the step at which its parameters are reported.
    errors
        Standard error of every parameter, shape (n_p,).

    Returns
    -------
    tuple of NamedEffect
        Effects of the equations, then the scatters of the noise.
    """
    std = dict(zip([p.id for p in solution.equations.parameters], errors, strict=True))
    values = solution.values
    named = [
        NamedEffect(
            id=e.id, key=e.key, title=e.title, formula=e.formula,
            parameters={x.id: _estimate(e, x, float(std[x.id]), values, found.study.fitted)
                        for x in e.parameters if not x.fixed},
            evidence=found.evidence(e.key),
        )
        for e in solution.effects
    ]  # fmt: skip
    law = (_friction(found.law, solution, std, found),) if found.law else ()
    return (*law, *named, *(_random(scatter, solution, found) for scatter in solution.noise.scatters))


def _friction(law: FrictionLaw, solution: Solution, std: Mapping[str, float], found: Search) -> NamedEffect:
    """Name the friction law that took the place of the one that was asked for."""
    values = solution.values
    estimates = {
        q.id: Estimate.of_parameter(q, values[q.id], float(std[q.id]))
        for q in solution.equations.parameters
        if q.id in law.ids and not q.fixed
    }
    return NamedEffect(
        id=MISSING, key=f"{MISSING}:{law.id}", title=f"{law.title} friction", formula="; ".join(law.formulas),
        parameters=estimates, evidence=found.evidence_for_law,
    )  # fmt: skip


def _random(scatter: Scatter, solution: Solution, found: Search) -> NamedEffect:
    """Name a scatter; its error is that of a standard deviation."""
    effect = found.study.in_joint(found.study.catalogue[SCATTER], scatter.column)
    problem = solution.problem
    freedom = degrees_of_freedom(problem.runs, problem.whiteners, solution.noise.scatters, scatter)
    estimate = Estimate.of_deviation(scatter.size, freedom, "1")
    return NamedEffect(
        id=effect.id, key=effect.key, title=effect.title, formula=effect.formula,
        parameters={effect.parameters[0].id: estimate}, evidence=found.evidence(effect.key),
    )  # fmt: skip


def _estimate(
    effect: Effect, quantity: Quantity, std: float, values: Mapping[str, float], runs: Sequence[Run]
) -> Estimate:
    """Return the estimate of one parameter.

    The place of a discontinuity is known no better than its rounding, and than the interval between the torques that
    were sent around it: anywhere in it nothing changes (uniform distribution, interval/√12).
    """
    value = values[quantity.id]
    if effect.threshold and quantity is effect.parameters[0]:
        low, high = around(value, torques(runs, effect))
        std = float(np.linalg.norm([std, values[effect.edge] * value, (high - low) / np.sqrt(12.0)]))
    return Estimate.of_parameter(quantity, value, std)


def at_their_bounds(trials: Sequence[Trial]) -> tuple[str, ...]:
    """Return the effects that alone are adequate, but with an amplitude of nothing or a parameter at its bound.

    Parameters
    ----------
    trials
        Trials of the search.

    Returns
    -------
    tuple of str
        Ids of these effects, each once.
    """
    near = [t for t in trials if t.adequate and t.at_bound and len(t.solution.effects) == 1]
    return tuple(dict.fromkeys(t.solution.effects[0].id for t in near))


def _proposal(fine: Study, winner: Solution, found: Search, rivals: Sequence[Trial]) -> Proposal:
    """Propose the run that separates the rivals most; no run separates rivals with the same equations.

    Rivals are refitted at the finer step as the winner is, since a torque faster than any that was sent shows
    integration errors that the existing runs do not. Variants that predict as well may be the truth too, on both sides.
    """
    apart = [t for t in rivals if not _same_equations(found.best, t)]
    against = apart or list(rivals)
    others = [finer(fine, t.solution)[1] for rival in against for t in (rival, *found.variants(rival))]
    winners = [winner, *(finer(fine, t.solution)[1] for t in found.variants(found.best))]
    proposal = propose(fine, winners, others)
    return proposal if apart else replace(proposal, evidence=0.0, repeats=THRESHOLDS.verdict.most_repeats + 1)


def _same_equations(best: Trial, rival: Trial) -> bool:
    """Say whether a rival has the equations of the best model under other names."""
    pairs = zip(best.solution.effects, rival.solution.effects, strict=False)
    alike = len(best.solution.effects) == len(rival.solution.effects)
    return alike and all(a.key == b.key or match_parameters(a, b) is not None for a, b in pairs)


def _sentence(
    verdict: Verdict,
    effects: tuple[NamedEffect, ...],
    rivals: tuple[Trial, ...],
    proposal: Proposal | None,
    found: Search,
    nothing: Sequence[str] = (),
) -> str:
    names = " and ".join(f"{e.id} ({e.title})" for e in effects)
    if verdict == "nothing_missing":
        return "Nothing is missing: what is left between simulation and measurement is noise."
    if verdict == "named":
        return f"Missing in the model: {names}."
    if verdict == "partly_named":
        told = f"Missing in the model: {names}; beside it, something smaller that no effect of the catalogue explains."
        return told + _tell_standing_rivals(found)
    if verdict == "ambiguous":
        others = ", or ".join(" with ".join(_with_title(id, r, found) for id in r.candidate.ids) for r in rivals)
        if proposal is None:
            more = "tests of each joint alone may"
        else:
            more = "the proposed run would" if proposal.tells else "nor would any other within their torque"
        told = f"Missing in the model: {names}, or else {others}; these runs cannot tell, {more}."
        # The action of the page follows the same proposal.
        return told if proposal is None or proposal.tells else f"{told} Either serves as a model of these motions."
    cut = f" Combinations beyond {found.study.effort} simulated runs were not tried (--effort)." if found.cut else ""
    like = f" It is like {names}, but {' and '.join(nothing)} may be 0." if nothing else _nearest(found, names)
    return f"Something is missing that no effect of the catalogue explains.{like}{cut}"


def _tell_standing_rivals(found: Search) -> str:
    """Say which declared rivals do nearly as well in the place of a name that stands; empty without such rivals."""
    best, told = found.best.solution, []
    for rival in found.standing_rivals:
        replaced = [e.id for e in best.effects if e.id not in rival.solution.ids]
        others = [f"{e.id} ({e.title})" for e in rival.solution.effects if e.id not in best.ids]
        told.append(f" {' and '.join(others)} does nearly as well in the place of {' and '.join(replaced)}.")
    return "".join(dict.fromkeys(told))


def _with_title(id: str, trial: Trial, found: Search) -> str:
    """Return the id of one of a trial's effects; an unlisted effect with its title."""
    listed = {e.id for e in found.study.catalogue.values()}
    return next((f"{id} ({e.title}, no entry)" for e in trial.solution.effects if e.id == id and id not in listed), id)


def _nearest(found: Search, names: str) -> str:
    """Say what an effect without a name resembles."""
    powers = _powers(found)
    if like := at_their_bounds(found.trials):
        return f" It is like {' or '.join(like)}, which leaves noise alone with a parameter at its bound only."
    if len(powers) > 1:
        return f" It bends with position: {' and '.join(powers)} follow it as powers follow any curve."
    if (other := found.beaten_by) is not None:
        titles = " and ".join(e.title for e in other.solution.effects if e.key not in found.study.catalogue)
        return f" It is of the kind of {names}, but not that: {titles} would follow it better."
    if found.best.varies:
        most = f" ({found.best.varying} differs most)" if found.best.varying else ""
        return (
            f" {names} would leave noise alone, but with other parameters in every run{most}: it only stands in for it."
        )
    return f" The nearest of the catalogue, {names}, only stands in for it: that is no finding." if names else ""
