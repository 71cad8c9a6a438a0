"""Each effect of a model taken out once: left out, or exchanged, where the others do as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from haptid.discrepancy.candidate.candidate import BETTER, Trial, chosen, keys_of
from haptid.discrepancy.candidate.refit import Candidate, refit_with, score_candidate
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.tools import MOST, PROMISING, Searcher
from haptid.discrepancy.study.study import Study
from haptid.model.effects.effect import Effect


def exchange_effects(s: Searcher, best: Trial, start: Trial) -> tuple[Trial, dict[str, Candidate], list[Trial]]:
    """Leave every effect out where the others do as well, exchange it where another does better.

    Where as many effects as there may be still leave more than noise, they follow the gap as terms of a series do, and
    none is exchanged; nor is one beside effects on top of which the catalogue has been tried. Beside an effect that is
    real, what is missing scores first: few are tried.

    Returns
    -------
    best, less, trials
        The model that is left, that model without each of its effects by key, and what was tried.
    """
    made: list[Trial] = []
    less = without_each(s, best, start)
    for key in best.solution.random:
        if not best.solution.effects or key not in less:
            continue
        smaller = s.trial(less[key], start.candidate)
        made.append(smaller)
        if smaller.adequate and _costs(smaller, best) < BETTER:
            best = smaller
            less = without_each(s, best, start)
    for key in [e.key for e in best.solution.effects[:-1]]:
        if len(less) < 2 or key not in less:
            break
        smaller = s.trial(less[key], start.candidate)
        made.append(smaller)
        better = smaller if smaller.adequate and _costs(smaller, best) < BETTER else None
        hopeless = best.left.far or (len(best.solution.effects) >= MOST and not best.adequate)
        tried_before = keys_of(smaller.solution) in s.extended
        if better is None and not (smaller.adequate or hopeless or tried_before or (not best.adequate and s.spent())):
            tried = s.step(smaller.candidate, s.ready(smaller.solution, PROMISING))
            made += tried
            winner = chosen(tried)
            better = winner if winner is not None and _improves(winner, best) else None
        if better is not None:
            best = better
            less = without_each(s, best, start)
    return best, less, made


def prune_stand_ins(s: Searcher, made: Sequence[Trial], start: Trial) -> list[Trial]:
    """Take a stand-in out of a model that leaves only noise, where it has come to nothing beside the other effects.

    It was the best of the single entries before the one that it stood in for was found. A Wald statistic may say so
    wrongly (a bent spring that weight and stiffness follow a long way): where a fit without the effect tells that it is
    needed, the model is returned with what leaving it out costs. Where one less is not enough, two stand-ins are out.
    """
    full = [t for t in made if t.adequate and not t.acceptable and len(t.solution.effects) > 1]
    best = min(full, key=lambda t: t.candidate.criterion, default=None)
    if best is None:
        return []
    tried = [s.trial(less, start.candidate) for less in _less(s, best.solution).values()]
    needed = replace(best, worth=min(_costs(t, best) for t in tried))
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
    """Whether ``winner`` leaves less: only noise where the other leaves more, or else a better criterion."""
    if winner.adequate != best.adequate:
        return winner.adequate
    return _costs(winner, best) < 0.0


def without_each(s: Searcher, best: Trial, start: Trial) -> dict[str, Candidate]:
    """Refit the best model without each of its effects, the random ones among them."""
    full = best.solution
    if len(full.keys) == 1 and full.effects:
        return {full.keys[0]: start.candidate}
    found = _less(s, full)
    for key, scatter in zip(full.random, full.noise.scatters, strict=True):
        noise = full.noise.but(scatters=tuple(other for other in full.noise.scatters if other is not scatter))
        bare = solve(s.study, full.effects, noise, full.values, x0=full.x0)
        found[key] = score_candidate(s.study, bare, bare.calls)
    return found
