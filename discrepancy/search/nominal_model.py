"""Begin a search: fit the nominal model, and score the catalogue on its residual: `Study` in, `Begun` out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from haptid.discrepancy.candidate.candidate import score_candidate
from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.inner_step import at_needed_step, step_for
from haptid.discrepancy.detect.rigid_residual import residual_over_position
from haptid.discrepancy.detect.score_tests import Scan, scan
from haptid.discrepancy.detect.signatures import Signatures, scored_alone, signatures
from haptid.discrepancy.detect.waves import with_waves
from haptid.discrepancy.fit.nominal_fit import NominalFit, at_own_step, fit_nominal, with_stiffer_presliding
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.resonance.resonances import find_resonances, offered
from haptid.discrepancy.search.trials.judging import judge_candidate, judge_on_other_path
from haptid.discrepancy.search.trials.searcher import Searcher, leaves_much
from haptid.discrepancy.search.under_observer.laws import Led
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.noise.correlation import Noise
from haptid.support.listener import Progress


def fit_nominal_model(study: Study, *, seed: int, starts: int, tell: Progress) -> tuple[Study, NominalFit]:
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
    tell("nominal fit")
    if study.carried is not None and study.carried.inner_step < MODEL.inner_step_s:
        study = at_needed_step(study, study.carried.inner_step)
    base = fit_nominal(study, starts=starts, seed=seed, tell=tell)
    step = step_for(study, base.solution, share=THRESHOLDS.detect.step_error_share_of_excess)
    fine = at_needed_step(study, step)
    if fine.factory.share < study.factory.share:
        base = at_own_step(fine, base)
    return with_stiffer_presliding(fine, base)


def under_own_noise(study: Study, base: NominalFit) -> tuple[Solution, Solution]:
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


def score_catalogue(
    study: Study, plain: Solution, tell: Progress, resonant: Collection[str] = ()
) -> tuple[dict[str, Effect], Signatures, Scan]:
    """Simulate and score the signatures of the catalogue.

    Parameters
    ----------
    study
        Study with the fitted runs.
    plain
        Nominal model under its own noise.
    tell
        Told of each step.
    resonant
        Keys of the effects whose resonance the runs show.

    Returns
    -------
    catalogue, found, scan
        Catalogue effects in SI units by key, without the forms that ask for a resonance that the runs do not show,
        their signatures at the nominal model, and their scores. The grids of
        waves over position hold those that stand out of the torque along the measured motion.
    """
    catalogue = offered(study.in_si(plain.values), resonant)
    if study.alone:  # of several joints the torque of each holds the others' motion
        catalogue = with_waves(catalogue, lambda: residual_over_position(study.fitted))
    effects = scored_alone(catalogue)

    def count(done: int) -> None:
        tell("signatures of the catalogue", done, len(effects))

    found = signatures(study, plain, effects, count)
    tell("scores of the catalogue", figures=f"{len(found.points)} signatures")
    first = scan(study, plain, found, catalogue)
    return catalogue, found, first


@dataclass(frozen=True, slots=True, kw_only=True)
class Begun:
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
    base: NominalFit
    white: Solution
    start: Trial
    searcher: Searcher
    first: Scan
    led: Led | None = None


def begin_search(
    study: Study, base: NominalFit, tell: Progress, fits: tuple[Solution, Solution] | None = None
) -> Begun:
    """Score the catalogue on the nominal model, and judge the model.

    Parameters
    ----------
    study, base
        Study and fit of the nominal model.
    tell
        Told of each step.
    fits
        What `under_own_noise` returned, where it was asked before.

    Returns
    -------
    Begun
    """
    white, plain = fits or under_own_noise(study, base)
    resonances = {}
    if study.alone and study.base.drive is None and leaves_much(white.chi2, study.rows):
        tell("frequency response")
        resonances = find_resonances(study.fitted, study.in_si(plain.values), prismatic=study.prismatic)
    catalogue, found, first = score_catalogue(study, plain, tell, resonances)
    s = Searcher(
        study, catalogue, found, first.tests, tell, base.calls * len(study.fitted) + found.simulations,
        resonances=resonances,
    )  # fmt: skip
    tell("tests of the nominal model")
    nominal = score_candidate(study, plain, plain.calls)
    s.nominal_excess = nominal.prediction.excess
    start = judge_on_other_path(s, judge_candidate(s, nominal))
    return Begun(study=study, base=base, white=white, start=start, searcher=s, first=first)
