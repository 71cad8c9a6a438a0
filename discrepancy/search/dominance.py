"""Keep the effects of a model that no other comes near: best `Trial` in, a `Trial` whose names stand out.

The formula of a machine's effect is hardly ever that of the catalogue. A model with the right kind of effect then
closes most of the gap and still leaves more than noise. Its names stand where no other effect in their places comes
near.

1. Fit the model under the observer without each of its effects, and extend it by the best others.
2. Drop the effects in whose places another one leaves nearly as little, and repeat.
3. Refit what remains freely. It stands where it leaves a small share of the nominal model's excess.
"""

from __future__ import annotations

from haptid.discrepancy.candidate.candidate import Trial
from haptid.discrepancy.candidate.refit import refit_with
from haptid.discrepancy.search.observer_search import Lead, UnderObserver, extend_lead, fit_lead
from haptid.discrepancy.search.tools import Searcher
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect


def dominant(s: Searcher, at: UnderObserver, best: Trial, start: Trial) -> Trial | None:
    """Return the model with those effects that no other comes near.

    Parameters
    ----------
    s
        Tools of the search.
    at
        Study and signatures under the observer.
    best
        Best model, which leaves more than noise.
    start
        Nominal model.

    Returns
    -------
    Trial or None
        The model, or the one without the effects that others could replace; None where none stands out, or where the
        model leaves too much of the gap.
    """
    effects, values = best.solution.effects, best.solution.values
    if not effects or at.start.excess(at.study.rows) <= 0.0:
        return None
    full = fit_lead(s, at.study, effects, values, at.gains)
    while full.effects:
        kept = tuple(e for e in full.effects if _stands_out(s, at, full, e))
        if kept == full.effects:
            break
        full = fit_lead(s, at.study, kept, full.fit.values, at.gains)
    if not full.effects:
        return None
    found = best
    if full.effects != effects:
        found = s.trial(refit_with(s.study, best.solution, full.effects, values), start.candidate)
    return found if found.held_out >= 0.0 and not found.at_bound and closes_most(found, start) else None


def _stands_out(s: Searcher, at: UnderObserver, full: Lead, effect: Effect) -> bool:
    """Say whether any other effect in the place of this one leaves far more under the observer."""
    rows = at.study.rows
    others = tuple(e for e in full.effects if e is not effect)
    rest = fit_lead(s, at.study, others, full.fit.values, at.gains)
    alike = {effect.id, *s.rivals(effect.key)}
    replaced = [lead for lead in extend_lead(s, at, rest) if lead.effects[-1].id not in alike]
    next_best = min(lead.excess(rows) for lead in (rest, *replaced))
    return full.excess(rows) <= THRESHOLDS.search.largest_excess_over_replacement * next_best


def closes_most(found: Trial, start: Trial) -> bool:
    """Say whether a model leaves a small share of what the nominal model leaves of held-out runs.

    Parameters
    ----------
    found
        Trial with effects.
    start
        Nominal model.

    Returns
    -------
    bool
        By the mean squares of measured − simulated, noise included. False where every run was fitted.
    """
    left, before = (sum(rms**2 for rms in t.candidate.prediction.rms) for t in (found, start))
    return left < THRESHOLDS.search.largest_share_left_by_names * before
