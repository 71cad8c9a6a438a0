"""What a search found out about one joint."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from haptid.discrepancy.candidate.candidate import RIVAL, Trial, keys_of
from haptid.discrepancy.candidate.refit import Candidate
from haptid.discrepancy.detect.score_tests import Scan
from haptid.discrepancy.fit.nominal_fit import Base
from haptid.discrepancy.study.study import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Everything that the search found out.

    Parameters
    ----------
    study
        The study at the inner step that was chosen.
    base
        The base fit with its starts, under white noise.
    plain
        The base under the noise model estimated from it.
    scan
        Scores of the whole catalogue at the base.
    trials
        Every candidate that was fitted to the end, in the order of the steps.
    best
        Where the search ended.
    less
        For each effect of the best trial, by key, that trial without it.
    contenders
        The best model with an effect in place of its own that is no entry of the catalogue.
    simulations
        Runs simulated in fits. Those that linearise about the amplitudes of cycles are not among them.
    cut
        Whether combinations of effects were left out for want of effort.
    """

    study: Study
    base: Base
    plain: Trial
    scan: Scan
    trials: tuple[Trial, ...]
    best: Trial
    less: dict[str, Candidate] = field(default_factory=dict)
    contenders: tuple[Trial, ...] = ()
    simulations: int = 0
    cut: bool = False

    @property
    def rivals(self) -> tuple[Trial, ...]:
        """Other trials with other effects that predict as well as the best one, the better first, one per set."""
        close: dict[frozenset[str], Trial] = {}
        for t in self._close:
            if frozenset(t.candidate.ids) != frozenset(self.best.candidate.ids):
                close.setdefault(frozenset(t.candidate.ids), t)
        return tuple(close.values())

    def variants(self, trial: Trial) -> tuple[Trial, ...]:
        """Return other variants of a trial's effects that predict as well as the best one, the better first."""
        close: dict[frozenset[str], Trial] = {keys_of(trial.solution): trial}
        for t in self._close:
            if frozenset(t.candidate.ids) == frozenset(trial.candidate.ids):
                close.setdefault(keys_of(t.solution), t)
        return tuple(close.values())[1:]

    @property
    def _close(self) -> list[Trial]:
        """Trials that predict as well as the best one, the better first.

        What a parameter more costs in BIC tells nothing of entries that the catalogue calls rivals, where both fit.
        """
        return [
            t
            for t in sorted((*self.trials, *self.contenders), key=lambda t: t.candidate.criterion)
            if t.acceptable
            and len(frozenset(t.candidate.ids)) <= len(self.best.candidate.ids)
            and t.candidate.criterion - self.best.candidate.criterion < RIVAL + self._price(t)
            and (t.adequate or not self.best.adequate)
        ]

    def _price(self, other: Trial) -> float:
        """Return what a trial's further parameters cost it, k·ln n, where a rival has the place of one effect."""
        ours, theirs = self.best.solution, other.solution
        mine = [e for e in ours.effects if e.id not in theirs.ids]
        its = [e for e in theirs.effects if e.id not in ours.ids]
        if len(mine) != 1 or len(its) != 1 or not (its[0].id in mine[0].rivals or mine[0].id in its[0].rivals):
            return 0.0
        further = other.candidate.parameters - self.best.candidate.parameters
        return max(further, 0) * float(np.log(self.study.rows))

    @property
    def beaten_by(self) -> Trial | None:
        """Return the best contender where it predicts better than the best model by more than rivals differ.

        It may leave more than noise itself: what it beats is no finding all the same.
        """
        least = self.best.candidate.criterion - RIVAL
        better = [t for t in self.contenders if t.candidate.criterion < least]
        return min(better, key=lambda t: t.candidate.criterion, default=None)

    def evidence(self, key: str) -> float:
        """Twice the gain in held-out log predictive score by one effect; in BIC where every run was fitted."""
        with_it, without = self.best.candidate, self.less[key]
        if self.study.unseen:
            return 2.0 * (with_it.prediction.score - without.prediction.score)
        return without.bic - with_it.bic
