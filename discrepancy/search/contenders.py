"""Fit unlisted effects of the same kind in the place of named ones: best `Trial` in, contender `Trial`s out.

A name is no finding without an alternative of its kind that it has beaten: any delay resembles the only delay that the
catalogue holds. So each effect brings contenders, effects of its kind that are no catalogue effects.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from haptid.discrepancy.candidate.refit import fit_briefly, likeliest
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.trials.finishing import finish
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.study.study import Study
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Noise

Place = tuple[Mapping[str, float], Sequence[Array]]
"""Parameters and initial states at which a fit begins."""


def fit_contenders(s: Searcher, best: Trial, start: Trial) -> list[Trial]:
    """Fit the best model with each effect's contenders in its place.

    Parameters
    ----------
    s
        Tools of the search.
    best
        Best trial; nothing is fitted where it is not adequate.
    start
        Nominal model.

    Returns
    -------
    list of Trial
        Trials with a contender, where the catalogue holds no other effect with that contender.
    """
    if not best.adequate:
        return []
    made = []
    for effect, contender in _iterate_contenders(s, best.solution.effects):
        free = [q for q in contender.parameters if not q.fixed]
        pairs = zip(free, (q for q in effect.parameters if not q.fixed), strict=True)
        values = best.solution.values
        values |= {other.id: values[own.id] for other, own in pairs}
        # Two starts: the optimum of the best model, and the nominal model with the contender at its neutral values.
        places = ((values, best.solution.x0), (values | start.solution.values | contender.neutral, start.solution.x0))
        others = [e for e in best.solution.effects if e is not effect]
        # The other effects may make up for a flaw of the named effect that its contender does not have. So the
        # contender is fitted without each of them too.
        for left in (others, *([e for e in others if e is not other] for other in others)):
            begun = s.each(partial(_start_contender, [*left, contender], best.solution.noise), places)
            s.simulations += sum(b.calls for b in begun) * len(s.study.fitted)
            made.append(finish(s, start.candidate, likeliest(*begun)))
    return made


def _start_contender(effects: Sequence[Effect], noise: Noise, study: Study, place: Place) -> Solution:
    values, x0 = place
    return fit_briefly(study, effects, noise, values, x0)


def _iterate_contenders(s: Searcher, effects: Sequence[Effect]) -> Iterator[tuple[Effect, Effect]]:
    """Yield effects with those of their contenders that no other catalogue effect has."""
    for effect in effects:
        theirs = {c.id for e in s.catalogue.values() if e.id != effect.id for c in e.contenders}
        yield from ((effect, contender) for contender in effect.contenders if contender.id not in theirs)
