"""A model with one effect more, held against the model without it: two `TorqueFit`s in, `TorqueCandidate` out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque_search.stretches import gain_of
from haptid.support.linear_algebra import rms


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueCandidate:
    """A model that was refitted with one effect more.

    Parameters
    ----------
    key
        Key of the effect.
    model
        Refitted model.
    bic
        Gain in BIC on fitted stretches, each correlation length counted as one row.
    evidence
        Twice the gain in log score of stretches that the other fitted stretches predict, counted alike.
    errors_gained
        Decrease of the energy of predicted stretches, in its standard errors over the stretches.
    significance
        √(twice the gain in log score on fitted stretches): the effect's amplitudes in standard errors.
    vetoed
        Whether the model does worse on held-out rows than without the effect.
    stands_for_inertia
        Whether the effect is a delay with which the inertia is far from that of the nominal model (`rigid_body`): then
        it is no candidate, however well it fits.
    """

    key: str
    model: TorqueFit
    bic: float
    evidence: float
    errors_gained: float
    significance: float
    vetoed: bool
    stands_for_inertia: bool = False

    @property
    def acceptable(self) -> bool:
        """Whether the model fits and predicts fitted stretches clearly better: then the effect is added."""
        fits_better = self.bic > THRESHOLDS.torque.least_twice_gain
        return fits_better and self.predicts_better and not self.stands_for_inertia

    @property
    def plausible(self) -> bool:
        """Whether the model fits and predicts fitted stretches better at all: then it may stand in another's place."""
        return self.bic > 0.0 and self.predicts_better and not self.stands_for_inertia

    @property
    def predicts_better(self) -> bool:
        """Whether the model predicts fitted stretches better, by more than they vary."""
        limits = THRESHOLDS.torque
        return self.evidence > limits.least_twice_gain and self.errors_gained > limits.least_gain_in_standard_errors

    @property
    def stays(self) -> bool:
        """Whether the effect keeps its place beside all others: its amplitude is not 0, and predictions need it."""
        clear = self.significance > THRESHOLDS.torque.least_amplitude_in_standard_errors
        return clear and self.evidence > 0.0 and not self.vetoed


def compare_candidates(key: str, less: TorqueFit, more: TorqueFit) -> TorqueCandidate:
    """Compare a model with the same model without the effect that was added last.

    Parameters
    ----------
    key
        Key of the effect that was added.
    less, more
        Models without and with that effect.

    Returns
    -------
    TorqueCandidate
        The larger model with its gain in BIC and its evidence on predicted stretches.
    """
    gain = gain_of(less, more)
    extra = more.problem.n_parameters - less.problem.n_parameters
    return TorqueCandidate(
        key=key,
        model=more,
        bic=gain.fitted - extra * float(np.log(gain.n)),
        evidence=gain.predicted,
        errors_gained=gain.errors,
        significance=float(np.sqrt(max(gain.fitted, 0.0))),
        vetoed=_does_worse(less, more),
    )


def _does_worse(less: TorqueFit, more: TorqueFit) -> bool:
    """Whether the larger model leaves more of the held-out rows that name effects."""
    if more.unseen.size == 0:
        return False
    return rms(more.unseen_away) > rms(less.unseen_away)
