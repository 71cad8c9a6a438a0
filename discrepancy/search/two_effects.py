"""Try two effects at once: leading fits of one effect in, judged trials with a second one out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from haptid.discrepancy.candidate.candidate import score_candidate
from haptid.discrepancy.candidate.refit import sharpen_discontinuities
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.backward_elimination import prune_stand_ins
from haptid.discrepancy.search.trials.finishing import finish_best
from haptid.discrepancy.search.trials.judging import explains_all
from haptid.discrepancy.search.trials.preliminary_fits import begin_effects, fit_from_first_guesses
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.noise.correlation import Noise

Way = Callable[[Searcher, Solution], list[Trial]]
"""How a second effect is searched for on top of a fit with one effect."""


def add_second_effect(s: Searcher, leads: Sequence[Solution], start: Trial, way: Way) -> list[Trial]:
    """Extend leading fits under white noise by a second effect, although the first alone leaves a discrepancy.

    The discrepancy of a missing second effect may pass for noise of any kind and size, under which the first gains
    nothing. So the noise is judged beside both effects. A discontinuity that is still rounded would hide the second
    effect. Where the first effect is unnecessary beside the second, it was a surrogate.

    Parameters
    ----------
    s
        Tools of the search.
    leads
        Leading fits under white noise, each with one effect.
    start
        Nominal model, judged.
    way
        How the second effect is searched for.

    Returns
    -------
    list of Trial
        Judged trials; no further lead is extended once they explain all, or the effort is spent.
    """
    made: list[Trial] = []
    for lead in leads:
        if s.is_over():
            break
        rounded = solve(s.study, lead.effects, Noise(), lead.values, x0=lead.x0)
        first, calls = sharpen_discontinuities(
            s.study, rounded, rounded.calls, THRESHOLDS.search.least_rounding_of_discontinuity
        )
        s.simulations += calls * len(s.study.fitted)
        both = way(s, first)
        made += [*both, *prune_stand_ins(s, both, start)]
        if explains_all(made):
            break
    return made


def extend_by_best_scores(s: Searcher, first: Solution) -> list[Trial]:
    """Try the best scores on top of one effect as it was fitted: beside a real effect the missing ones score best.

    Parameters
    ----------
    s
        Tools of the search.
    first
        Fit with one effect.

    Returns
    -------
    list of Trial
    """
    s.tell(f"{'+'.join(first.keys)} and what scores best beside it")
    current = score_candidate(s.study, first, first.calls)
    fits = begin_effects(s, first, THRESHOLDS.search.most_scores_on_leading_fit)
    return finish_best(s, current, fits, THRESHOLDS.search.most_finished_if_all_far)


def extend_from_first_guesses(s: Searcher, first: Solution) -> list[Trial]:
    """Try many effects from the first guesses: the nominal model may have taken the second effect upon itself.

    Parameters
    ----------
    s
        Tools of the search.
    first
        Fit with one effect.

    Returns
    -------
    list of Trial
    """
    s.tell(f"{'+'.join(first.keys)} and another")
    current = score_candidate(s.study, first, first.calls)
    fits = fit_from_first_guesses(s, s.scan(first), first)
    return finish_best(s, current, fits, THRESHOLDS.search.most_finished_if_all_far, freed=True)


def leads_of(begun: Sequence[Solution], most: int) -> list[Solution]:
    """Return the leading fits, the best of every last effect in whatever variant.

    Parameters
    ----------
    begun
        Preliminary fits, best first.
    most
        Largest number of fits.

    Returns
    -------
    list of Solution
        Leading fits, best first.
    """
    # Reversed, the best fit of each id enters the dict last and stays.
    first_of = {lead.effects[-1].id: lead for lead in reversed(begun)}
    return [lead for lead in begun if lead is first_of[lead.effects[-1].id]][:most]
