"""Compare friction laws under the observer: `Study` and its leads in, the law with its leads out.

Another friction law is judged as an effect is: by what it leaves under the observer, alone and beside the effects that
were chosen under the law of the study. A law that leaves far less takes the place of the law of the study.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.search.friction_laws import starts_under_law
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.search.under_observer.leads import (
    Lead,
    UnderObserver,
    at_step_under_observer,
    extend_lead,
    fit_lead,
    follow_leads,
    signatures_about,
)
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.study.under_law import under_law
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.friction.registry import laws

MOST = THRESHOLDS.search.simulations_of_a_start_under_other_law
"""Largest number of simulations of all runs under each gain, for a law that is only compared."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RivalLaw:
    """A friction law that leaves about as little under the observer as an effect does.

    Parameters
    ----------
    law
        Its id.
    values
        Parameters of the nominal model under it, fitted under the observer, by id.
    """

    law: str
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Led:
    """Where the search under the observer leads.

    Parameters
    ----------
    law
        Id of the friction law; None for the law of the study.
    at
        Nominal model under that law and signatures, under the observer.
    leads
        Models whose observer is worth to be released, best first; none where only the law is missing.
    rival
        Another law that comes near noise by itself where an effect comes near it too and is not enough in free motion;
        None where none does.
    """

    law: str | None
    at: UnderObserver
    leads: tuple[Lead, ...]
    rival: RivalLaw | None = None

    @property
    def nominal(self) -> Mapping[str, float]:
        """Parameters of the nominal model under that law, by id."""
        return self.at.start.fit.values

    def explains_more_than(self, other: Led, rows: int) -> bool:
        """Say whether a model leaves less than the best one of another law with fewer effects, or far less.

        Parameters
        ----------
        other
            Where the search leads under the other law, with at least one model.
        rows
            Number of scored residuals.

        Returns
        -------
        bool
            False where no effect is left beside this law.
        """
        its = other.leads[0]

        def beats(lead: Lead) -> bool:
            fewer = len(lead.effects) < len(its.effects)
            most = 1.0 if fewer else THRESHOLDS.search.largest_excess_beside_effects
            return lead.excess(rows) < most * its.excess(rows)

        return any(beats(lead) for lead in self.leads)


def lead_on(
    s: Searcher,
    at: UnderObserver,
    white: Solution,
    is_enough: Callable[[Lead], bool] = lambda _: False,
    *,
    scattered: bool = False,
) -> Led:
    """Choose effects under the observer, and the friction law beside which they are chosen.

    Parameters
    ----------
    s
        Tools of the search.
    at
        Nominal model and signatures under the observer.
    white
        Fit of the nominal model, from which other laws take their first guesses.
    is_enough
        As `follow_leads` asks it, under the law of the study.
    scattered
        Whether a scatter of the amplitudes explains a part of what the nominal model leaves. Under the observer it
        looks like effects, so that no effect is followed that takes less than half.

    Returns
    -------
    Led
        With the law of the study where no other one leaves far less.

    Notes
    -----
    1. Fit the best single effect and, where it leaves more than noise under the observer or released, the nominal model
       under every other law: what another law makes, an effect may follow from row to row, and miss the free motion.
    2. Where a law leaves far less than that effect, go on under it. Otherwise take the effect, and where it leaves more
       than noise, fit it beside every other law. Choose further effects where none leaves far less.
    3. Where these leave more than noise, fit all of them beside every other law. Go on under the
       one that leaves less than the law of the study beside the same effects by more than a further effect has to take.
    4. Where both a law and an effect that is not enough come near noise under the observer, free motion has to tell
       them apart: return the law as a rival.
    5. Where a law beside the first effect takes more than the second effect does, choose further effects under it too,
       and keep it where it leaves less with fewer effects, or far less.
    """
    rows = at.study.rows
    if not at.study.alone:
        return Led(law=None, at=at, leads=_worth_releasing(follow_leads(s, at, at.start, None, is_enough)))
    extended = extend_lead(s, at, at.start)
    single = min([at.start, *extended], key=lambda found: found.cost)
    if not single.is_far(rows) and (single is at.start or is_enough(single)):
        return Led(law=None, at=at, leads=_worth_releasing(follow_leads(s, at, at.start, extended, is_enough)))
    others = [_under(s, at, white, law) for law in laws() if law != at.study.base.friction[0]]
    best = min(others, key=lambda other: other.at.start.cost)
    if _leaves_far_less(best.at.start, single, rows):
        return best.led(best.at.start)
    if scattered and single.excess(rows) > THRESHOLDS.search.largest_excess_beside_scatter * at.excess:
        return Led(law=None, at=at, leads=())
    led = _effects_first(s, at, extended, others, is_enough)
    near = led.law is None and not single.is_far(rows) and not best.at.start.is_far(rows)
    return replace(led, rival=RivalLaw(law=best.law, values=best.at.start.fit.values)) if near else led


def _effects_first(
    s: Searcher,
    at: UnderObserver,
    extended: Sequence[Lead],
    others: Sequence[_OtherLaw],
    is_enough: Callable[[Lead], bool],
) -> Led:
    """Choose effects under the law of the study; compare the other laws beside the first, and beside all of them."""
    rows, beside_first, beside_all = at.study.rows, list[_Beside](), list[_Beside]()

    def ends(first: Lead) -> bool:
        """Say whether the first effect is enough, or whether the friction is to be changed before the next."""
        if is_enough(first):
            return True
        beside_first.extend(_under_each(others, first))
        return any(_leaves_far_less(law.fit, first, rows) for law in beside_first)

    rounds = follow_leads(s, at, at.start, extended, ends)
    own = Led(law=None, at=at, leads=_worth_releasing(rounds))
    if len(rounds) > 1 and rounds[-1][0].is_far(rows):
        beside_all.extend(_under_each(others, rounds[-1][0]))
    best = min([*beside_first, *beside_all], key=lambda law: law.fit.cost, default=None)
    if best is not None and best.leaves_less_than(rounds[-1][0], rows):
        return best.other.led(best.fit)
    first = min(beside_first, key=lambda law: law.fit.cost, default=None)
    # A law that leaves less than the only effect was followed above, so that there is a second one here.
    if first is not None and first.leaves_less_than(first.known, rows) and first.fit.cost < rounds[1][0].cost:
        instead = first.other.led(first.fit)
        return instead if instead.explains_more_than(own, rows) else own
    return own


def _leaves_far_less(now: Lead, before: Lead, rows: int) -> bool:
    return now.excess(rows) < THRESHOLDS.search.largest_excess_over_best_effect * before.excess(rows)


def _worth_releasing(rounds: Sequence[Sequence[Lead]]) -> tuple[Lead, ...]:
    """Return the models of the last round, and the one that it extends."""
    return (*rounds[-1], *(found[0] for found in rounds[-2:-1])) if rounds else ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _OtherLaw:
    """Another friction law under the observer.

    Parameters
    ----------
    law
        Its id.
    searcher
        Tools of the search under it.
    at
        Its nominal model, with the signatures of the effects that can act in it.
    """

    law: str
    searcher: Searcher
    at: UnderObserver

    def beside(self, known: Lead) -> Lead | None:
        """Fit the law beside the effects of a model; None where it lacks what an effect asks for."""
        if any(e.key not in self.searcher.catalogue for e in known.effects):
            return None
        own = {q.id: known.fit.values[q.id] for e in known.effects for q in e.parameters}
        values = self.at.start.fit.values | own
        return fit_lead(self.searcher, self.at.study, known.effects, values, self.at.gains, MOST)

    def led(self, start: Lead) -> Led:
        """Choose further effects under this law where more than noise is left; what they extend is released too.

        They are scored by signatures under this law, at the inner step that it needs. Of an effect that inertia,
        gravity and spring take upon themselves but for a hundredth, as of a cubic spring, those of another law say
        nothing, nor those of a step that is too long where dry friction turns its sign.
        """
        s, at, rounds = self.searcher, self.at, [[start]]
        if start.is_far(at.study.rows):
            study = at_step_under_observer(at)
            nominal = fit_lead(s, study, (), at.start.fit.values, at.gains)
            at = replace(at, study=study, start=nominal, found=signatures_about(s, study, nominal))
            start = fit_lead(s, study, start.effects, start.fit.values, at.gains) if start.effects else nominal
            rounds = [[start], *follow_leads(s, at, start)]
        leads = tuple(found for found in _worth_releasing(rounds) if found.effects)
        return Led(law=self.law, at=at, leads=leads)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Beside:
    """Another friction law beside effects that were chosen under the law of the study.

    Parameters
    ----------
    other
        The law.
    known, fit
        The model with these effects under the law of the study, and under the other.
    """

    other: _OtherLaw
    known: Lead
    fit: Lead

    def leaves_less_than(self, last: Lead, rows: int) -> bool:
        """Say whether the law takes more of the same effects' excess, and of the last model's, than an effect would."""
        most = THRESHOLDS.search.largest_excess_beside_effects
        return self.fit.excess(rows) < most * min(self.known.excess(rows), last.excess(rows))


def _under_each(others: Sequence[_OtherLaw], known: Lead) -> list[_Beside]:
    """Fit the effects of a model beside every other law that can bear them."""
    fits = [(other, other.beside(known)) for other in others]
    return [_Beside(other=other, known=known, fit=fit) for other, fit in fits if fit is not None]


def _best_start(s: Searcher, at: UnderObserver, study: Study, white: Solution) -> Lead:
    """Fit the nominal model under another law from each of its starts, until one leaves next to nothing.

    Its own guesses come first: a stiffness in presliding that was bent to another law's needs holds the law in another
    minimum.
    """
    little = THRESHOLDS.search.least_share_of_all_under_observer * at.excess
    begun = list[Lead]()
    for values in reversed([*starts_under_law(study, white)]):
        begun.append(fit_lead(s, study, (), values, at.gains, MOST))
        if begun[-1].excess(study.rows) <= little:
            break
    return min(begun, key=lambda lead: lead.cost)


def _under(s: Searcher, at: UnderObserver, white: Solution, law: str) -> _OtherLaw:
    """Fit the nominal model under another law; the signatures of the law of the study serve until it is chosen."""
    s.tell(f"friction law {law} under the observer")
    study = under_law(at.study, law, white.values)
    catalogue = {key: effect for key, effect in s.catalogue.items() if key in study.catalogue}
    searcher = replace(s, study=study, catalogue=catalogue, simulations=0, finished={}, extended=set())
    start = _best_start(searcher, at, study, white)
    s.simulations += searcher.simulations
    points = tuple(point for point in at.found.points if point.key in catalogue)
    there = replace(at, study=study, start=start, found=replace(at.found, points=points))
    return _OtherLaw(law=law, searcher=searcher, at=there)
