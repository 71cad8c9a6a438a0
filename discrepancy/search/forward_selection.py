"""Select effects forward: a search that has `Begun` in, judged trials and the best of them out.

1. Fit freely what was reached under the observer, where the search began there (`select_forward`).
2. Add one effect at a time until a model is adequate or no effect has earned its place. The cheaper ways come first.
3. Where single effects stay far from noise, try two at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from haptid.discrepancy.candidate.trial import Trial, chosen, keys_of
from haptid.discrepancy.detect.score_tests import Scan
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.backward_elimination import prune_stand_ins
from haptid.discrepancy.search.nominal_model import Begun
from haptid.discrepancy.search.trials.finishing import finish_best
from haptid.discrepancy.search.trials.judging import all_far, explains_all, judge_constancy
from haptid.discrepancy.search.trials.preliminary_fits import begin_effects, fit_from_first_guesses
from haptid.discrepancy.search.trials.searcher import Searcher, leaves_much
from haptid.discrepancy.search.two_effects import (
    add_second_effect,
    extend_by_best_scores,
    extend_from_first_guesses,
    leads_of,
)
from haptid.discrepancy.search.under_observer.dominance import Dominant, dominant
from haptid.discrepancy.search.under_observer.laws import Led
from haptid.discrepancy.search.under_observer.leads import begin_under_observer, release_leads
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.noise.correlation import Arma, Noise


def select_forward(begun: Begun) -> tuple[list[Trial], Trial, Dominant | None]:
    """Fit freely what was reached under the observer; add effects one by one where that explains too little.

    Parameters
    ----------
    begun
        Search that has scored the catalogue on its nominal model.

    Returns
    -------
    trials, best, standing
        All trials, the best of them and, where it leaves more than noise, the best with the declared rivals of its
        effects if no other effect comes near these; else None.
    """
    s, start, led = begun.searcher, begun.start, begun.led
    trials: list[Trial] = []
    if led is not None and led.leads and not start.adequate:
        released = release_leads(s, led.leads)
        trials = finish_best(s, start.candidate, released, freed=True)
        trials += prune_stand_ins(s, trials, start)
        if chosen(trials) is None:  # the model that they extend may have earned its effects
            most = max((len(fit.effects) for fit in released), default=0)
            trials += finish_best(s, start.candidate, [fit for fit in released if len(fit.effects) < most], freed=True)
        near = chosen(trials)
        if near is not None and not explains_all(trials) and not near.left.far:
            fits = begin_effects(s, near.solution, THRESHOLDS.search.most_effects_continued)
            further = finish_best(s, near.candidate, fits)
            trials = [*(_refute_score(s, t, further) if t is near else t for t in trials), *further]
        best = chosen(trials)
        explained = best is not None and explains_all(trials)
        if best is not None and explained and not (best is not near and _is_weak(best, s.study)):
            return trials, best, None
        if near is not None and (stands := dominant(s, led.at, near, start, best or near)) is not None:
            return [*trials, stands.trial, *stands.rivals], stands.trial, stands
        if explained or _is_hopeless(led) or s.is_over():
            return trials, best or start, None
    made, best = _add_one_by_one(begun)
    best = chosen([t for t in trials if t.adequate]) or best
    stands = _standing(begun, best, made)
    if stands is None:
        return [*trials, *made], best, None
    return [*trials, *made, stands.trial, *stands.rivals], stands.trial, stands


def _standing(begun: Begun, best: Trial, made: Sequence[Trial]) -> Dominant | None:
    """Return the effects that no other comes near, where they leave more than noise, or what held-out runs hardly show.

    The formula of a machine is only near that of the catalogue, and a further effect that is hardly seen mends it.
    """
    s, near = begun.searcher, best
    if best.adequate:
        fewer = {e.key for e in best.solution.effects[:-1]}
        extended = [t for t in made if {e.key for e in t.solution.effects} == fewer]
        if not (extended and fewer and _is_weak(best, s.study)):
            return None
        near = min(extended, key=lambda t: t.candidate.criterion)
    if not near.solution.effects:
        return None
    at = begin_under_observer(s, begun.white) if begun.led is None else begun.led.at
    return dominant(s, at, near, begun.start, best)


def _is_hopeless(led: Led) -> bool:
    """Say whether even under the observer the best effects leave far more than noise: a free search finds no better."""
    return all(lead.is_far(led.at.study.rows) for lead in led.leads)


def _is_weak(more: Trial, study: Study) -> bool:
    """Say whether held-out runs hardly show the last effect: it mends what the formulas of the others leave."""
    return bool(study.unseen) and more.held_out < THRESHOLDS.verdict.least_evidence_of_each_name


def _add_one_by_one(begun: Begun) -> tuple[list[Trial], Trial]:
    """Add effects until a model is adequate or no effect has earned its place; begin under white noise.

    A large discrepancy may be mistaken for correlated noise or for scatter. So the noise of every candidate is
    estimated from the residuals of that candidate.
    """
    s, start = begun.searcher, begun.start
    # White noise alone explains the nominal model. Where it needs scatter or correlation to be adequate, an effect may
    # still explain the same with less.
    if start.adequate and start.solution.noise == Noise():
        return [], start
    trials, leads = _first_step(s, start, begun.white, begun.first)
    winner = chosen(trials)
    best = winner if winner is not None and (not start.adequate or simpler(winner, start)) else start
    made, best = _extend_while_it_gains(s, start, best)
    trials += made
    if not any(t.adequate for t in (best, *trials)):
        far = leaves_much(begun.white.chi2, s.study.rows)
        made = add_second_effect(s, leads, start, extend_from_first_guesses if far else extend_by_best_scores)
        trials += made
        best = chosen([t for t in made if t.adequate]) or best
    if best is start:
        best = _refute_score(s, start, trials)
    return trials, best


def _extend_while_it_gains(s: Searcher, start: Trial, best: Trial) -> tuple[list[Trial], Trial]:
    """Add one effect after the other to the best model, while it is not adequate and each has earned its place."""
    trials: list[Trial] = []
    while (
        best is not start
        and not best.adequate
        and len(best.solution.effects) < THRESHOLDS.search.most_effects_at_once
        and beats(best, start)
    ):
        if s.is_over():
            break
        most = THRESHOLDS.search.most_finished_if_none_adequate
        if len(best.solution.effects) > 1:
            most = THRESHOLDS.search.most_finished_if_all_far
        made = finish_best(s, best.candidate, begin_effects(s, best.solution), most)
        made += prune_stand_ins(s, made, start)
        trials += made
        if (winner := chosen(made)) is None:
            best = _refute_score(s, best, made)
            break
        best, before = winner, best
        if not (best.adequate or gets_on(best, before)):
            break
    return trials, best


def _refute_score(s: Searcher, model: Trial, further: Sequence[Trial]) -> Trial:
    """Refute the score of an effect against a model where all effects were tried beside it in vain.

    It stands where it is very low. A score counts all rows as independent; what an encoder's steps leave is correlated
    with the motion, so that an effect scores that predicts nothing.
    """
    if any(t.acceptable for t in further):
        return model
    refuted = replace(model, refuted=True)
    return judge_constancy(s, refuted) if refuted.adequate and not model.adequate else refuted


def _first_step(s: Searcher, start: Trial, white: Solution, first: Scan) -> tuple[list[Trial], list[Solution]]:
    """Try single effects, and two at once where all single effects are far from noise.

    The cheaper ways come first: the best scores on top of the leading fits, then many effects from the first guesses on
    top of the best of them, then single effects from the first guesses.

    Returns
    -------
    trials, leads
        Trials, and the leading fits under white noise on which the catalogue was not tried from the first guesses.
    """
    few = start.adequate
    begun: list[Solution] = []
    trials: list[Trial] = []
    pairs: list[Trial] = []
    for fits in _ways(s, start, white):
        trials += finish_best(s, start.candidate, _best_and_rivals(s, fits) if few else fits)
        if few or explains_all(trials):
            return trials, []
        if fits and fits[0].noise == Noise():
            begun = s.best_of_each(begun, fits)
            if all_far(trials):
                pairs += add_second_effect(
                    s, leads_of(begun, THRESHOLDS.search.most_leading_fits), start, extend_by_best_scores
                )
            if explains_all(pairs):
                return trials + pairs, []
    if not leaves_much(
        white.chi2, s.study.rows
    ):  # the nominal model is near the joint: first guesses lead nowhere else
        return trials + pairs, leads_of(begun, THRESHOLDS.search.most_leading_fits)
    anew, leads = _from_first_guesses(s, start, white, first, begun, all_far=all_far(trials))
    return trials + pairs + anew, leads


def _ways(s: Searcher, start: Trial, white: Solution) -> Iterator[list[Solution]]:
    """Yield preliminary fits of single effects: under white noise, then under scatter alone.

    Fits under scatter are made only where the caller asks for them, and where the scatter of the nominal model explains
    most of its residual while no effect does: there the residual under white noise says nothing about the effects.
    """
    yield (fits := begin_effects(s, white, THRESHOLDS.search.most_effects_continued if start.adequate else None))
    noise = start.solution.noise.but(arma=Arma())
    most = THRESHOLDS.search.largest_chi2_share_left_by_scatter * white.chi2
    instead = start.solution.chi2 < most < min((fit.chi2 for fit in fits), default=np.inf)
    if noise.scatters and (not start.left.far or instead):
        s.tell("entries under scatter")
        yield begin_effects(s, solve(s.study, (), noise, start.solution.values, x0=start.solution.x0))


def _best_and_rivals(s: Searcher, fits: Sequence[Solution]) -> list[Solution]:
    """Return the best preliminary fit, and those of effects that are easily mistaken for its last effect."""
    alike = s.rivals(fits[0].effects[-1].key) if fits else set()
    return [fit for k, fit in enumerate(fits) if k == 0 or fit.effects[-1].id in alike]


def _from_first_guesses(
    s: Searcher, start: Trial, white: Solution, first: Scan, begun: Sequence[Solution], *, all_far: bool
) -> tuple[list[Trial], list[Solution]]:
    """Try a second effect, then single effects, from the first guesses; trials and leads as `_first_step` has them."""
    pairs = add_second_effect(s, leads_of(begun, 1), start, extend_from_first_guesses) if all_far else []
    if explains_all(pairs):
        return pairs, []
    s.tell("entries anew from the first guesses")
    fits = fit_from_first_guesses(s, first, white)
    trials = finish_best(s, start.candidate, fits)
    leads = leads_of(s.best_of_each(begun, fits), THRESHOLDS.search.most_leading_fits)
    leads = [lead for lead in leads if keys_of(lead) not in s.extended]
    if not explains_all(trials) and all_far and all(t.left.far for t in trials):
        return pairs + trials + add_second_effect(s, leads, start, extend_from_first_guesses), []
    return pairs + trials, leads


def beats(now: Trial, start: Trial) -> bool:
    """Say whether a trial beats the nominal model, whose noise may hold the whole discrepancy as scatter.

    Parameters
    ----------
    now
        Trial with effects.
    start
        Trial of the nominal model.

    Returns
    -------
    bool
        True if the criterion falls by more than `least_gain_in_criterion`.
    """
    return start.candidate.criterion - now.candidate.criterion > THRESHOLDS.candidate.least_gain_in_criterion


def gets_on(now: Trial, before: Trial) -> bool:
    """Say whether one effect more has removed so much of the residual that a further one may remove the rest.

    Parameters
    ----------
    now
        Trial with the last effect.
    before
        Trial without that effect.

    Returns
    -------
    bool
        True if the excess energy fell by more than the share `least_share_that_asks_for_more`, or the gain exceeds that
        share of the gain before.
    """
    left, was = (t.left.energy - t.left.dof for t in (now, before))
    share = THRESHOLDS.search.least_share_that_asks_for_more
    return left < (1.0 - share) * was or now.gain > share * before.gain


def simpler(winner: Trial, start: Trial) -> bool:
    """Say whether an adequate trial needs fewer noise terms than the nominal model, which took an effect for noise.

    Parameters
    ----------
    winner
        Trial with effects.
    start
        Trial of the nominal model.

    Returns
    -------
    bool
        False for a trial that is not adequate.
    """
    return winner.adequate and winner.solution.noise.terms < start.solution.noise.terms
