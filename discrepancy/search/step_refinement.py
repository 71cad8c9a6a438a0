"""Refine the inner step for the best models: best `Trial` and its neighbours in, the same at a finer step out.

The step of the search is chosen for the nominal model. At that step a lag shorter than the step may look like a delay,
and a wrong effect together with the integration error like the true one. So the best models are compared at a step
whose error none of their effects can hide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.candidate.trial import Trial, chosen
from haptid.discrepancy.detect.inner_step import at_step, step_for, visible
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Refined:
    """The models near the best at a finer step.

    Parameters
    ----------
    searcher
        Tools of the search at that step.
    trials
        Trials that were fitted there.
    """

    searcher: Searcher
    trials: tuple[Trial, ...]

    @property
    def best(self) -> Trial | None:
        """Best acceptable trial, or None."""
        return chosen(self.trials)


def refine_step(s: Searcher, best: Trial, trials: Sequence[Trial]) -> Refined | None:
    """Refit the best model and those near it at the inner step that all of them need.

    Parameters
    ----------
    s
        Tools of the search.
    best
        Best trial.
    trials
        All trials of the search.

    Returns
    -------
    Refined or None
        Trials at the finer step. None where the residual is larger than the step can explain, where no finer step is
        needed, or where no step is fine enough, as contacts may make it.
    """
    if not best.solution.effects or best.left.far or _beyond(s, best):
        return None
    close = _near(best, trials)
    step = min(step_for(s.study, t.solution, s.study.factory.step) for t in close)
    if step == s.study.factory.step:
        return None
    if any(visible(s.study, t.solution, step) > THRESHOLDS.detect.invisible_step_error_chi2 for t in close):
        return None
    s.tell(f"the best {len(close)} again at the inner step of {1e3 * step:.3g} ms")
    fine = replace(s, study=at_step(s.study, step), finished={}, simulations=0)
    return Refined(searcher=fine, trials=tuple(fit_again(fine, t) for t in close))


def _beyond(s: Searcher, best: Trial) -> bool:
    """Say whether the excess energy of the best model is many times the step's error in squares."""
    excess = best.left.energy - best.left.dof
    error = visible(s.study, best.solution, s.study.factory.step)
    return not best.adequate and excess > THRESHOLDS.search.least_excess_over_step_error * error


def _near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Return the best model and others that are adequate if it is, one for each set of effects, best first."""
    first = {best.solution.keys: best}
    for t in sorted(trials, key=lambda t: t.candidate.criterion):
        if t.acceptable and (t.adequate or not best.adequate):
            first.setdefault(t.solution.keys, t)
    most = THRESHOLDS.search.most_finished_fits if best.adequate else THRESHOLDS.search.most_finished_if_all_far
    return list(first.values())[:most]


def fit_again(s: Searcher, trial: Trial) -> Trial:
    """Fit one model to the end in the searcher's study; its gains change by as much as criterion and score do.

    Parameters
    ----------
    s
        Tools of a search in another study of the same runs.
    trial
        Trial of the search before.

    Returns
    -------
    Trial
    """
    judged = judge_candidate(s, settle(s.study, trial.solution.effects, trial.solution))
    now, then = judged.candidate, trial.candidate
    return replace(
        judged,
        gain=trial.gain + then.criterion - now.criterion,
        held_out=trial.held_out + 2.0 * (now.prediction.score - then.prediction.score),
        least_evidence=max(judged.least_evidence, trial.least_evidence),
    )
