"""Run all stages of the search for one study: `Study` in, `Finding` out, as JSON and FMU.

1. Search for missing effects, and turn the result into a verdict.
2. Rebuild the FMU with the named effects, and refit it.
3. Compare the RMS of measured − simulated before and after, on fitted and on held-out runs.
4. Localise the residual of the nominal model in the joint where it is largest.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from haptid.discrepancy.candidate.candidate import Candidate
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.localise import Map, Region, excess, maps, regions
from haptid.discrepancy.finding.accuracy import Origin, of_refit
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.rebuilt_fmu import Rebuilt, rebuild, refit
from haptid.discrepancy.fit.held_out import Prediction, predict
from haptid.discrepancy.fit.stability import Stretches, stability_of
from haptid.discrepancy.fit.standard_errors import of_curvature
from haptid.discrepancy.search.search import search
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.study.channels import channels
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.verdict import Judgement, NamedEffect, judge
from haptid.fmu_build.building.packaging import Kind
from haptid.fmu_build.exchange.discrepancy_json import VERDICTS
from haptid.identification.result.fit import Fit
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.support.linear_algebra import rms
from haptid.support.listener import Progress
from haptid.support.processes.threads import on_one_thread

SCHEMA = "discrepancy/1"
"""Name and version of the JSON's schema."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Readings of one joint in one run, with the simulations before and after.

    Parameters
    ----------
    run
        Run of one joint.
    before, after
        Simulated readings of the nominal and of the best model [rad], shape (n_t,).
    """

    run: Run
    before: Array
    after: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Result for one joint, or for several that move together, as page and JSON show it.

    Parameters
    ----------
    joints
        Numbers of the joints.
    search
        Result of the search.
    judgement
        Verdict with its grounds.
    rebuilt
        FMU with the named effects, or None.
    gaps
        RMS before and after by ``fit``, ``validate`` and ``sealed``, as far as there are such runs.
    curves
        Runs with their simulations, held-out ones where there are any.
    maps
        Residual energy of the nominal model in the joint ``gap_joint``.
    gap_joint
        Joint with the largest residual energy.
    regions
        Regions that hold most of that energy.
    stability
        Share of bags in which an effect keeps its name, by its key (`discrepancy.fit.stability`).
    wall_s
        Wall time of all stages [s].
    errors
        Standard errors of the best model's parameters by id, from the curvature, each in its unit.
    """

    joints: tuple[int, ...]
    search: Search
    judgement: Judgement
    rebuilt: Rebuilt | None
    gaps: dict[str, Gap]
    curves: tuple[Curve, ...]
    maps: tuple[Map, ...]
    gap_joint: int
    regions: tuple[Region, ...]
    stability: Mapping[str, float]
    wall_s: float
    errors: Mapping[str, float] = field(default_factory=dict)

    @property
    def closes_half(self) -> bool:
        """Whether named effects, or a friction law, close at least half of the gap in runs that no fit saw."""
        named = self.judgement.verdict in VERDICTS
        closed = self.gaps["validate" if "validate" in self.gaps else "fit"].closed_beside_scatter
        return named and closed is not None and closed >= THRESHOLDS.finding.least_share_closed_in_position


@on_one_thread
def find(
    study: Study,
    out: Path,
    *,
    kind: Kind,
    seed: int,
    starts: int,
    tell: Progress,
    origin: Origin | None = None,
) -> Finding:
    """Run all stages of one study.

    Parameters
    ----------
    study
        Study of one joint, or of several that move together.
    out
        Folder below which FMUs are written.
    kind
        Kind of the FMU.
    seed
        Seed of the starts.
    starts
        Number of starts of the nominal fit.
    tell
        Told of each step.
    origin
        What the search is run on, for the FMU; None for runs of no campaign.

    Returns
    -------
    Finding
        Verdict, FMU, RMS before and after, and the regions of the residual.

    Raises
    ------
    NumericalError
        If no start of the nominal fit gives a finite simulation.
    InputError
        Where the reference run of the rebuilt FMU gives no finite numbers.
    """
    began = time.perf_counter()
    found = search(study, seed=seed, starts=starts, tell=tell)
    study = found.study
    tell("verdict")
    judgement = judge(study, found, tell)
    refitted = None
    best, plain = found.best.candidate, found.before.candidate
    # A surrogate must not reach the users' model, so no FMU is built for an unlisted verdict.
    if (best.solution.effects or found.law) and judgement.verdict in VERDICTS:
        tell("FMU and refit")
        refitted = refit(study, found, best.solution.effects, kind)
        if judgement.verdict == "partly_named":
            judgement = judgement.beside(refitted)
    groups = _predict_groups(found, plain, best)
    _, before_fit, _ = groups["fit"]
    shown, before, after = groups.get("validate", groups["fit"])
    gaps = {}
    for name, (runs, without, with_effects) in groups.items():
        gaps[name] = _gap(runs, without, with_effects, refitted, _beside(study, found, runs, with_effects))
    joint, energy = most_missed((*study.fitted, *study.unseen), (*before_fit.y, *plain.prediction.y))
    finding = Finding(
        joints=study.fitted[0].free_joints,
        search=found,
        judgement=judgement,
        rebuilt=None,
        gaps=gaps,
        curves=curves_of(shown, before.y, after.y),
        maps=energy,
        gap_joint=joint,
        regions=regions(energy) if judgement.verdict != "nothing_missing" else (),
        stability=stability_of(Stretches.of(best.solution), best.solution.effects, seed=seed),
        wall_s=time.perf_counter() - began,
        errors=dict(zip(best.solution.values, of_curvature(best.solution).tolist(), strict=True)),
    )
    if refitted is None:
        return finding
    # Built last: the FMU carries what the stages above found.
    accuracy = of_refit(refitted, _effects_json(finding), _gaps_json(finding), origin or Origin(), seed)
    law = (found.law.id,) if found.law else ()
    name = "_".join((study.name, *law, *(e.id for e in best.solution.effects)))
    rebuilt = rebuild(refitted, name, out / "fmu", kind, accuracy, max(run.largest_torque for run in study.fitted))
    return replace(finding, rebuilt=rebuilt, wall_s=time.perf_counter() - began)


def _predict_groups(
    found: Search, plain: Candidate, best: Candidate
) -> dict[str, tuple[tuple[Run, ...], Prediction, Prediction]]:
    """Predict each group of runs by the nominal and by the best model.

    Under correlated noise a fit takes slow residuals for noise and leaves them, several times what the same model needs
    to leave. The fitted runs show what least squares leave: the model as it was identified, as the refit with named
    effects is made.
    """
    study = found.study
    own_law = found.asked is None
    before = predict(study, found.base.solution if own_law else plain.solution, study.fitted)
    unchanged = own_law and not best.solution.effects and not best.solution.noise.scatters
    after = before if unchanged else predict(study, best.solution, study.fitted)
    groups = {"fit": (study.fitted, before, after)}
    if study.unseen:
        groups["validate"] = (study.unseen, plain.prediction, best.prediction)
    if study.sealed:
        before, after = (predict(study, one.solution, study.sealed) for one in (plain, best))
        groups["sealed"] = (study.sealed, before, after)
    return groups


def curves_of(runs: Sequence[Run], before: Sequence[Array], after: Sequence[Array]) -> tuple[Curve, ...]:
    """Return one curve for every joint of every run.

    Parameters
    ----------
    runs
        Runs of one or several joints.
    before, after
        Simulated readings of every run, shape (n_t, n_joints).

    Returns
    -------
    tuple of Curve
        Curves run by run, and joint by joint within a run.
    """
    return tuple(
        Curve(run=c.run, before=before[c.number][:, c.column], after=after[c.number][:, c.column])
        for c in channels(runs)
    )


def most_missed(runs: Sequence[Run], y: Sequence[Array]) -> tuple[int, tuple[Map, ...]]:
    """Return the joint with the largest residual energy, and its maps.

    Parameters
    ----------
    runs
        Runs of the same joints.
    y
        Simulated readings of every run, shape (n_t, n_joints).

    Returns
    -------
    joint, maps
        Number of the joint, and its residual energy by variable.
    """
    found = {}
    for k, joint in enumerate(runs[0].free_joints):
        own = [c for c in channels(runs) if c.column == k]
        found[joint] = maps([c.run for c in own], [y[c.number][:, k] for c in own])
    return max(found.items(), key=lambda pair: excess(pair[1]))


def _beside(study: Study, found: Search, runs: tuple[Run, ...], after: Prediction) -> tuple[float, float] | None:
    """Return the RMS of whitened residuals of nominal and best model, both under the scatter of the best."""
    noise = found.best.solution.noise
    if not noise.scatters:
        return None
    before = predict(study, found.before.solution, runs, noise=noise)
    return float(np.sqrt(before.chi2 / before.rows)), float(np.sqrt(after.chi2 / after.rows))


def _gap(
    runs: tuple[Run, ...],
    before: Prediction,
    after: Prediction,
    refitted: Fit | None,
    beside: tuple[float, float] | None,
) -> Gap:
    """Return the RMS before and after over the runs; where the model was refitted, the refit's own scores count."""
    final = list(after.rms)
    if refitted is not None:
        scores = {s.file: s.rmse_rad for s in refitted.runs}
        final = [scores.get(run.file, a) for run, a in zip(runs, after.rms, strict=True)]
    noise = rms([run.sensor_std for run in runs])
    return Gap(before=rms(before.rms), after=rms(final), noise=noise, beside=beside)


def as_json(finding: Finding, *, measured: bool, seed: int) -> dict[str, Any]:
    """Return the content of ``discrepancy/joint<j>.json``.

    Parameters
    ----------
    finding
        Finding of one study.
    measured
        Whether the runs were measured.
    seed
        Seed of the search.

    Returns
    -------
    dict
        Fields of INTERFACES.
    """
    judgement, rebuilt = finding.judgement, finding.rebuilt
    shape, proposal = judgement.shape, judgement.next_experiment
    return {
        "schema": SCHEMA,
        "joint": finding.joints[0] if len(finding.joints) == 1 else None,
        "joints": list(finding.joints),
        "measured": measured,
        "seed": seed,
        "verdict": judgement.verdict,
        "sentence": judgement.sentence,
        "effects": _effects_json(finding),
        "alternatives": [_alternative_json(t, finding.search.before) for t in judgement.alternatives],
        "next_experiment": proposal.as_json() if proposal else None,
        "where": [r.as_json() | {"joint": finding.gap_joint} for r in finding.regions],
        "gap": _gaps_json(finding),
        "gap_unit": unit_for("rad", finding.search.study.fitted[0].prismatic),
        "unnamed_shape": shape.as_json() if shape else None,
        "fmu": f"fmu/{rebuilt.fmu.path.name}" if rebuilt else None,
        "refit": dict(rebuilt.fit.values) if rebuilt else None,
        "omnibus_p": {"before": finding.search.before.left.p, "after": finding.search.best.left.p},
        "smallest_detectable": [d.as_json() for d in finding.search.scan.detectable],
        "base_starts_at_best": [finding.search.base.reached, len(finding.search.base.costs)],
        "simulations": finding.search.simulations,
        "rows_merged": finding.search.study.rows_merged,
        "wall_s": finding.wall_s,
    }


def _effects_json(finding: Finding) -> list[dict[str, Any]]:
    judgement = finding.judgement
    if judgement.verdict == "nothing_missing":
        return []
    return [_effect_json(e, finding.stability.get(e.key)) for e in judgement.effects]


def _gaps_json(finding: Finding) -> dict[str, Any]:
    return {"validate": None, "sealed": None, **{name: gap.as_json() for name, gap in finding.gaps.items()}}


def _alternative_json(trial: Trial, plain: Trial) -> dict[str, Any]:
    """Return an alternative with its evidence and criterion over the nominal model."""
    candidate, before = trial.candidate, plain.candidate
    return {
        "ids": list(candidate.ids),
        "evidence": 2.0 * (candidate.prediction.score - before.prediction.score),
        "criterion": candidate.criterion - before.criterion,
        "bic": before.bic - candidate.bic,
    }


def _effect_json(effect: NamedEffect, stability: float | None) -> dict[str, Any]:
    return {
        "id": effect.id,
        "variant": effect.key.partition(":")[2] or None,
        "parameters": {id: estimate.as_json() for id, estimate in effect.parameters.items()},
        "evidence": effect.evidence,
        "stability": stability,
    }
