"""Refine the inner step for the best models: best `Trial` and its neighbours in, the same at a finer step out.

The step of the search is chosen for the nominal model. At that step a lag shorter than the step may look like a delay,
and a wrong effect together with the integration error like the true one. So the best models are compared at a step
whose error none of their effects can hide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from haptid.discrepancy.candidate.candidate import Trial, chosen
from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.detect.inner_step import INVISIBLE, at_step, step_for, visible
from haptid.discrepancy.search.tools import FEW, FINISHED, Searcher

BEYOND = 10.0
"""Multiple of the step's visible error beyond which a residual cannot come from the step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Closer:
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


def closer(s: Searcher, best: Trial, trials: Sequence[Trial]) -> Closer | None:
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
    Closer or None
        Trials at the finer step. None where the residual is larger than the step can explain, where no finer step is
        needed, or where no step is fine enough, as contacts may make it.
    """
    if not best.solution.effects or best.left.far or _beyond(s, best):
        return None
    close = _near(best, trials)
    step = min(step_for(s.study, t.solution, s.study.factory.step) for t in close)
    if step == s.study.factory.step or any(visible(s.study, t.solution, step) > INVISIBLE for t in close):
        return None
    s.tell(f"inner step of {1e3 * step:.3g} ms: the best {len(close)} again")
    fine = replace(s, study=at_step(s.study, step), finished={}, simulations=0)
    return Closer(searcher=fine, trials=tuple(_again(fine, t) for t in close))


def _beyond(s: Searcher, best: Trial) -> bool:
    """Say whether the excess energy of the best model is many times the step's error in squares."""
    excess = best.left.energy - best.left.dof
    return not best.adequate and excess > BEYOND * visible(s.study, best.solution, s.study.factory.step)


def _near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Return the best model and others that are adequate if it is, one for each set of effects, best first."""
    first = {best.solution.keys: best}
    for t in sorted(trials, key=lambda t: t.candidate.criterion):
        if t.acceptable and (t.adequate or not best.adequate):
            first.setdefault(t.solution.keys, t)
    return list(first.values())[: FINISHED if best.adequate else FEW]


def _again(s: Searcher, trial: Trial) -> Trial:
    """Fit one model to the end at the searcher's step; its gains change by as much as criterion and score do."""
    judged = s.trial(settle(s.study, trial.solution.effects, trial.solution))
    now, then = judged.candidate, trial.candidate
    return replace(
        judged,
        gain=trial.gain + then.criterion - now.criterion,
        held_out=trial.held_out + 2.0 * (now.prediction.score - then.prediction.score),
        worth=max(judged.worth, trial.worth),
    )
