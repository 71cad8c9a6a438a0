"""A candidate that was tried, with what speaks for and against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.candidate.refit import Candidate
from haptid.discrepancy.detect.omnibus import Omnibus
from haptid.discrepancy.fit.solution import Solution

FAMILY = 0.002
"""p over the whole catalogue below which a score counts."""
REFUTABLE = 1e-4
"""p over the whole catalogue below which a score counts although no entry that was fitted has earned its place."""
LACK = 5e-4
"""p of the omnibus test below which a model lacks something."""
EXCESS = 0.02
"""Largest share of a run's mean square over the stated noise, beyond chance, where effects leave nothing but noise."""
BETTER = 6.0
"""Least gain in the criterion that an effect has to bring."""
RIVAL = 10.0
"""Candidates whose criterion is this close cannot be told apart."""
SIGNIFICANT = 9.0
"""Least that an effect is worth: squared ratio of its amplitude to its standard error, or loss of the criterion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A candidate with what speaks for and against it.

    Parameters
    ----------
    candidate
        The refitted model.
    left
        Omnibus test of what it leaves.
    left_p
        Smallest p over the catalogue of what it leaves; NaN where another test has found something already.
    constant_p
        p of its parameters being the same in all runs, the unseen ones too; tested where nothing else is found.
    gain
        By how much its criterion is better than that of the model that it extends.
    held_out
        Twice the gain in log predictive score on unseen runs, over the same.
    worth
        Least that an earlier effect is worth: the squared ratio of its amplitude to its standard error or, where a fit
        without it was made, what the criterion loses.
    at_bound
        Whether an amplitude ended at its bound.
    refuted
        Whether the entry whose score spoke against it has been fitted, as all others, and has not earned its place.
    """

    candidate: Candidate
    left: Omnibus
    left_p: float = np.nan
    constant_p: float = 1.0
    gain: float = 0.0
    held_out: float = 0.0
    worth: float = np.inf
    at_bound: bool = False
    refuted: bool = False

    @property
    def solution(self) -> Solution:
        """Its optimum."""
        return self.candidate.solution

    def against(self, before: Candidate) -> Trial:
        """Return it with its gains over another model."""
        return replace(
            self,
            gain=before.criterion - self.candidate.criterion,
            held_out=2 * (self.candidate.prediction.score - before.prediction.score),
        )

    @property
    def adequate(self) -> bool:
        """Whether it leaves nothing but noise, on fitted and on unseen runs."""
        return self.passes and self.left_p > (REFUTABLE if self.refuted else FAMILY) and not self.varies

    @property
    def varies(self) -> bool:
        """Whether it leaves nothing but noise, but with other parameters in every run."""
        return self.constant_p <= LACK

    @property
    def passes(self) -> bool:
        """Whether the tests that need no scores of the catalogue find nothing.

        A gap may pass for correlated noise. Effects that explain it leave no more than the noise that is stated.
        """
        prediction = self.candidate.prediction
        explained = not self.solution.effects or prediction.excess <= EXCESS
        return self.left.p > LACK and prediction.noise_alone and explained

    @property
    def acceptable(self) -> bool:
        """Whether its last effect has earned its place."""
        return self.gain > BETTER and self.held_out >= 0.0 and self.worth > SIGNIFICANT and not self.at_bound


def keys_of(solution: Solution) -> frozenset[str]:
    """Keys of the effects in the equations, in no order."""
    return frozenset(e.key for e in solution.effects)


def chosen(trials: Sequence[Trial]) -> Trial | None:
    """Return the best of the acceptable trials, one that leaves nothing but noise before any other."""
    good = [t for t in trials if t.acceptable]
    return min([t for t in good if t.adequate] or good, key=lambda t: t.candidate.criterion, default=None)
