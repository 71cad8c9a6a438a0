"""Begin single effects on top of a model: `Searcher` and `Solution` in, preliminary fits out, best first.

- Where the residual is informative, begin at the scores, and continue the promising effects (`begin_effects`).
- Where it is not, fit through homotopy from the first guesses (`fit_from_first_guesses`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from haptid.discrepancy.candidate.refit import begin, continue_refit
from haptid.discrepancy.candidate.starts import starts_of
from haptid.discrepancy.candidate.trial import keys_of
from haptid.discrepancy.detect.score_tests import Scan, Score
from haptid.discrepancy.fit.homotopy import Guided, at_fine, release_observer, start_holding_last_shape
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.trials.searcher import Searcher, leaves_much
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect

Tried = tuple[tuple[Effect, ...], Guided]
"""Effects of a model, with its fit under the observer."""


def begin_effects(s: Searcher, solution: Solution, most: int | None = None) -> list[Solution]:
    """Begin single effects on top of a model, and continue the promising ones.

    Parameters
    ----------
    s
        Tools of the search.
    solution
        Model that the effects extend.
    most
        Number of best scores that are begun. Where None, all effects are begun on the nominal model, and
        `most_effects_begun_on_effect` on a model with effects; never more than ``study.most``. Where the residual
        is so small that it is linear in what is missing, none below `least_score_share_of_small_effects` of the
        best score.

    Returns
    -------
    list of Solution
        Preliminary fits at the coarse step, best first.
    """
    every = len(s.catalogue)
    most = most or (THRESHOLDS.search.most_effects_begun_on_effect if solution.effects else every)
    most = min(most, s.study.most or every)
    if most >= THRESHOLDS.search.most_effects_continued:
        s.extended.add(keys_of(solution))
    rough = s.side_by_side(s.study.factory.coarse)
    scored = s.beside(solution, s.scan(solution))
    most = min(most, _count_in_question(s, solution, scored))
    # Effects that are easily mistaken for the best one are tried whatever their score, lest a rival be missed.
    likely = s.rivals(scored[0].key) if scored else set()
    fresh = {score.key: score for k, score in enumerate(scored) if k < most or s.catalogue[score.key].id in likely}
    tried = [s.catalogue[key] for key in fresh]
    begun = s.map_all("effects, first fits", partial(begin, rough, solution), tried, fresh.values())
    begun = s.rank_fits(begun)
    named = s.rivals(begun[0].effects[-1].key) if begun else set()
    count = THRESHOLDS.search.most_effects_continued
    promising = begun[:count] + [fit for fit in begun[count:] if fit.effects[-1].id in named]
    scores = [fresh[fit.effects[-1].key] for fit in promising]
    done = s.map_all("the best effects", partial(continue_refit, rough, solution), promising, scores)
    s.simulations += (sum(fit.calls for fit in begun) + sum(calls for _, calls in done)) * len(s.study.fitted)
    return s.rank_fits(fit for fit, _ in done)


def _count_in_question(s: Searcher, solution: Solution, scored: Sequence[Score]) -> int:
    """Count the effects whose scores do not rule them out beside the best; all of them where much is missing."""
    if not scored or leaves_much(solution.chi2, s.study.rows):
        return len(scored)
    least = THRESHOLDS.search.least_score_share_of_small_effects * max(score.T for score in scored)
    return max(k + 1 for k, score in enumerate(scored) if least <= score.T)


def fit_from_first_guesses(s: Searcher, scored: Scan, onto: Solution) -> list[Solution]:
    """Fit single effects together with the nominal model through homotopy from the first guesses.

    Parameters
    ----------
    s
        Tools of the search.
    scored
        Scores of the catalogue on the residual of ``onto``.
    onto
        Model that the effects extend; its effects begin at their fitted parameters.

    Returns
    -------
    list of Solution
        Fits of the remaining effects, best first.

    Notes
    -----
    A nominal model that took a large effect upon itself may lie so far from the joint that no fit from there finds
    back, and no score there is informative. Under the observer, which holds the simulation near the readings,
    effects are compared early, and ever fewer continue:

    1. Fit all of them at the step `signature_step_s` under `sieve_gains` gains, shapes held by weak priors.
    2. Fit the best `most_effects_continued` of them at the coarse step under the next gains,
       `gains_until_distinguishable` in all.
    3. Release the observer for the best `most_effects_released` of them.

    Beside another effect, only the `most_effects_beside_effect` best scores are tried: while that effect is real,
    the missing one scores high.
    """
    s.extended.add(keys_of(onto))
    rough = s.side_by_side(s.study.factory.coarse)
    values = {q.id: q.initial for q in s.study.base.parameters}
    values |= {q.id: onto.values[q.id] for e in onto.effects for q in e.parameters}
    chosen: list[tuple[Effect, ...]] = []
    starts: list[dict[str, float]] = []
    most = THRESHOLDS.search.most_effects_beside_effect if onto.effects else s.study.most
    for score in s.beside(onto, scored)[:most]:
        effect = s.catalogue[score.key]
        own_starts = starts_of(effect, score)
        if score.key in s.resonances:
            own_starts.append(own_starts[0] | dict(s.resonances[score.key]))
        for own in own_starts:
            chosen.append((*onto.effects, effect))
            starts.append(values | own)
    sketch = partial(_sketch_fit, s.side_by_side(s.study.factory.sketch))
    begun = s.map_all("effects from first guesses", sketch, chosen, starts)
    few = best_first(begun)[: THRESHOLDS.search.most_effects_continued]
    sieved = s.map_all("the best from first guesses", partial(_sieve_fit, rough), few)
    fewer = best_first(sieved)[: THRESHOLDS.search.most_effects_released]
    calls = sum(low.reached.calls for _, low in (*begun, *sieved))
    s.simulations += calls * len(s.study.fitted)
    return release_fits(s, rough, fewer)


def release_fits(s: Searcher, rough: Study, tried: Sequence[Tried]) -> list[Solution]:
    """Release the observer for fits that it guided.

    Parameters
    ----------
    s
        Tools of the search.
    rough
        Study at the inner step of the fits, with one thread for each.
    tried
        Effects of models, each with its fit under the observer.

    Returns
    -------
    list of Solution
        Free fits, best first by `Searcher.rank`.
    """
    done = s.map_all("the best of them, released", partial(_release_fit, rough), tried)
    s.simulations += sum(calls for _, calls in done) * len(s.study.fitted)
    return s.rank_fits(solution for solution, _ in done)


def _sketch_fit(study: Study, effects: tuple[Effect, ...], values: Mapping[str, float]) -> Tried:
    """Fit briefly under the highest gains; a weak prior holds the shape of the last effect."""
    near = start_holding_last_shape(study, effects, values).down_to(
        THRESHOLDS.search.sieve_gains,
        THRESHOLDS.search.sieve_simulations_per_gain,
        THRESHOLDS.search.sieve_tolerance_chi2,
    )
    return effects, near


def _sieve_fit(study: Study, tried: Tried) -> Tried:
    """Continue at the inner step of ``study``, down to the gain at which effects are distinguishable."""
    effects, low = tried
    return effects, at_fine(study, effects, low).down_to(THRESHOLDS.search.gains_until_distinguishable)


def _release_fit(study: Study, tried: Tried) -> tuple[Solution, int]:
    """Release the observer and fit to the tolerance `rough_tolerance_chi2`."""
    return release_observer(study, *tried, THRESHOLDS.fit.rough_tolerance_chi2)


def best_first(found: Sequence[Tried]) -> list[Tried]:
    """Return the guided fit of least cost for every last effect, least cost first.

    Parameters
    ----------
    found
        Effects of models, each with its fit under the observer.

    Returns
    -------
    list of tuple
        One pair for every key of a last effect.
    """
    # Sorted by falling cost, the last fit of each effect that enters the dict is its cheapest.
    best = {both[-1].key: (both, low) for both, low in sorted(found, key=lambda pair: -pair[1].reached.cost)}
    return sorted(best.values(), key=lambda pair: pair[1].reached.cost)
