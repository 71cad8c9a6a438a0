"""Hold the result of a search in one joint, or in several joints that move together."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from haptid.discrepancy.candidate.candidate import Candidate
from haptid.discrepancy.candidate.trial import Trial, keys_of
from haptid.discrepancy.detect.score_tests import Scan
from haptid.discrepancy.fit.nominal_fit import NominalFit
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import law_named


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Result of a search for missing effects.

    Parameters
    ----------
    study
        Study at the inner step that was chosen.
    base
        Fit of the nominal model with its starts, under white noise.
    plain
        Nominal model under the noise estimated from its residuals.
    scan
        Scores of the whole catalogue at the nominal model.
    trials
        Every candidate that was fitted to the end, in the order of the search.
    best
        Trial with which the search ended.
    less
        The best trial without one of its effects, by the key of that effect.
    contenders
        The best model with an unlisted effect of the same kind in the place of one of its effects.
    simulations
        Number of runs simulated in fits, without those that linearise about the amplitudes of cycles.
    cut
        Whether combinations of effects were left out because the effort was spent.
    standing
        Keys of the best trial's effects where it leaves more than noise, but no other effect comes near them.
    standing_rivals
        Trials with a declared rival in the place of one of these effects, which leave nearly as little.
    asked
        Nominal model under the friction law that was asked for, where that of ``study`` took its place.
    """

    study: Study
    base: NominalFit
    plain: Trial
    scan: Scan
    trials: tuple[Trial, ...]
    best: Trial
    less: dict[str, Candidate] = field(default_factory=dict)
    contenders: tuple[Trial, ...] = ()
    simulations: int = 0
    cut: bool = False
    standing: tuple[str, ...] = ()
    standing_rivals: tuple[Trial, ...] = ()
    asked: Trial | None = None

    @property
    def before(self) -> Trial:
        """Nominal model as it was asked for, to which the outcome is compared."""
        return self.plain if self.asked is None else self.asked

    @property
    def law(self) -> FrictionLaw | None:
        """Friction law in the place of the one that was asked for; None where that one stayed."""
        return None if self.asked is None else law_named(self.study.base.friction[0])

    @property
    def evidence_for_law(self) -> float:
        """Evidence for the friction law over the one that was asked for, as `evidence` defines it."""
        return self._evidence(self.plain.candidate, self.before.candidate)

    @property
    def rivals(self) -> tuple[Trial, ...]:
        """Trials with other effects that predict as well as the best one, best first, one for each set of ids."""
        close: dict[frozenset[str], Trial] = {}
        for t in self._close:
            if frozenset(t.candidate.ids) != frozenset(self.best.candidate.ids):
                close.setdefault(frozenset(t.candidate.ids), t)
        return tuple(close.values())

    def variants(self, trial: Trial) -> tuple[Trial, ...]:
        """Return other variants of a trial's effects that predict as well as the best trial.

        Parameters
        ----------
        trial
            Trial of this search.

        Returns
        -------
        tuple of Trial
            Trials with the same ids under other keys, best first.
        """
        close: dict[frozenset[str], Trial] = {keys_of(trial.solution): trial}
        for t in self._close:
            if frozenset(t.candidate.ids) == frozenset(trial.candidate.ids):
                close.setdefault(keys_of(t.solution), t)
        return tuple(close.values())[1:]

    @property
    def _close(self) -> list[Trial]:
        """Trials that predict as well as the best one, best first.

        Between effects that the catalogue calls rivals, the BIC's charge for further parameters is no evidence, where
        both fit. That the best model is just adequate and another just not is no evidence beside their criterion.
        """
        few = [t for t in (*self.trials, *self.contenders) if len({*t.candidate.ids}) <= len(self.best.candidate.ids)]
        return [
            t
            for t in sorted(few, key=lambda t: t.candidate.criterion)
            if t.acceptable and self._is_close(t, self._price(t) if t.adequate or not self.best.adequate else 0.0)
        ]

    def _is_close(self, other: Trial, price: float = 0.0) -> bool:
        """Say whether the criterion of a trial is as low as the best one's, but for the price of its parameters."""
        behind = other.candidate.criterion - self.best.candidate.criterion
        return behind < THRESHOLDS.candidate.rival_criterion_gap + price

    def _price(self, other: Trial) -> float:
        """Return k·ln n for the k further parameters of a trial in which a rival replaces one effect; else 0."""
        ours, theirs = self.best.solution, other.solution
        mine = [e for e in ours.effects if e.id not in theirs.ids]
        its = [e for e in theirs.effects if e.id not in ours.ids]
        if len(mine) != 1 or len(its) != 1 or not (its[0].id in mine[0].rivals or mine[0].id in its[0].rivals):
            return 0.0
        further = other.candidate.parameters - self.best.candidate.parameters
        return max(further, 0) * float(np.log(self.study.rows))

    @property
    def beaten_by(self) -> Trial | None:
        """Best contender that predicts better than the best model by more than `rival_criterion_gap`, or None.

        The contender need not be adequate: even so, the name that it beats is no finding.
        """
        least = self.best.candidate.criterion - THRESHOLDS.candidate.rival_criterion_gap
        better = [t for t in self.contenders if t.candidate.criterion < least]
        return min(better, key=lambda t: t.candidate.criterion, default=None)

    def evidence(self, key: str) -> float:
        """Return the evidence for one effect of the best model.

        Parameters
        ----------
        key
            Key of the effect.

        Returns
        -------
        float
            Twice the gain in log predictive score on held-out runs; the gain in BIC where every run was fitted.
        """
        return self._evidence(self.best.candidate, self.less[key])

    def _evidence(self, now: Candidate, before: Candidate) -> float:
        if self.study.unseen:
            return 2.0 * (now.prediction.score - before.prediction.score)
        return before.bic - now.bic
