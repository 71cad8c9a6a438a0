"""The best model and what comes near it, compared at an inner step whose error none of their effects hides.

The step of the search is chosen for the base. There a lag shorter than the step may look like a delay that is not, and
a wrong effect with the stepper's error like the true one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from discrepancy.refit import settle
from discrepancy.steps import at_step, step_for
from discrepancy.trial import FINISHED, Searcher, Trial, chosen


@dataclass(frozen=True, slots=True, kw_only=True)
class Closer:
    """What a finer step makes of the models near the best: the search's tools there, the base, and the models."""

    searcher: Searcher
    start: Trial
    trials: tuple[Trial, ...]

    @property
    def best(self) -> Trial | None:
        """The best of them, None where none has earned its effects."""
        return chosen(self.trials)


def closer(s: Searcher, start: Trial, best: Trial, trials: Sequence[Trial]) -> Closer | None:
    """Fit base, best model and what is near it again at the step that they all need; None where it is no finer.

    What is far from noise is so at any step.
    """
    if not best.solution.effects or best.left.far:
        return None
    close = _near(best, trials)
    step = min(step_for(s.study, t.solution, s.study.factory.step) for t in close)
    if step == s.study.factory.step:
        return None
    s.tell(f"inner step of {1e3 * step:.3g} ms: the best {len(close)} again")
    fine = replace(s, study=at_step(s.study, step), finished={})
    base = fine.trial(settle(fine.study, (), start.solution))
    return Closer(searcher=fine, start=base, trials=tuple(_again(fine, t, base) for t in close))


def _near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Return the best model and others that leave as little as it does, one per set of effects, the better first."""
    first = {frozenset(best.solution.keys): best}
    for t in sorted(trials, key=lambda t: t.candidate.criterion):
        if t.acceptable and (t.adequate or not best.adequate):
            first.setdefault(frozenset(t.solution.keys), t)
    return list(first.values())[:FINISHED]


def _again(s: Searcher, trial: Trial, start: Trial) -> Trial:
    """Fit one model to the end at the searcher's step and judge it against the base; its effects keep their worth."""
    judged = s.trial(settle(s.study, trial.solution.effects, trial.solution), start.candidate)
    return replace(judged, worth=max(judged.worth, trial.worth))
