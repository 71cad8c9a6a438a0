"""From a search to a verdict: nothing missing, named, ambiguous, or unlisted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from discrepancy.next_experiment import Proposal, propose
from discrepancy.refit import SCATTER, Candidate
from discrepancy.search import SIGNIFICANT, Search
from discrepancy.shape import Shape, remaining, standard_errors
from discrepancy.study import Study

Verdict = Literal["nothing_missing", "named", "ambiguous", "unlisted"]
LEFT = 1e-4
"""p of the last omnibus test below which the winner leaves something unexplained."""
GAP = 1.1
"""RMS over the noise on unseen runs above which a gap is left."""
LARGE = 3.0
"""Standard errors by which an amplitude must differ from zero."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedEffect:
    """An effect of the verdict: its parameters as (value, std, unit) and the evidence for it."""

    id: str
    key: str
    title: str
    formula: str
    parameters: dict[str, tuple[float, float, str]]
    evidence: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """The verdict and what it rests on."""

    verdict: Verdict
    effects: tuple[NamedEffect, ...]
    alternatives: tuple[Candidate, ...]
    next_experiment: Proposal | None
    shape: Shape | None
    sentence: str


def judge(study: Study, found: Search) -> Judgement:
    """Turn a search into a verdict with one sentence that an engineer reads first."""
    effects = named_effects(study, found)
    verdict = _verdict(study, found, effects)
    rivals = found.rivals if verdict == "ambiguous" else ()
    considered = [c for s in found.steps for c in s.candidates if c.id not in found.final.ids]
    return Judgement(
        verdict=verdict,
        effects=effects,
        alternatives=rivals or tuple(considered[:3]),
        next_experiment=propose(study, found.final, rivals) if rivals else None,
        shape=remaining(study, found.final) if verdict == "unlisted" else None,
        sentence=_sentence(verdict, effects, rivals),
    )


def _verdict(study: Study, found: Search, effects: tuple[NamedEffect, ...]) -> Verdict:
    sigma = [run.sensor_std[0] * found.final.noise.colour.sigma for run in study.unseen]
    gap = max((r / s for r, s in zip(found.final_prediction.rms, sigma, strict=True)), default=0.0)
    unexplained = found.last_test.p < LEFT and (gap > GAP or not study.unseen)
    if unexplained and found.final.noise.scatter == 0.0:
        return "unlisted"
    if not effects:
        return "nothing_missing"
    if not all(_large(e) for e in effects):
        return "unlisted" if found.steps[0].test.p < SIGNIFICANT else "nothing_missing"
    return "ambiguous" if found.rivals else "named"


def _large(effect: NamedEffect) -> bool:
    value, std, _ = next(iter(effect.parameters.values()))
    return abs(value) >= LARGE * std


def named_effects(study: Study, found: Search) -> tuple[NamedEffect, ...]:
    """Return the effects of the final model with their parameters."""
    std = dict(zip([p.id for p in found.final.equations.parameters], standard_errors(found.final), strict=True))
    values = found.final.values
    named = [
        NamedEffect(
            id=e.id, key=e.key, title=e.title, formula=e.formula,
            parameters={x.id: (values[x.id], float(std[x.id]), x.unit) for x in e.parameters if not x.fixed},
            evidence=found.evidence.get(e.key, 0.0),
        )
        for e in found.final.effects
    ]  # fmt: skip
    if found.final.noise.scatter > 0:
        entry = study.entries[SCATTER]
        cycles = sum(study.cycles()[run.file].count for run in study.fitted)
        s = found.final.noise.scatter
        named.append(
            NamedEffect(
                id=SCATTER, key=SCATTER, title=entry.title, formula=entry.formula,
                parameters={SCATTER: (s, float(s / np.sqrt(2 * max(cycles - 1, 1))), "1")},
                evidence=found.evidence.get(SCATTER, 0.0),
            )
        )  # fmt: skip
    return tuple(named)


def _sentence(verdict: Verdict, effects: tuple[NamedEffect, ...], rivals: tuple[Candidate, ...]) -> str:
    names = " and ".join(f"{e.id} ({e.title})" for e in effects)
    if verdict == "nothing_missing":
        return "Nothing is missing: what is left between simulation and measurement is noise."
    if verdict == "named":
        return f"Missing in the model: {names}."
    if verdict == "ambiguous":
        others = ", ".join(r.id for r in rivals)
        return f"Missing in the model: {names}, or else {others}; these runs cannot tell, the proposed run would."
    tried = f" The best name of the catalogue, {names}, leaves a gap and is only a surrogate." if effects else ""
    return f"Something is missing that no entry of the catalogue explains.{tried}"
