"""Search for missing effects, step by step: `Study` in, `Search` out.

1. Merge rows of a long recording as long as no reading shows it. Fit the nominal model from several starts, and choose
   the inner step whose error is invisible there.
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

from collections.abc import Sequence
from dataclasses import replace

from haptid.discrepancy.candidate.candidate import score_candidate
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.merged_error import merging_shows
from haptid.discrepancy.fit.nominal_fit import NominalFit
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.backward_elimination import exchange_effects, without_each
from haptid.discrepancy.search.contenders import fit_contenders
from haptid.discrepancy.search.forward_selection import select_forward
from haptid.discrepancy.search.friction_laws import OtherLaw, law_from, law_that_leaves_less, other_laws
from haptid.discrepancy.search.nominal_model import Begun, begin_search, fit_nominal_model
from haptid.discrepancy.search.own_range import in_wider_range
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.search.step_refinement import Refined, refine_step
from haptid.discrepancy.search.trials.finishing import finish_best
from haptid.discrepancy.search.trials.judging import explains_all, first_tests
from haptid.discrepancy.search.trials.preliminary_fits import begin_effects
from haptid.discrepancy.search.trials.searcher import Searcher, leaves_much
from haptid.discrepancy.search.under_observer.dominance import closes_most
from haptid.discrepancy.search.under_observer.laws import RivalLaw, lead_on
from haptid.discrepancy.search.under_observer.leads import Lead, begin_under_observer, release_leads
from haptid.discrepancy.study.merged_rows import merged, rows_to_merge
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.friction.registry import MISSING
from haptid.support.listener import Progress, ignore_progress


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
    every = rows_to_merge(study)
    while every > 1:
        few, base = fit_nominal_model(merged(study, every), seed=seed, starts=starts, tell=tell)
        if not merging_shows(study, few, base.solution):
            found = _search_beside(few, base, tell)
            if not merging_shows(study, found.study, found.best.solution):
                return found
        tell(f"again with fewer rows merged than {every}: it shows in the readings")
        every //= 2
    study, base = fit_nominal_model(study, seed=seed, starts=starts, tell=tell)
    return _search_beside(study, base, tell)


def _search_beside(study: Study, base: NominalFit, tell: Progress) -> Search:
    """Search beside a fit of the nominal model, under the friction law that explains most."""
    begun = begin_search(study, base, tell)
    if not begun.start.adequate and leaves_much(begun.white.chi2, study.rows):
        return _search_under_observer(begun, tell)
    others = other_laws(study, begun.start, begun.white, tell) if study.alone and not begun.start.adequate else ()
    if not others:
        return _finish(begun, tell)
    if others[0].simpler or others[0].leaves_less_than(_least_of_singles(begun)):
        return _instead(others[0], begun, tell)
    found = _finish(begun, tell)
    if found.best.adequate:
        return found
    again = _instead(others[0], begun, tell)
    better = again.best.adequate or again.best.candidate.criterion < found.best.candidate.criterion
    return _with_cost_of(found, again) if better else _with_cost_of(again, found)


def _search_under_observer(begun: Begun, tell: Progress) -> Search:
    """Search where the nominal model is far from noise: first under the observer, then freely from what it led to."""
    s, released = begun.searcher, list[Solution]()

    def is_enough(lead: Lead) -> bool:
        """Say whether one effect leaves noise and scatter alone: under the observer, scatter looks like effects."""
        fits = release_leads(s, [lead])
        released.extend(fits)
        return explains_all(finish_best(s, begun.start.candidate, fits, freed=True))

    scattered = bool(begun.start.solution.noise.scatters)
    led = lead_on(s, begin_under_observer(s, begun.white), begun.white, is_enough, scattered=scattered)
    if led.rival is not None and (other := _explains_more(led.rival, released, begun)) is not None:
        return _instead(other, begun, tell)
    if led.law is None:
        return _finish(replace(begun, led=led), tell)
    tell(f"search under the friction law {led.law}")
    other = law_from(begun.study, begun.start, begun.white, led.law, led.nominal)
    if not led.leads and (alone := _law_alone(other, begun)) is not None:
        tell(f"nothing comes near the friction law {led.law}")
        return alone
    again = replace(begin_search(other.study, other.base, tell, other.fits), led=led)
    again.searcher.simulations += s.simulations
    return _finish_instead(other, again, begun, tell)


def _explains_more(rival: RivalLaw, released: Sequence[Solution], begun: Begun) -> OtherLaw | None:
    """Fit a law that came near noise under the observer in free motion; None where effects leave less there."""
    least = min((fit.chi2 for fit in released), default=begun.white.chi2)
    return law_that_leaves_less(begun.study, begun.start, begun.white, rival.law, rival.values, least)


def _law_alone(other: OtherLaw, begun: Begun) -> Search | None:
    """End with a friction law that removes most of the discrepancy, beside which no effect removes a share of the rest.

    None where the law leaves noise alone, so that the catalogue has to be scored beside it, or leaves too much.
    """
    start = first_tests(other.study, score_candidate(other.study, other.own, other.own.calls))
    if start.passes or not closes_most(other.study, start, begun.start):
        return None
    simulations = begun.searcher.simulations + other.base.calls * len(other.study.fitted)
    return _with_law_alone(other, start, begun, simulations)


def _with_law_alone(other: OtherLaw, start: Trial, asked: Begun, simulations: int) -> Search:
    # A scatter that the law has beside it is judged by the law without it.
    less = without_each(replace(asked.searcher, study=other.study), start, start)
    return Search(
        study=other.study, base=other.base, plain=start, scan=asked.first, trials=(), best=start, less=less,
        standing=(MISSING,), simulations=simulations, asked=asked.start,
    )  # fmt: skip


def _least_of_singles(begun: Begun) -> float:
    """Return the least ‖r‖² that a single effect leaves beside the law of the study, under white noise."""
    singles = begin_effects(begun.searcher, begun.white)
    return min((one.chi2 for one in singles), default=begun.white.chi2)


def _instead(other: OtherLaw, asked: Begun, tell: Progress) -> Search:
    """Search under another friction law, and keep the nominal model under the law that was asked for."""
    tell(f"search under the friction law {other.study.base.friction[0]}")
    return _finish_instead(other, begin_search(other.study, other.base, tell, other.fits), asked, tell)


def _finish_instead(other: OtherLaw, begun: Begun, asked: Begun, tell: Progress) -> Search:
    """Search beside another friction law, but for the little that is left where a law is only near the machine's."""
    highest = max((score.T for score in begun.first.scores), default=0.0)
    little = THRESHOLDS.search.least_share_of_all_under_observer * (asked.white.chi2 - asked.study.rows)
    alone = begun.start.passes and not begun.start.adequate and highest < little
    # A scatter beside the law may pass for noise what held-out runs show to be none.
    if alone and closes_most(other.study, begun.start, asked.start):
        return _with_law_alone(other, begun.start, asked, begun.searcher.simulations)
    return replace(_finish(begun, tell), asked=asked.start)


def _finish(begun: Begun, tell: Progress) -> Search:
    """Search beside the friction law of a study, to the contenders."""
    base = begun.base
    found, s = _search_from(begun)
    if found.best.solution.effects and (better := _refit_nominal(found)) is not None:
        tell("the nominal fit was stuck: again from the better minimum")
        base = replace(base, solution=better)
        again, s = _search_from(begin_search(begun.study, base, tell), known=found)
        found = _with_cost_of(found, again)
    if (finer := refine_step(s, found.best, found.trials)) is not None:
        # Where the finer step overturns the outcome, candidates that were dropped at the old step may win, so all are
        # tried again.
        if finer.best is None or finer.best.adequate < found.best.adequate:
            again, s = _search_from(begin_search(finer.searcher.study, base, tell))
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


def _search_from(begun: Begun, known: Search | None = None) -> tuple[Search, Searcher]:
    """Search from one minimum of the nominal model; keep the ``known`` result where it still gains."""
    study, s, start = begun.study, begun.searcher, begun.start
    if (
        known is not None
        and not start.adequate
        and known.best.candidate.criterion < start.candidate.criterion - THRESHOLDS.candidate.least_gain_in_criterion
    ):
        trials, best, standing, rivals = known.trials, known.best, known.standing, known.standing_rivals
        less = known.less if len(known.less) > 1 else dict.fromkeys(known.less, start.candidate)
    else:
        made, best, stands = select_forward(begun)
        standing, rivals = (), ()
        if stands is not None:
            standing, rivals = stands.keys, stands.rivals
            less, trials = without_each(s, best, start), tuple(made)
        else:
            best, less, more = exchange_effects(s, best, start)
            trials = (*made, *more)
    result = Search(
        study=study, base=begun.base, plain=start, scan=begun.first, trials=trials, best=best, less=less,
        simulations=s.simulations, cut=s.cut, standing=standing, standing_rivals=rivals,
    )  # fmt: skip
    return result, s


def _with_cost_of(earlier: Search, found: Search) -> Search:
    return replace(found, simulations=earlier.simulations + found.simulations, cut=earlier.cut or found.cut)


def _at_finer_step(found: Search, finer: Refined, best: Trial) -> Search:
    """Take over the refined trials; nominal model and distant trials are as good at the old step."""
    fitted = {t.solution.keys for t in finer.trials}
    others = [t for t in found.trials if t.solution.keys not in fitted]
    same = best.solution.keys == found.best.solution.keys
    less = found.less if same else without_each(finer.searcher, best, found.plain)
    return replace(
        found, study=finer.searcher.study, trials=(*finer.trials, *others), best=best, less=less,
        simulations=finer.searcher.simulations,
    )  # fmt: skip


def _refit_nominal(found: Search) -> Solution | None:
    """Refit the nominal model from the winner's optimum; return the refit where it is better, else None."""
    winner, plain = found.best.solution, found.plain.solution
    again = solve(found.study, (), plain.noise, winner.values, x0=winner.x0)
    likelier = plain.log_likelihood + THRESHOLDS.search.least_deviance_drop_of_stuck_fit / 2
    return again if again.log_likelihood > likelier else None
