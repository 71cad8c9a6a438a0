"""A name against what has none: an effect of the same kind that is no entry of the catalogue, in its place.

A name that had nothing of its kind to beat is no finding: all that is late looks like the only late entry there is.
"""

from __future__ import annotations

from discrepancy.refit import FIRST
from discrepancy.solution import solve
from discrepancy.trial import Searcher, Trial
from model.effect import Effect


def contested(s: Searcher, best: Trial, start: Trial) -> list[Trial]:
    """Fit the best model with each effect's contenders in its place, where the catalogue holds no other of their kind.

    They begin at the best model's optimum.
    """
    if not best.adequate:
        return []
    made = []
    for effect in best.solution.effects:
        for contender in effect.contenders:
            if any(_of_its_kind(contender, effect, e) for e in s.entries.values()):
                continue
            free = [q for q in contender.parameters if not q.fixed]
            pairs = zip(free, (q for q in effect.parameters if not q.fixed), strict=True)
            values = dict(best.solution.values)
            values |= {other.id: min(max(values[own.id], other.lower), other.upper) for other, own in pairs}
            effects = [contender if e is effect else e for e in best.solution.effects]
            begun = solve(s.study, effects, best.solution.noise, values, x0=best.solution.x0, iterations=FIRST)
            s.simulations += begun.calls * len(s.study.fitted)
            made.append(s.finish(start.candidate, begun))
    return made


def _of_its_kind(contender: Effect, effect: Effect, other: Effect) -> bool:
    """Whether another entry has the same contender."""
    return effect.id != other.id and contender.id in {e.id for e in other.contenders}
