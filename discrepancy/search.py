"""The search: from the base, one effect at a time, until what is left is noise or no entry helps any more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from discrepancy.base import Base, fit_base
from discrepancy.noise import Noise
from discrepancy.noise_estimate import estimate
from discrepancy.omnibus import Omnibus, omnibus
from discrepancy.refit import Candidate, judged, quick, refit_with, settle, significance
from discrepancy.scan import Scan, Score, scan
from discrepancy.signatures import Signatures, signatures
from discrepancy.solution import Solution, solve
from discrepancy.study import Study, scales_of
from model.effect import Effect

FAMILY = 0.002
"""p over the whole catalogue below which a score counts."""
LACK = 5e-4
"""p of the omnibus test below which a model lacks something."""
BATCH, SETTLED = 6, 3
"""Entries that are tried at once, and how many of them are fitted to the end."""
CLOSE, MOST_RIVALS = 40.0, 6
"""Log-likelihood from the best within which a begun fit is finished as a rival, and how many of them."""
TRIED = 24
"""Most entries that are tried in one step."""
BETTER = 6.0
"""Least gain in the criterion that an effect has to bring."""
SIGNIFICANT = 9.0
"""Least squared ratio of an effect's amplitude to its standard error."""
MOST = 3
"""Most effects at once."""

Report = Callable[[str], None]


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
        Smallest p over the catalogue of what it leaves.
    gain
        By how much its criterion is better than that of the model that it extends.
    held_out
        Twice the gain in log predictive score on unseen runs, over the same.
    wald
        Least squared ratio of an effect's amplitude to its standard error.
    at_bound
        Whether an amplitude ended at its bound.
    """

    candidate: Candidate
    left: Omnibus
    left_p: float
    gain: float = 0.0
    held_out: float = 0.0
    wald: float = np.inf
    at_bound: bool = False

    @property
    def adequate(self) -> bool:
        """Whether it leaves nothing but noise."""
        return self.left.p > LACK and self.left_p > FAMILY

    @property
    def acceptable(self) -> bool:
        """Whether its last effect has earned its place."""
        return self.gain > BETTER and self.held_out > 0 and self.wald > SIGNIFICANT and not self.at_bound


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Everything that the search found out.

    Parameters
    ----------
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
    simulations
        Simulated runs.
    """

    base: Base
    plain: Trial
    scan: Scan
    found: Signatures
    entries: dict[str, Effect]
    trials: tuple[Trial, ...]
    best: Trial
    simulations: int
    notes: tuple[str, ...] = field(default=())

    @property
    def rivals(self) -> tuple[Trial, ...]:
        """Other trials with other effects that predict as well as the best one, the better first."""
        close = [
            t for t in self.trials
            if set(t.candidate.ids) != set(self.best.candidate.ids)
            and t.acceptable
            and len(t.candidate.ids) <= len(self.best.candidate.ids)
            and t.candidate.criterion - self.best.candidate.criterion < RIVAL
            and (t.adequate or not self.best.adequate)
        ]  # fmt: skip
        return tuple(sorted(close, key=lambda t: t.candidate.criterion))


RIVAL = 10.0
"""Candidates whose criterion is this close cannot be told apart."""


class Searcher:
    """The state of one search: the study, the signatures at its base, and the running count of simulations."""

    def __init__(self, study: Study, report: Report) -> None:
        self.study, self.report = study, report
        self.simulations = 0
        self.entries: dict[str, Effect] = {}
        self.found: Signatures
        self.tests = 1.0

    def trial(self, candidate: Candidate, before: Candidate | None = None) -> Trial:
        """Judge a candidate, against ``before`` where it extends one."""
        solution = candidate.solution
        left = scan(self.study, solution, self.found, self.entries, tests=self.tests)
        wald, at_bound = significance(solution)
        return Trial(
            candidate=candidate,
            left=omnibus(self.study, solution),
            left_p=left.family_p,
            gain=0.0 if before is None else before.criterion - candidate.criterion,
            held_out=0.0 if before is None else 2 * (candidate.prediction.score - before.prediction.score),
            wald=wald,
            at_bound=at_bound,
        )

    def step(self, current: Trial, scores: Sequence[Score]) -> list[Trial]:
        """Try entries in the order of their scores, batch by batch, until one leaves nothing but noise."""
        trials: list[Trial] = []
        solution = current.candidate.solution
        taken = {key.partition(":")[0] for key in solution.keys}
        fresh = [s for s in scores if self.entries[s.key].id not in taken and s.T > SIGNIFICANT][:TRIED]
        begun: list[Solution] = []
        for first in range(0, len(fresh), BATCH):
            for score in fresh[first : first + BATCH]:
                tried, calls = quick(self.study, solution, self.entries[score.key], score)
                self.simulations += calls * len(self.study.fitted)
                begun.append(tried)
            begun.sort(key=lambda s: -s.log_likelihood)
            for _ in range(SETTLED):
                trials += self.finish(current, begun[:1])
                begun = begun[1:]
                if not begun or trials[-1].adequate:
                    break
            if any(t.adequate and t.acceptable for t in trials):
                break
        best = max((t.candidate.solution.log_likelihood for t in trials), default=0.0)
        close = [s for s in begun if s.log_likelihood > best - CLOSE][:MOST_RIVALS]
        return trials + self.finish(current, close)

    def finish(self, current: Trial, begun: Sequence[Solution]) -> list[Trial]:
        """Fit to the end what was begun, and judge it."""
        trials = []
        for tried in begun:
            candidate = settle(self.study, tried.effects, tried)
            self.simulations += candidate.calls * len(self.study.fitted)
            made = self.trial(candidate, current.candidate)
            self.report(
                f"{'+'.join(candidate.solution.keys)}: gain {made.gain:.0f}, unseen {made.held_out:.0f}, "
                f"left over {made.left.energy:.0f}/{made.left.dof}"
            )
            trials.append(made)
        return trials


def search(study: Study, *, seed: int = 0, most: int = MOST, report: Report = lambda _: None) -> Search:
    """Run the whole search on one joint."""
    s = Searcher(study, report)
    base = fit_base(study, seed=seed)
    report(f"base fit: {base.solution.chi2 / study.rows:.3f} of the noise's variance, {base.reached} starts agree")
    plain = _with_noise(study, base.solution)
    scales = scales_of(study, plain.values)
    s.entries = {key: e.at(scales) for key, e in study.entries.items() if not e.random}
    s.found = signatures(study, plain, list(s.entries.values()))
    s.simulations = (base.calls + plain.calls) * len(study.fitted) + s.found.simulations
    first = scan(study, plain, s.found, s.entries)
    s.tests = first.tests
    start = s.trial(judged(study, plain, plain.calls))
    trials: list[Trial] = []
    best, scores = start, first.scores
    for _ in range(most):
        if best.adequate:
            break
        made = s.step(best, scores)
        trials += made
        good = [t for t in made if t.acceptable]
        if not good:
            break
        adequate = [t for t in good if t.adequate]
        best = min(adequate or good, key=lambda t: t.candidate.criterion)
        scores = scan(study, best.candidate.solution, s.found, s.entries, tests=s.tests).scores
    best, trimmed = _backward(s, best, start)
    return Search(
        base=base, plain=start, scan=first, found=s.found, entries=s.entries, trials=(*trials, *trimmed), best=best,
        simulations=s.simulations,
    )


def _with_noise(study: Study, solution: Solution) -> Solution:
    """The base under the noise that its own residuals show."""
    noise = estimate(study, solution)
    return solution if noise == Noise() else solve(study, (), noise, solution.values, x0=solution.x0)


def _backward(s: Searcher, best: Trial, start: Trial) -> tuple[Trial, list[Trial]]:
    """Drop effects that the others have made superfluous."""
    made: list[Trial] = []
    while len(best.candidate.solution.effects) > 1:
        full = best.candidate.solution
        smaller = []
        for effect in full.effects[:-1]:
            rest = [e for e in full.effects if e is not effect]
            candidate = refit_with(s.study, full, rest, full.values)
            s.simulations += candidate.calls * len(s.study.fitted)
            smaller.append(s.trial(candidate, start.candidate))
        made += smaller
        least = min(smaller, key=lambda t: t.candidate.criterion)
        if least.candidate.criterion - best.candidate.criterion > BETTER or not least.adequate:
            break
        best = least
    return best, made
