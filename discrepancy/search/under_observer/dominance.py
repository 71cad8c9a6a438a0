"""Keep the effects of a model that no other comes near: best `Trial` in, a `Trial` whose names stand out.

The formula of a machine's effect is hardly ever that of the catalogue. A model with the right kind of effect then
closes most of the gap and still leaves more than noise. Its names stand where no other effect in their places comes
near.

1. Fit the model under the observer without each of its effects, and extend it by the best others.
2. Drop the effects in whose places another one leaves nearly as little, and repeat.
3. Drop all effects that are smooth torques over position but the simplest, where there are several: together they
   follow any curve.
4. Refit what remains freely. It stands where it leaves a small share of the nominal model's excess.
"""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.candidate.refit import refit_with
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.search.under_observer.leads import Lead, UnderObserver, extend_lead, fit_lead
from haptid.discrepancy.search.under_observer.smooth_curves import smooth_curves
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect


def dominant(s: Searcher, at: UnderObserver, near: Trial, start: Trial, best: Trial) -> Trial | None:
    """Return the model with those effects that no other comes near.

    Parameters
    ----------
    s
        Tools of the search.
    at
        Study and signatures under the observer.
    near
        Model whose effects are in question; it leaves more than noise.
    start
        Nominal model.
    best
        Best model. Where it leaves noise alone, what it leaves under the observer is the noise, whatever is stated.

    Returns
    -------
    Trial or None
        The model, or the one without the effects that others could replace; None where none stands out, or where the
        model leaves too much of the gap.
    """
    effects, values = near.solution.effects, near.solution.values
    noise = float(at.study.rows)
    if best.adequate:
        whole = fit_lead(s, at.study, best.solution.effects, best.solution.values, at.gains)
        noise = min(noise, whole.cost)
    if not effects or at.start.cost <= noise:
        return None
    full = fit_lead(s, at.study, effects, values, at.gains)
    while full.effects:
        kept = tuple(e for e in full.effects if _stands_out(s, at, full, e, noise))
        if kept == full.effects:
            break
        full = fit_lead(s, at.study, kept, full.fit.values, at.gains)
    full = _with_one_curve(s, at, full)
    if not full.effects:
        return None
    found = near
    if full.effects != effects:
        found = judge_candidate(s, refit_with(s.study, near.solution, full.effects, values), start.candidate)
    shown = found.held_out >= THRESHOLDS.verdict.least_evidence_of_each_name
    return found if shown and not found.at_bound and closes_most(s.study, found, start) else None


def _with_one_curve(s: Searcher, at: UnderObserver, full: Lead) -> Lead:
    """Keep the smooth torque over position of fewest parameters, where there are several."""
    curves = smooth_curves(at.study, full.effects, full.fit.values)
    if len(curves) < 2:
        return full
    simplest = min(curves, key=lambda e: len(e.parameters))
    kept = tuple(e for e in full.effects if e is simplest or e not in curves)
    return fit_lead(s, at.study, kept, full.fit.values, at.gains)


def _stands_out(s: Searcher, at: UnderObserver, full: Lead, effect: Effect, noise: float) -> bool:
    """Say whether any other effect in the place of this one leaves far more under the observer, beyond the noise."""
    others = tuple(e for e in full.effects if e is not effect)
    rest = fit_lead(s, at.study, others, full.fit.values, at.gains)
    alike = {effect.id, *s.rivals(effect.key)}
    replaced = [lead for lead in extend_lead(s, at, rest) if lead.effects[-1].id not in alike]
    next_best = min(lead.cost - noise for lead in (rest, *replaced))
    return full.cost - noise < THRESHOLDS.search.largest_excess_over_replacement * next_best


def closes_most(study: Study, found: Trial, start: Trial) -> bool:
    """Say whether a model leaves a small share of what the nominal model leaves of held-out runs.

    Parameters
    ----------
    study
        Study of both.
    found
        Trial with effects.
    start
        Nominal model.

    Returns
    -------
    bool
        By the mean squares of measured − simulated beyond the sensor's noise. False where every run was fitted.
    """
    noise = [float(np.mean(np.square(run.sensor_std))) for run in study.unseen]

    def beyond(trial: Trial) -> float:
        return sum(max(rms**2 - own, 0.0) for rms, own in zip(trial.candidate.prediction.rms, noise, strict=True))

    return beyond(found) < THRESHOLDS.search.largest_share_left_by_names * beyond(start)
