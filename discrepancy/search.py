"""The search: scan, refit the best, guard against a stuck base, accept or stop; then remove backwards.

Base fit, omnibus test, score scan with family-wise error, joint refits judged on runs that no fit saw,
re-base, forward selection of up to `MOST` effects, backward removal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from discrepancy.base import fit_base
from discrepancy.colour import estimate_colour
from discrepancy.held_out import Prediction, predict
from discrepancy.noise import Noise
from discrepancy.omnibus import Omnibus, omnibus
from discrepancy.refit import SCATTER, Candidate, refit, scattered, without
from discrepancy.scan import Scan, scan
from discrepancy.signatures import signatures
from discrepancy.solution import Solution, solve
from discrepancy.study import Study, scales_of
from model.scales import Scales

MOST = 3
"""Effects that may act together."""
REFITS = 5
"""Entries of a scan that are refitted."""
SIGNIFICANT = 0.01
"""Family-wise p below which an entry is refitted, and p of the omnibus test below which something is missing."""
RIVAL = 10.0
"""Difference in BIC within which two candidates count as rivals."""
STUCK = 10.0
"""Decrease of the base's cost, found from a winner's optimum, that shows the base fit to have been stuck."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One round of the forward search: the test, the scan, the candidates (best first) and which of them was taken."""

    test: Omnibus
    scan: Scan
    candidates: tuple[Candidate, ...]
    taken: Candidate | None
    rivals: tuple[Candidate, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Everything that the search found."""

    base: Solution
    base_prediction: Prediction
    final: Solution
    final_prediction: Prediction
    steps: tuple[Step, ...]
    last_test: Omnibus
    scales: Scales
    reached: tuple[int, int]
    simulations: int
    evidence: dict[str, float] = field(default_factory=dict)
    rivals: tuple[Candidate, ...] = ()


def search(study: Study, *, seed: int = 0, starts: int = 8, tell: Callable[[str], None] = lambda _: None) -> Search:
    """Look for what is missing in the base model of ``study``; ``tell`` hears of the progress."""
    tell("base fit")
    fitted = fit_base(study, starts=starts, seed=seed)
    base, calls = _coloured(study, fitted.solution), fitted.calls
    scales = scales_of(study, base.values)
    current, unseen = base, predict(study, base)
    first = unseen
    steps: list[Step] = []
    for _ in range(MOST):
        step, cost = _step(study, current, unseen, scales, seed, tell)
        calls += cost
        if step.taken is not None and (better := _rebased(study, current, step.taken)) is not None:
            tell("the base fit was stuck: again from the better minimum")
            current, unseen = better, predict(study, better)
            if not current.keys:
                base, first = current, unseen
            step, cost = _step(study, current, unseen, scales, seed, tell)
            calls += cost
        steps.append(step)
        if step.taken is None or (current.keys and step.test.p >= SIGNIFICANT):
            break
        current, unseen = step.taken.solution, step.taken.prediction
    tell("backward removal")
    current, unseen, evidence = _backward(study, current, unseen)
    return Search(
        base=base,
        base_prediction=first,
        final=current,
        final_prediction=unseen,
        steps=tuple(steps),
        last_test=omnibus(study, current),
        scales=scales,
        reached=(fitted.reached, len(fitted.costs)),
        simulations=calls * len(study.fitted),
        evidence=evidence,
        rivals=_rivals(steps, current),
    )


def _coloured(study: Study, base: Solution) -> Solution:
    """Fit the base again under the residuals' own colour, off the harmonics of the drive, where it is not white."""
    colour = estimate_colour([r[:, 0] for r in base.blocks.rows], study.fitted, study.cycles())
    if colour.white and abs(colour.sigma - 1.0) < 1e-9:
        return base
    return solve(study, (), Noise(colour=colour), base.values, x0=base.x0)


def _step(
    study: Study, current: Solution, unseen: Prediction, scales: Scales, seed: int, tell: Callable[[str], None]
) -> tuple[Step, int]:
    """Scan the catalogue about ``current`` and refit the best entries."""
    tell("scan of the catalogue")
    test = omnibus(study, current)
    entries = {key: e.at(scales) for key, e in study.entries.items() if not e.random and e.id not in current.ids}
    found = signatures(study, current, list(entries.values()))
    scores = scan(current, found, seed=seed)
    calls = found.simulations // max(len(study.fitted), 1)
    promising = [s for s in scores.scores if s.family_p < SIGNIFICANT][:REFITS]
    candidates: list[Candidate] = []
    for score in promising:
        tell(f"refit with {score.point.key}")
        candidates.append(refit(study, current, unseen, entries[score.point.key], score))
    if SCATTER in study.entries and test.p < SIGNIFICANT:
        tell("refit with scatter of the cycles' amplitudes")
        candidates += [c for c in (scattered(study, current, unseen, scales.centre),) if c is not None]
    calls += sum(c.solution.calls for c in candidates)
    candidates.sort(key=lambda c: -c.bic)
    taken = next((c for c in candidates if acceptable(c, study)), None)
    rivals = tuple(
        c for c in candidates
        if taken is not None and c.id != taken.id and taken.bic - c.bic < RIVAL and acceptable(c, study)
    )  # fmt: skip
    return Step(test=test, scan=scores, candidates=tuple(candidates), taken=taken, rivals=rivals), calls


def acceptable(found: Candidate, study: Study) -> bool:
    """Whether a candidate gains on fitted runs after its parameters are paid for, and on unseen ones."""
    return found.bic > 2.0 and (not study.unseen or found.evidence > 2.0)


def _rebased(study: Study, before: Solution, winner: Candidate) -> Solution | None:
    """Refit the model without the winner from the winner's optimum; return it where it beats ``before``."""
    again = without(study, winner.solution, winner.key)
    return again if again.log_likelihood > before.log_likelihood + STUCK / 2 else None


def _backward(study: Study, full: Solution, unseen: Prediction) -> tuple[Solution, Prediction, dict[str, float]]:
    """Drop effects that the others made unnecessary; return the evidence of each that stays."""
    evidence: dict[str, float] = {}
    for key in full.keys:
        less = without(study, full, key)
        predicted = predict(study, less)
        extra = 1 if key == SCATTER else len(next(e for e in full.effects if e.key == key).parameters)
        judged = Candidate(
            key=key, solution=full, prediction=unseen, evidence=2.0 * (unseen.score - predicted.score),
            bic=2.0 * (full.log_likelihood - less.log_likelihood) - extra * _log_rows(study),
        )  # fmt: skip
        if len(full.keys) > 1 and not acceptable(judged, study):
            return _backward(study, less, predicted)
        evidence[key] = judged.evidence if study.unseen else judged.bic
    return full, unseen, evidence


def _log_rows(study: Study) -> float:
    return math.log(max(study.rows, 2))


def _rivals(steps: list[Step], final: Solution) -> tuple[Candidate, ...]:
    """Rivals of the effects that stayed."""
    stayed = [s for s in steps if s.taken is not None and s.taken.id in final.ids]
    return tuple(r for s in stayed for r in s.rivals if r.id not in final.ids)
