"""The best model and what comes near it, compared at an inner step whose error none of their effects hides.

The step of the search is chosen for the base. There a lag shorter than the step may look like a delay that is not, and
a wrong effect with the stepper's error like the true one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from haptid.discrepancy.candidate.candidate import Trial, chosen
from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.detect.inner_step import INVISIBLE, at_step, step_for, visible
from haptid.discrepancy.search.tools import FEW, FINISHED, Searcher

BEYOND = 10.0
"""Multiple of the step's visible error that is not of the step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Closer:
    """What a finer step makes of the models near the best, and the search's tools there."""

    searcher: Searcher
    trials: tuple[Trial, ...]

    @property
    def best(self) -> Trial | None:
        """The best of them, None where none has earned its effects."""
        return chosen(self.trials)


def closer(s: Searcher, best: Trial, trials: Sequence[Trial]) -> Closer | None:
    """Fit the best model and what is near it again at the step that they all need; None where it is no finer.

    What leaves more than the step's error can account for does so at any step; and where contacts make the likelihood
    rough, none is fine enough.
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
    """Whether the best model leaves many times as much, beyond chance, as the step's error is in squares."""
    excess = best.left.energy - best.left.dof
    return not best.adequate and excess > BEYOND * visible(s.study, best.solution, s.study.factory.step)


def _near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Return the best model and others that leave as little as it does, one per set of effects, the better first.

    They are few where none leaves only noise.
    """
    first = {best.solution.keys: best}
    for t in sorted(trials, key=lambda t: t.candidate.criterion):
        if t.acceptable and (t.adequate or not best.adequate):
            first.setdefault(t.solution.keys, t)
    return list(first.values())[: FINISHED if best.adequate else FEW]


def _again(s: Searcher, trial: Trial) -> Trial:
    """Fit one model to the end at the searcher's step; what it gains changes by as much as criterion and score do."""
    judged = s.trial(settle(s.study, trial.solution.effects, trial.solution))
    now, then = judged.candidate, trial.candidate
    return replace(
        judged,
        gain=trial.gain + then.criterion - now.criterion,
        held_out=trial.held_out + 2.0 * (now.prediction.score - then.prediction.score),
        worth=max(judged.worth, trial.worth),
    )
