"""Search for missing effects by forward selection: `Study` in, `Search` out.

1. Fit the nominal model from several starts, and choose the inner step whose error is invisible there.
2. Estimate the noise from its residuals, simulate the signatures of the catalogue, and score them. Where the nominal
   model lacks something, fit it under the other friction laws too: one that leaves far less than any single effect
   takes the place of the model's law, one that leaves less is searched under where the search ends without an
   adequate model.
3. Add one effect at a time until a model is adequate or no effect has earned its place; where single effects stay far
   from noise, try two at once.
4. Leave out or exchange each effect once (backward elimination).
5. Refit the nominal model from the winner's optimum. A better minimum shows that the first fit was stuck, and starts
   the search again.
6. Compare the best models at the inner step that they need, and search again there if that changes the outcome. Widen
   the range of the stiffness in presliding where the best model ends on it.
7. Fit unlisted effects of the same kind in the place of the named ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.candidate.candidate import Trial, chosen, keys_of
from haptid.discrepancy.candidate.refit import score_candidate, settle, sharpen_jumps
from haptid.discrepancy.detect.inner_step import at_needed_step, step_for
from haptid.discrepancy.detect.score_tests import Scan, scan
from haptid.discrepancy.detect.signatures import Signatures, signatures
from haptid.discrepancy.fit.nominal_fit import Base, at_own_step, fit_base, with_stiffer_presliding
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.backward_elimination import exchange_effects, prune_stand_ins, without_each
from haptid.discrepancy.search.contenders import fit_contenders
from haptid.discrepancy.search.dominance import closes_most, dominant
from haptid.discrepancy.search.friction_laws import OtherLaw, law_from, other_laws
from haptid.discrepancy.search.observer_laws import Led, lead_on
from haptid.discrepancy.search.observer_search import Lead, begin_under_observer, release_leads
from haptid.discrepancy.search.own_range import in_wider_range
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.search.step_refinement import Closer, closer
from haptid.discrepancy.search.tools import Searcher, first_tests, leaves_much
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect
from haptid.model.friction.registry import MISSING
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.noise.correlation import Colour, Noise
from haptid.support.listener import Progress, ignore_progress

Way = Callable[[Searcher, Solution], list[Trial]]
"""How a second effect is searched for on top of a fit with one effect."""


def search(study: Study, *, seed: int = 0, starts: int = 8, tell: Progress = ignore_progress) -> Search:
    """Search for the effects that the nominal model of ``study`` lacks.

    Parameters
    ----------
    study
        Study of one joint, or of several that move together.
    seed
        Seed of the starts.
    starts
        Number of starts of the nominal fit.
    tell
        Told of each step.

    Returns
    -------
    Search
        Best model, all trials and the scores of the catalogue.

    Raises
    ------
    NumericalError
        If no start of the nominal fit gives a finite simulation.
    """
    study, base = fit_nominal_model(study, seed=seed, starts=starts, tell=tell)
    begun = _begin(study, base, tell)
    if not begun.start.adequate and leaves_much(begun.white.chi2, study.rows):
        return _search_under_observer(begun, tell)
    others = other_laws(study, begun.start, begun.white, tell) if study.alone and not begun.start.adequate else ()
    if not others:
        return _finish(begun, tell)
    if others[0].simpler or others[0].leaves_less_than(_least_of_singles(begun)):
        return _instead(others[0], begun.start, tell)
    found = _finish(begun, tell)
    if found.best.adequate:
        return found
    again = _instead(others[0], begun.start, tell)
    better = again.best.adequate or again.best.candidate.criterion < found.best.candidate.criterion
    return _with_cost_of(found, again) if better else _with_cost_of(again, found)


def _search_under_observer(begun: _Begun, tell: Progress) -> Search:
    """Search where the nominal model is far from noise: first under the observer, then freely from what it led to."""
    s = begun.searcher

    def is_enough(lead: Lead) -> bool:
        """Say whether one effect leaves noise and scatter alone: under the observer, scatter looks like effects."""
        return explains_all(s.step(begun.start.candidate, release_leads(s, [lead]), freed=True))

    scattered = bool(begun.start.solution.noise.scatters)
    led = lead_on(s, begin_under_observer(s, begun.white), begun.white, is_enough, scattered=scattered)
    if led.law is None:
        return _finish(replace(begun, led=led), tell)
    tell(f"search under the friction law {led.law}")
    other = law_from(begun.study, begun.start, begun.white, led.law, led.nominal)
    fits = under_own_noise(other.study, other.base)
    if not led.leads and (alone := _law_alone(other, fits[1], begun)) is not None:
        tell(f"nothing comes near the friction law {led.law}")
        return alone
    again = replace(_begin(other.study, other.base, tell, fits), led=led)
    again.searcher.simulations += s.simulations
    return replace(_finish(again, tell), asked=begun.start)


def _law_alone(other: OtherLaw, plain: Solution, begun: _Begun) -> Search | None:
    """End with a friction law that closes most of the gap, beside which no effect takes a share of what it leaves.

    None where the law leaves noise alone, so that the catalogue has to be scored beside it, or too much of the gap.
    """
    start = first_tests(other.study, score_candidate(other.study, plain, plain.calls))
    if start.passes or not closes_most(other.study, start, begun.start):
        return None
    calls = other.base.calls + plain.calls
    # A scatter that the law has beside it is judged by the law without it.
    less = without_each(replace(begun.searcher, study=other.study), start, start)
    return Search(
        study=other.study, base=other.base, plain=start, scan=begun.first, trials=(), best=start, less=less,
        standing=(MISSING,), simulations=begun.searcher.simulations + calls * len(other.study.fitted),
        asked=begun.start,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class _Begun:
    """A search that has scored the catalogue on its nominal model.

    Parameters
    ----------
    study, base
        Study and fit of the nominal model.
    white
        Nominal model under white noise.
    start
        Nominal model under its own noise, judged.
    searcher
        Tools of the search.
    first
        Scores of the catalogue at the nominal model.
    led
        Where a search under the observer led; None without one.
    """

    study: Study
    base: Base
    white: Solution
    start: Trial
    searcher: Searcher
    first: Scan
    led: Led | None = None


def _begin(study: Study, base: Base, tell: Progress, fits: tuple[Solution, Solution] | None = None) -> _Begun:
    """Score the catalogue on the nominal model, and judge the model, fitted before or now as `under_own_noise` does."""
    white, plain = fits or under_own_noise(study, base)
    entries, found, first = score_catalogue(study, plain, tell)
    s = Searcher(study, entries, found, first.tests, tell, base.calls * len(study.fitted) + found.simulations)
    tell("tests of the nominal model")
    nominal = score_candidate(study, plain, plain.calls)
    s.nominal_excess = nominal.prediction.excess
    start = s.on_its_path(s.trial(nominal))
    return _Begun(study=study, base=base, white=white, start=start, searcher=s, first=first)


def _least_of_singles(begun: _Begun) -> float:
    """Return the least ‖r‖² that a single effect leaves beside the law of the study, under white noise."""
    singles = begun.searcher.ready(begun.white)
    return min((one.chi2 for one in singles), default=begun.white.chi2)


def _instead(other: OtherLaw, asked: Trial, tell: Progress) -> Search:
    """Search under another friction law, and keep the nominal model under the law that was asked for."""
    tell(f"search under the friction law {other.study.base.friction[0]}")
    return replace(_finish(_begin(other.study, other.base, tell), tell), asked=asked)


def _finish(begun: _Begun, tell: Progress) -> Search:
    """Search beside the friction law of a study, to the contenders."""
    base = begun.base
    found, s = _search_from(begun)
    if found.best.solution.effects and (better := _refit_nominal(found)) is not None:
        tell("the base fit was stuck: again from the better minimum")
        base = replace(base, solution=better)
        again, s = _search_from(_begin(begun.study, base, tell), known=found)
        found = _with_cost_of(found, again)
    if (finer := closer(s, found.best, found.trials)) is not None:
        # Where the finer step overturns the outcome, candidates that were dropped at the old step may win, so all are
        # tried again.
        if finer.best is None or finer.best.adequate < found.best.adequate:
            again, s = _search_from(_begin(finer.searcher.study, base, tell))
        else:
            again, s = _at_finer_step(found, finer, finer.best), finer.searcher
        found = _with_cost_of(found, again)
    if (wider := in_wider_range(s, found.best)) is not None:
        tell("the best model with stiffer presliding")
        found, s = _at_finer_step(found, wider, wider.trials[0]), wider.searcher
    before = s.simulations
    contenders = fit_contenders(s, found.best, found.plain)
    simulations = found.simulations + s.simulations - before
    return replace(found, contenders=tuple(contenders), simulations=simulations)


def fit_nominal_model(study: Study, *, seed: int, starts: int, tell: Progress) -> tuple[Study, Base]:
    """Fit the nominal model and choose the inner step.

    Parameters
    ----------
    study
        Study at any inner step.
    seed
        Seed of the starts.
    starts
        Number of starts.
    tell
        Told of each step.

    Returns
    -------
    study, base
        Study at the inner step whose error is invisible at the nominal model, and the fit.
    """
    tell("base fit")
    if study.carried is not None and study.carried.inner_step < MODEL.inner_step_s:
        study = at_needed_step(study, study.carried.inner_step)
    base = fit_base(study, starts=starts, seed=seed, tell=tell)
    step = step_for(study, base.solution, share=THRESHOLDS.detect.step_error_share_of_excess)
    fine = at_needed_step(study, step)
    if fine.factory.share < study.factory.share:
        base = at_own_step(fine, base)
    return with_stiffer_presliding(fine, base)


def under_own_noise(study: Study, base: Base) -> tuple[Solution, Solution]:
    """Fit the nominal model under white noise, and under the noise estimated from its residuals.

    Parameters
    ----------
    study
        Study with the fitted runs.
    base
        Fit of the nominal model.

    Returns
    -------
    white, own
        Solutions under white noise and under the estimated noise.
    """
    white = solve(study, (), Noise(), base.solution.values, x0=base.solution.x0)
    return white, settle(study, (), white).solution


def score_catalogue(study: Study, plain: Solution, tell: Progress) -> tuple[dict[str, Effect], Signatures, Scan]:
    """Simulate and score the signatures of the catalogue.

    Parameters
    ----------
    study
        Study with the fitted runs.
    plain
        Nominal model under its own noise.
    tell
        Told of each step.

    Returns
    -------
    entries, found, scan
        Catalogue effects in SI units by key, their signatures at the nominal model, and their scores.
    """
    entries = study.in_si(plain.values)
    effects = list(entries.values())

    def count(done: int) -> None:
        tell("signatures of the catalogue", done, len(effects))

    found = signatures(study, plain, effects, count)
    tell("scores of the catalogue", figures=f"{len(found.points)} signatures")
    first = scan(study, plain, found, entries)
    return entries, found, first


def _search_from(begun: _Begun, known: Search | None = None) -> tuple[Search, Searcher]:
    """Search from one minimum of the nominal model; keep the ``known`` result where it still gains."""
    study, s, start = begun.study, begun.searcher, begun.start
    if (
        known is not None
        and not start.adequate
        and known.best.candidate.criterion < start.candidate.criterion - THRESHOLDS.candidate.least_gain_in_criterion
    ):
        trials, best, standing = known.trials, known.best, known.standing
        less = known.less if len(known.less) > 1 else dict.fromkeys(known.less, start.candidate)
    else:
        made, best, standing = _forward_from_leads(s, start, begun)
        if standing:
            less, trials = without_each(s, best, start), tuple(made)
        else:
            best, less, more = exchange_effects(s, best, start)
            trials = (*made, *more)
    result = Search(
        study=study, base=begun.base, plain=start, scan=begun.first, trials=trials, best=best, less=less,
        simulations=s.simulations, cut=s.cut, standing=standing,
    )  # fmt: skip
    return result, s


def _with_cost_of(earlier: Search, found: Search) -> Search:
    return replace(found, simulations=earlier.simulations + found.simulations, cut=earlier.cut or found.cut)


def _at_finer_step(found: Search, finer: Closer, best: Trial) -> Search:
    """Take over the refined trials; nominal model and distant trials are as good at the old step."""
    fitted = {t.solution.keys for t in finer.trials}
    others = [t for t in found.trials if t.solution.keys not in fitted]
    same = best.solution.keys == found.best.solution.keys
    less = found.less if same else without_each(finer.searcher, best, found.plain)
    return replace(
        found, study=finer.searcher.study, trials=(*finer.trials, *others), best=best, less=less,
        simulations=finer.searcher.simulations,
    )  # fmt: skip


def _forward_from_leads(s: Searcher, start: Trial, begun: _Begun) -> tuple[list[Trial], Trial, tuple[str, ...]]:
    """Fit freely what was reached under the observer; add effects one by one where that explains too little.

    Returns
    -------
    trials, best, standing
        All trials, the best of them and, where it leaves more than noise, the keys of its effects if no other effect
        comes near them.
    """
    led, trials = begun.led, list[Trial]()
    if led is not None and led.leads and not start.adequate:
        released = release_leads(s, led.leads)
        trials = s.step(start.candidate, released, freed=True)
        trials += prune_stand_ins(s, trials, start)
        if chosen(trials) is None:  # the model that they extend may have earned its effects
            most = max((len(fit.effects) for fit in released), default=0)
            trials += s.step(start.candidate, [fit for fit in released if len(fit.effects) < most], freed=True)
        near = chosen(trials)
        if near is not None and not explains_all(trials) and not near.left.far:
            further = s.step(near.candidate, s.ready(near.solution, THRESHOLDS.search.most_effects_continued))
            trials = [*(_refute_score(s, t, further) if t is near else t for t in trials), *further]
        best = chosen(trials)
        explained = best is not None and explains_all(trials)
        if best is not None and explained and not (best is not near and _is_weak(best, s.study)):
            return trials, best, ()
        if near is not None and (stands := dominant(s, led.at, near, start, best or near)) is not None:
            return [*trials, stands], stands, tuple(e.key for e in stands.solution.effects)
        if explained or _is_hopeless(led):
            return trials, best or start, ()
    made, best = _forward(s, start, begun)
    best = chosen([t for t in trials if t.adequate]) or best
    stands = _standing(s, best, made, begun)
    if stands is None:
        return [*trials, *made], best, ()
    return [*trials, *made, stands], stands, tuple(e.key for e in stands.solution.effects)


def _standing(s: Searcher, best: Trial, made: Sequence[Trial], begun: _Begun) -> Trial | None:
    """Return the effects that no other comes near, where they leave more than noise, or what held-out runs hardly show.

    The formula of a machine is only near that of the catalogue, and a further effect that is hardly seen mends it.
    """
    near = best
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


def _forward(s: Searcher, start: Trial, begun: _Begun) -> tuple[list[Trial], Trial]:
    """Add effects until a model is adequate or no effect has earned its place; begin under white noise.

    A large discrepancy may be mistaken for correlated noise or for scatter. So the noise of every candidate is
    estimated from the residuals of that candidate.
    """
    # White noise alone explains the nominal model. Where it needs scatter or correlation to be adequate, an effect may
    # still explain the same with less.
    if start.adequate and start.solution.noise == Noise():
        return [], start
    trials, leads = _first_step(s, start, begun.white, begun.first)
    winner = chosen(trials)
    best = winner if winner is not None and (not start.adequate or simpler(winner, start)) else start
    while (
        best is not start
        and not best.adequate
        and len(best.solution.effects) < THRESHOLDS.search.most_effects_at_once
        and beats(best, start)
    ):
        if s.is_over():
            break
        made = s.step(
            best.candidate,
            s.ready(best.solution),
            THRESHOLDS.search.most_finished_if_all_far
            if len(best.solution.effects) > 1
            else THRESHOLDS.search.most_finished_if_none_adequate,
        )
        made += prune_stand_ins(s, made, start)
        trials += made
        if (winner := chosen(made)) is None:
            best = _refute_score(s, best, made)
            break
        best, before = winner, best
        if not (best.adequate or gets_on(best, before)):
            break
    if not any(t.adequate for t in (best, *trials)):
        made = _two_at_once(s, leads, start, _anew if leaves_much(begun.white.chi2, s.study.rows) else _clear)
        trials += made
        best = chosen([t for t in made if t.adequate]) or best
    if best is start:
        best = _refute_score(s, start, trials)
    return trials, best


def _refute_score(s: Searcher, model: Trial, further: Sequence[Trial]) -> Trial:
    """Refute the score of an effect against a model where all effects were tried beside it in vain.

    It stands where it is very low. A score counts all rows as independent; what an encoder's steps leave is correlated
    with the motion, so that an effect scores that predicts nothing.
    """
    if any(t.acceptable for t in further):
        return model
    refuted = replace(model, refuted=True)
    return s.with_constancy(refuted) if refuted.adequate and not model.adequate else refuted


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
        trials += s.step(start.candidate, _best_and_rivals(s, fits) if few else fits)
        if few or explains_all(trials):
            return trials, []
        if fits and fits[0].noise == Noise():
            begun = s.best_of_each(begun, fits)
            if all_far(trials):
                pairs += _two_at_once(s, leads_of(begun, THRESHOLDS.search.most_leading_fits), start, _clear)
            if explains_all(pairs):
                return trials + pairs, []
    if not leaves_much(
        white.chi2, s.study.rows
    ):  # the nominal model is near the joint: first guesses lead nowhere else
        return trials + pairs, leads_of(begun, THRESHOLDS.search.most_leading_fits)
    anew, leads = _from_first_guesses(s, start, white, first, begun, all_far=all_far(trials))
    return trials + pairs + anew, leads


def _best_and_rivals(s: Searcher, fits: Sequence[Solution]) -> list[Solution]:
    """Return the best preliminary fit, and those of effects that are easily mistaken for its last effect."""
    alike = s.rivals(fits[0].effects[-1].key) if fits else set()
    return [fit for k, fit in enumerate(fits) if k == 0 or fit.effects[-1].id in alike]


def _from_first_guesses(
    s: Searcher, start: Trial, white: Solution, first: Scan, begun: Sequence[Solution], *, all_far: bool
) -> tuple[list[Trial], list[Solution]]:
    """Try a second effect, then single effects, from the first guesses; trials and leads as `_first_step` has them."""
    pairs = _two_at_once(s, leads_of(begun, 1), start, _anew) if all_far else []
    if explains_all(pairs):
        return pairs, []
    s.tell("entries anew from the first guesses")
    fits = s.anew(first, white)
    trials = s.step(start.candidate, fits)
    leads = leads_of(s.best_of_each(begun, fits), THRESHOLDS.search.most_leading_fits)
    leads = [lead for lead in leads if keys_of(lead) not in s.extended]
    if not explains_all(trials) and all_far and all(t.left.far for t in trials):
        return pairs + trials + _two_at_once(s, leads, start, _anew), []
    return pairs + trials, leads


def explains_all(trials: Sequence[Trial]) -> bool:
    """Say whether a trial is both adequate and acceptable.

    Parameters
    ----------
    trials
        Judged candidates.

    Returns
    -------
    bool
        False without trials.
    """
    return any(t.adequate and t.acceptable for t in trials)


def all_far(trials: Sequence[Trial]) -> bool:
    """Say whether there are trials, and all of them are far from noise.

    Parameters
    ----------
    trials
        Judged candidates.

    Returns
    -------
    bool
        False without trials.
    """
    return bool(trials) and all(t.left.far for t in trials)


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


def _two_at_once(s: Searcher, leads: Sequence[Solution], start: Trial, way: Way) -> list[Trial]:
    """Extend leading fits under white noise by a second effect, although the first alone leaves a discrepancy.

    The discrepancy of a missing second effect may pass for noise of any kind and size, under which the first gains
    nothing. So the noise is judged beside both effects. A discontinuity that is still rounded would hide the second
    effect. Where the first effect is unnecessary beside the second, it was a surrogate.
    """
    made: list[Trial] = []
    for lead in leads:
        if s.is_over():
            break
        rounded = solve(s.study, lead.effects, Noise(), lead.values, x0=lead.x0)
        first, calls = sharpen_jumps(s.study, rounded, rounded.calls, THRESHOLDS.search.least_rounding_of_discontinuity)
        s.simulations += calls * len(s.study.fitted)
        both = way(s, first)
        made += [*both, *prune_stand_ins(s, both, start)]
        if explains_all(made):
            break
    return made


def _clear(s: Searcher, first: Solution) -> list[Trial]:
    """Try the best scores on top of one effect as it was fitted: beside a real effect the missing ones score best."""
    s.tell(f"{'+'.join(first.keys)} and what scores best beside it")
    return s.step(
        score_candidate(s.study, first, first.calls),
        s.ready(first, THRESHOLDS.search.most_scores_on_leading_fit),
        THRESHOLDS.search.most_finished_if_all_far,
    )


def _anew(s: Searcher, first: Solution) -> list[Trial]:
    """Try many effects from the first guesses: the nominal model may have taken the second effect upon itself."""
    s.tell(f"{'+'.join(first.keys)} and another")
    return s.step(
        score_candidate(s.study, first, first.calls),
        s.anew(s.scan(first), first),
        THRESHOLDS.search.most_finished_if_all_far,
        freed=True,
    )


def _ways(s: Searcher, start: Trial, white: Solution) -> Iterator[list[Solution]]:
    """Yield preliminary fits of single effects: under white noise, then under scatter alone.

    Fits under scatter are made only where the caller asks for them, and where the scatter of the nominal model explains
    most of its residual while no effect does: there the residual under white noise says nothing about the effects.
    """
    yield (fits := s.ready(white, THRESHOLDS.search.most_effects_continued if start.adequate else None))
    noise = start.solution.noise.but(colour=Colour())
    most = THRESHOLDS.search.largest_chi2_share_left_by_scatter * white.chi2
    instead = start.solution.chi2 < most < min((fit.chi2 for fit in fits), default=np.inf)
    if noise.scatters and (not start.left.far or instead):
        s.tell("entries under scatter")
        yield s.ready(solve(s.study, (), noise, start.solution.values, x0=start.solution.x0))


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


def _refit_nominal(found: Search) -> Solution | None:
    """Refit the nominal model from the winner's optimum; return the refit where it is better, else None."""
    winner, plain = found.best.solution, found.plain.solution
    again = solve(found.study, (), plain.noise, winner.values, x0=winner.x0)
    likelier = plain.log_likelihood + THRESHOLDS.search.least_deviance_drop_of_stuck_fit / 2
    return again if again.log_likelihood > likelier else None
