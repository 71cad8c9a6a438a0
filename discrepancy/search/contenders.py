"""A name against what has none: an effect of the same kind that is no entry of the catalogue, in its place.

A name that had nothing of its kind to beat is no finding: all that is late looks like the only late entry there is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from haptid.discrepancy.candidate.candidate import Trial
from haptid.discrepancy.candidate.refit import FIRST, likeliest
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.tools import Searcher
from haptid.discrepancy.study.study import Study
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Noise

Place = tuple[Mapping[str, float], Sequence[Array]]
"""Parameters and initial states at which a fit begins."""


def fit_contenders(s: Searcher, best: Trial, start: Trial) -> list[Trial]:
    """Fit the best model with each effect's contenders in its place, where the catalogue holds no other of their kind.

    They begin at the best model's optimum, or at the base with nothing of them. The other effects of the model may make
    up for what the named one lacks and its contender has; so a contender is fitted without each of them too.
    """
    if not best.adequate:
        return []
    made = []
    for effect, contender in _iterate_contenders(s, best.solution.effects):
        free = [q for q in contender.parameters if not q.fixed]
        pairs = zip(free, (q for q in effect.parameters if not q.fixed), strict=True)
        values = best.solution.values
        values |= {other.id: values[own.id] for other, own in pairs}
        places = ((values, best.solution.x0), (values | start.solution.values | contender.neutral, start.solution.x0))
        others = [e for e in best.solution.effects if e is not effect]
        for left in (others, *([e for e in others if e is not other] for other in others)):
            begun = s.each(partial(_start_contender, [*left, contender], best.solution.noise), places)
            s.simulations += sum(b.calls for b in begun) * len(s.study.fitted)
            made.append(s.finish(start.candidate, likeliest(*begun)))
    return made


def _start_contender(effects: Sequence[Effect], noise: Noise, study: Study, place: Place) -> Solution:
    values, x0 = place
    return solve(study, effects, noise, values, x0=x0, iterations=FIRST)


def _iterate_contenders(s: Searcher, effects: Sequence[Effect]) -> Iterator[tuple[Effect, Effect]]:
    """Yield effects with each of their contenders that no other entry of the catalogue has."""
    for effect in effects:
        theirs = {c.id for e in s.entries.values() if e.id != effect.id for c in e.contenders}
        yield from ((effect, contender) for contender in effect.contenders if contender.id not in theirs)
