"""Keep the effects of a model that no other comes near: best `Trial` in, a `Trial` whose names stand out.

The formula of a machine's effect is hardly ever that of the catalogue. A model with the right kind of effect then
removes most of the discrepancy and still leaves more than noise. Its names stand where no other effect in their places
comes near.

1. Fit the model under the observer without each of its effects, and extend it by the best others.
2. Drop the effects in whose places another one leaves nearly as little, there and in free motion on held-out runs, and
   repeat. The observer pushes aside what acts slowly; free motion shows it.
3. Drop all effects that are smooth torques over position but the simplest, where there are several: together they
   follow any curve.
4. Refit what remains freely. It stands where it leaves a small share of the nominal model's excess.
5. Refit the declared rivals that leave nearly as little in the place of one of its effects (a one-sided spring in that
   of an end stop). The model of least criterion has the names, the others are told beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Dominant:
    """A model whose names stand out.

    Parameters
    ----------
    trial
        The model, fitted freely.
    rivals
        The model with a declared rival in the place of one of its effects, where that one leaves nearly as little.
    """

    trial: Trial
    rivals: tuple[Trial, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the effects that stand out."""
        return tuple(e.key for e in self.trial.solution.effects)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """The place of an effect in a model.

    Parameters
    ----------
    effect
        The effect that is there.
    stands
        Whether any other effect there leaves far more under the observer, its declared rivals apart.
    rivals
        Models with a declared rival there that does not leave far more, one for each id.
    """

    effect: Effect
    stands: bool
    rivals: tuple[Lead, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _FreeMotion:
    """Models compared by free simulations of held-out runs.

    Parameters
    ----------
    searcher
        Tools of the search.
    near
        Model whose effects are in question.
    start
        Nominal model.
    at_noise
        Model that leaves noise alone; None where there is none.
    known
        What was fitted freely, by the keys of its effects: the model that is weighed serves for all its places.
    """

    searcher: Searcher
    near: Trial
    start: Trial
    at_noise: Trial | None
    known: dict[tuple[str, ...], Trial] = field(default_factory=dict)

    def fit(self, effects: Sequence[Effect], values: Mapping[str, float]) -> Trial:
        """Fit a model freely, beside the noise of the model in question."""
        refitted = refit_with(self.searcher.study, self.near.solution, effects, values)
        return judge_candidate(self.searcher, refitted, self.start.candidate)

    def leaves_far_less(self, found: Trial, other: Trial) -> bool:
        """Say whether a model leaves far less of held-out runs than another."""
        left, its = (beyond_noise(self.searcher.study, t, self.at_noise) for t in (found, other))
        return left < THRESHOLDS.search.largest_excess_over_replacement * its

    def stands_out(self, full: Lead, others: Sequence[Lead]) -> bool:
        """Say whether a model leaves far less of held-out runs than each of the others, best first."""
        if not self.searcher.study.unseen:
            return False
        keys = tuple(e.key for e in full.effects)
        found = self.near if full.effects == self.near.solution.effects else self.known.get(keys)
        if found is None:
            found = self.known[keys] = self.fit(full.effects, full.fit.values)
        most = THRESHOLDS.search.most_replacements_in_free_motion
        return all(self.leaves_far_less(found, self.fit(o.effects, o.fit.values)) for o in others[:most])


def dominant(s: Searcher, at: UnderObserver, near: Trial, start: Trial, best: Trial) -> Dominant | None:
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
        Best model. Where it leaves noise alone, what it leaves is the noise, whatever is stated: under the observer,
        and of held-out runs.

    Returns
    -------
    Dominant or None
        The model, or the one without the effects that others could replace; None where none stands out, or where the
        model leaves too much of the discrepancy.
    """
    effects, values = near.solution.effects, near.solution.values
    noise = float(at.study.rows)
    if best.adequate:
        whole = fit_lead(s, at.study, best.solution.effects, best.solution.values, at.gains)
        noise = min(noise, whole.cost)
    at_noise = best if best.adequate else None
    # Fewer effects leave more: nothing is weighed where even all of them leave too much.
    if not effects or at.start.cost <= noise or not closes_most(s.study, near, start, at_noise):
        return None
    full = fit_lead(s, at.study, effects, values, at.gains)
    free = _FreeMotion(searcher=s, near=near, start=start, at_noise=at_noise)
    places: list[_Place] = []
    while full.effects:
        places = [_weigh_place(s, at, full, e, noise, free) for e in full.effects]
        kept = tuple(place.effect for place in places if place.stands)
        if kept == full.effects:
            break
        full = fit_lead(s, at.study, kept, full.fit.values, at.gains)
    full = _with_one_curve(s, at, full)
    if not full.effects:
        return None
    found = near
    if full.effects != effects:
        found = free.fit(full.effects, values)
    if not _may_stand(s.study, found, start, at_noise):
        return None
    rivals = [t for t in _fit_rivals(full, places, free) if not free.leaves_far_less(found, t)]
    able = [t for t in rivals if _may_stand(s.study, t, start, at_noise)]
    winner = min((found, *able), key=lambda t: t.candidate.criterion)
    return Dominant(trial=winner, rivals=tuple(t for t in (found, *rivals) if t is not winner))


def _may_stand(study: Study, found: Trial, start: Trial, at_noise: Trial | None) -> bool:
    """Say whether held-out runs show the effects of a model, and it leaves a small share of the discrepancy."""
    shown = found.held_out >= THRESHOLDS.verdict.least_evidence_of_each_name
    return shown and not found.at_bound and closes_most(study, found, start, at_noise)


def _fit_rivals(full: Lead, places: Sequence[_Place], free: _FreeMotion) -> list[Trial]:
    """Fit freely what leaves nearly as little as ``full`` with a declared rival in the place of one of its effects."""
    trials = []
    for place in places:
        if place.effect not in full.effects:
            continue
        for lead in place.rivals:
            rival = lead.effects[-1]
            effects = tuple(rival if e is place.effect else e for e in full.effects)
            trials.append(free.fit(effects, lead.fit.values))
    return trials


def _with_one_curve(s: Searcher, at: UnderObserver, full: Lead) -> Lead:
    """Keep the smooth torque over position of fewest parameters, where there are several."""
    curves = smooth_curves(at.study, full.effects, full.fit.values)
    if len(curves) < 2:
        return full
    simplest = min(curves, key=lambda e: len(e.parameters))
    kept = tuple(e for e in full.effects if e is simplest or e not in curves)
    return fit_lead(s, at.study, kept, full.fit.values, at.gains)


def _weigh_place(s: Searcher, at: UnderObserver, full: Lead, effect: Effect, noise: float, free: _FreeMotion) -> _Place:
    """Compare what an effect leaves beyond the noise with what others leave in its place."""
    others = tuple(e for e in full.effects if e is not effect)
    rest = fit_lead(s, at.study, others, full.fit.values, at.gains)
    declared = s.rivals(effect.key)

    def leaves_far_more(lead: Lead) -> bool:
        return full.cost - noise < THRESHOLDS.search.largest_excess_over_replacement * (lead.cost - noise)

    unlike, rivals = [rest], dict[str, Lead]()
    for lead in extend_lead(s, at, rest):
        last = lead.effects[-1]
        if last.id in declared:
            if not leaves_far_more(lead):
                rivals.setdefault(last.id, lead)
        elif last.id != effect.id:
            unlike.append(lead)
    nearby = [lead for lead in unlike if not leaves_far_more(lead)]
    stands = not nearby or free.stands_out(full, nearby)
    return _Place(effect=effect, stands=stands, rivals=tuple(rivals.values()))


def closes_most(study: Study, found: Trial, start: Trial, at_noise: Trial | None = None) -> bool:
    """Say whether a model leaves a small share of what the nominal model leaves of held-out runs.

    Parameters
    ----------
    study
        Study of both.
    found
        Trial with effects.
    start
        Nominal model.
    at_noise
        Model that leaves noise alone; None where there is none.

    Returns
    -------
    bool
        By the mean squares of measured − simulated beyond the sensor's noise, or beyond what ``at_noise`` leaves where
        that is more: a stated noise may be a fifth too small. False where every run was fitted.
    """
    most = THRESHOLDS.search.largest_share_left_by_names * beyond_noise(study, start, at_noise)
    return beyond_noise(study, found, at_noise) < most


def beyond_noise(study: Study, found: Trial, at_noise: Trial | None = None) -> float:
    """Return the mean squares of measured − simulated beyond noise, summed over held-out runs.

    Parameters
    ----------
    study
        Study of the model.
    found
        Model.
    at_noise
        Model that leaves noise alone; None where there is none.

    Returns
    -------
    float
        Σ max(rms² − noise², 0) in the square of the reading's unit; 0 where every run was fitted.
    """
    noise = [float(np.mean(np.square(run.sensor_std))) for run in study.unseen]
    if at_noise is not None:
        noise = [max(own, rms**2) for own, rms in zip(noise, at_noise.candidate.prediction.rms, strict=True)]
    return sum(max(rms**2 - own, 0.0) for rms, own in zip(found.candidate.prediction.rms, noise, strict=True))
