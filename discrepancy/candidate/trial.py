"""Judge a refitted candidate: `Candidate` with its test results in, `Trial` out.

A trial is adequate where no test finds more than noise in its residual. It is acceptable where its last effect has
earned its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.candidate.candidate import Candidate
from haptid.discrepancy.detect.omnibus import Omnibus
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A candidate with the tests for and against it.

    Parameters
    ----------
    candidate
        The refitted model.
    left
        Omnibus test of its residual.
    left_p
        Family-wise p-value of the score tests on its residual; NaN where another test has found something already.
    constant_p
        p of the parameters being the same in all runs, held-out ones included; tested where no other test finds
        anything.
    varying
        Id of the parameter that differs most between the runs; empty where that was not tested.
    gain
        Decrease of the criterion from that of the model that it extends.
    held_out
        Twice the gain in log predictive score on held-out runs, over the same model.
    fitted_gain
        Decrease of the BIC from that model, on fitted runs alone: an amplitude that they do not tell from 0 is no name,
        whatever it happens to predict.
    least_evidence
        Least Wald statistic of the earlier effects' amplitudes or, where the model was refitted without an effect, the
        loss of the criterion.
    at_bound
        Whether an amplitude ended at its bound.
    nominal_excess
        Excess of the nominal model over the stated noise, as `Prediction.excess` [1].
    refuted
        Whether the catalogue effect that scored against it has been fitted, as all others, and has not earned its
        place.
    """

    candidate: Candidate
    left: Omnibus
    left_p: float = np.nan
    constant_p: float = 1.0
    varying: str = ""
    gain: float = 0.0
    held_out: float = 0.0
    fitted_gain: float = np.inf
    least_evidence: float = np.inf
    at_bound: bool = False
    nominal_excess: float = 0.0
    refuted: bool = False

    @property
    def solution(self) -> Solution:
        """Optimum of the candidate."""
        return self.candidate.solution

    def against(self, before: Candidate) -> Trial:
        """Return the trial with its gains over the model ``before``.

        Parameters
        ----------
        before
            Model that the trial extends, scored on the same runs.

        Returns
        -------
        Trial
            Copy with `gain`, `held_out` and `fitted_gain`, positive where the trial is better.
        """
        return replace(
            self,
            gain=before.criterion - self.candidate.criterion,
            held_out=2 * (self.candidate.prediction.score - before.prediction.score),
            fitted_gain=before.bic - self.candidate.bic,
        )

    @property
    def adequate(self) -> bool:
        """Whether every test finds noise alone in the residual, on fitted and on held-out runs."""
        # Where every catalogue effect was fitted in vain, a low score alone is weak evidence, so it has to be much
        # lower.
        least = THRESHOLDS.candidate.family_wise_p_value
        if self.refuted:
            least = THRESHOLDS.candidate.refuted_family_wise_p_value
        return self.passes and self.left_p > least and not self.varies

    @property
    def varies(self) -> bool:
        """Whether the parameters differ from run to run by more than noise explains."""
        return self.constant_p <= THRESHOLDS.candidate.lack_p_value

    @property
    def passes(self) -> bool:
        """Whether the tests that need no scores of the catalogue find nothing.

        A model discrepancy may be mistaken for correlated noise. Effects that explain it leave no more than the stated
        noise, so a model with effects must not exceed it, but for next to nothing of what the nominal model leaves: a
        stated noise may be off, or may leave out what is correlated.
        """
        prediction, limits = self.candidate.prediction, THRESHOLDS.candidate
        most = max(
            limits.largest_excess_over_stated_noise, limits.largest_share_of_nominal_excess * self.nominal_excess
        )
        as_stated = prediction.excess <= most
        explained = not self.solution.effects or as_stated
        return self.left.p > THRESHOLDS.candidate.lack_p_value and prediction.noise_alone and explained

    @property
    def acceptable(self) -> bool:
        """Whether the last effect of the model has earned its place."""
        return (
            self.gain > THRESHOLDS.candidate.least_gain_in_criterion
            and self.held_out >= 0.0
            and self.fitted_gain > 0.0
            and self.least_evidence > THRESHOLDS.candidate.least_wald_statistic
            and not self.at_bound
        )


def keys_of(solution: Solution) -> frozenset[str]:
    """Return the keys of the effects in the equations as a set, whatever their order.

    Parameters
    ----------
    solution
        Optimum of a model with any number of effects.

    Returns
    -------
    frozenset of str
        Empty for the nominal model.
    """
    return frozenset(e.key for e in solution.effects)


def chosen(trials: Sequence[Trial]) -> Trial | None:
    """Choose the best acceptable trial.

    Parameters
    ----------
    trials
        Trials that compete.

    Returns
    -------
    Trial or None
        The adequate trial of least criterion; without adequate ones, the acceptable trial of least criterion.
    """
    good = [t for t in trials if t.acceptable]
    return min([t for t in good if t.adequate] or good, key=lambda t: t.candidate.criterion, default=None)
