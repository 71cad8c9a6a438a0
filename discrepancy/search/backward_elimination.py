"""Eliminate effects backward: best `Trial` in, a `Trial` without unnecessary effects out.

Each effect of a model is taken out once. It is left out where the other effects do as well, and exchanged where another
catalogue effect does better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from haptid.discrepancy.candidate.candidate import Candidate, score_candidate
from haptid.discrepancy.candidate.refit import refit_with
from haptid.discrepancy.candidate.trial import Trial, chosen, keys_of
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.trials.finishing import finish_best
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.discrepancy.search.trials.preliminary_fits import begin_effects
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect


def exchange_effects(s: Searcher, best: Trial, start: Trial) -> tuple[Trial, dict[str, Candidate], list[Trial]]:
    """Leave out every effect without which the model does as well, and exchange every effect for a better one.

    Parameters
    ----------
    s
        Tools of the search.
    best
        Best trial of the forward selection.
    start
        Nominal model.

    Returns
    -------
    best, less, trials
        The reduced model, that model without each of its effects by key, and all trials on the way.

    Notes
    -----
    1. Leave out each scatter that the criterion does not need.
    2. Leave out each effect but the last where the criterion does not need it.
    3. Otherwise try a few best-scoring effects in its place. While the others are real, the missing one scores high.

    No effect is exchanged where a model with `most_effects_at_once` effects is still not adequate: its effects then
    follow the discrepancy as terms of a series do. Nor is one exchanged beside effects on top of which the catalogue
    has been tried.
    """
    made: list[Trial] = []
    less = without_each(s, best, start)
    for key in best.solution.random:
        if not best.solution.effects or key not in less:
            continue
        smaller = judge_candidate(s, less[key], start.candidate)
        made.append(smaller)
        if smaller.adequate and _costs(smaller, best) < THRESHOLDS.candidate.least_gain_in_criterion:
            best = smaller
            less = without_each(s, best, start)
    # The last effect was chosen beside all others and has just earned its place; earlier ones were chosen without it.
    for key in [e.key for e in best.solution.effects[:-1]]:
        if len(less) < 2 or key not in less:
            break
        smaller = judge_candidate(s, less[key], start.candidate)
        made.append(smaller)
        cheaper = smaller.adequate and _costs(smaller, best) < THRESHOLDS.candidate.least_gain_in_criterion
        better = smaller if cheaper else None
        full = len(best.solution.effects) >= THRESHOLDS.search.most_effects_at_once
        hopeless = best.left.far or (full and not best.adequate)
        tried_before = keys_of(smaller.solution) in s.extended
        if better is None and not (smaller.adequate or hopeless or tried_before or (not best.adequate and s.is_over())):
            fits = begin_effects(s, smaller.solution, THRESHOLDS.search.most_effects_continued)
            tried = finish_best(s, smaller.candidate, fits)
            made += tried
            winner = chosen(tried)
            better = winner if winner is not None and _improves(winner, best) else None
        if better is not None:
            best = better
            less = without_each(s, best, start)
    return best, less, made


def prune_stand_ins(s: Searcher, made: Sequence[Trial], start: Trial) -> list[Trial]:
    """Remove surrogates from an adequate model whose effects have not all earned their place.

    A surrogate was the best single effect before the true one was found, and has become unnecessary beside it.

    Parameters
    ----------
    s
        Tools of the search.
    made
        Trials of one step.
    start
        Nominal model.

    Returns
    -------
    list of Trial
        Adequate and acceptable trials: the model itself, with the loss of the criterion without its most dispensable
        effect, and models with one effect less, or with two less where one is not enough.

    Notes
    -----
    A Wald statistic may call an effect a surrogate wrongly (a bent spring that weight and stiffness follow a long way),
    so the refit without the effect decides.
    """
    full = [t for t in made if t.adequate and not t.acceptable and len(t.solution.effects) > 1]
    best = min(full, key=lambda t: t.candidate.criterion, default=None)
    if best is None:
        return []
    tried = [judge_candidate(s, less, start.candidate) for less in _less(s, best.solution).values()]
    needed = replace(best, least_evidence=min(_costs(t, best) for t in tried))
    kept = [t for t in (needed, *tried) if t.adequate and t.acceptable]
    return kept or prune_stand_ins(s, tried, start)


def _less(s: Searcher, full: Solution) -> dict[str, Candidate]:
    """Refit a model without each of its effects, by key."""

    def without(study: Study, effect: Effect) -> Candidate:
        return refit_with(study, full, [other for other in full.effects if other is not effect], full.values)

    return dict(zip((e.key for e in full.effects), s.each(without, full.effects), strict=True))


def _costs(smaller: Trial, best: Trial) -> float:
    return smaller.candidate.criterion - best.candidate.criterion


def _improves(winner: Trial, best: Trial) -> bool:
    """Say whether ``winner`` alone is adequate or, if both are alike in this, has the better criterion."""
    if winner.adequate != best.adequate:
        return winner.adequate
    return _costs(winner, best) < 0.0


def without_each(s: Searcher, best: Trial, start: Trial) -> dict[str, Candidate]:
    """Refit the best model without each of its effects, the random ones included.

    Parameters
    ----------
    s
        Tools of the search.
    best
        Best trial.
    start
        Nominal model, which is the best model without its only effect.

    Returns
    -------
    dict
        Candidates by the key of the missing effect.
    """
    full = best.solution
    # Without its only effect the model is the nominal one, which was fitted already.
    if len(full.keys) == 1 and full.effects:
        return {full.keys[0]: start.candidate}
    found = _less(s, full)
    for key, scatter in zip(full.random, full.noise.scatters, strict=True):
        noise = full.noise.but(scatters=tuple(other for other in full.noise.scatters if other is not scatter))
        bare = solve(s.study, full.effects, noise, full.values, x0=full.x0)
        found[key] = score_candidate(s.study, bare, bare.calls)
    return found
