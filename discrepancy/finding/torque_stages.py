"""Run all stages of the search on a torque: `TorqueStudy` in, `TorqueFinding` out, with its FMU.

1. Search for missing effects among those that can be read from motion to torque.
2. Compare the RMS of the residual torque before and after, on fitted and on held-out rows.
3. Localise the residual torque of the nominal model.
4. Where a controller was recorded, refit both models and the rivals through it (`torque.closed_loop`).
5. Doubt effects that leave the rigid body no sense (`finding.soundness`).
6. Build the FMU with the named effects.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from haptid.discrepancy.detect.localise import Map, maps, regions
from haptid.discrepancy.finding.accuracy import Origin, of_torque_fit
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.soundness import judge_soundness
from haptid.discrepancy.finding.torque_finding import Remaining, TorqueFinding
from haptid.discrepancy.finding.torque_json import effect_json, final_values, gaps_json
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.closed_loop import ClosedLoop, refit_through_controller
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque.readable import readable
from haptid.discrepancy.torque.repeatable import black_box_rms, floor_of
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.certain import find_doubted
from haptid.discrepancy.torque_search.rivals import Rival
from haptid.discrepancy.torque_search.search import TorqueSearch, search_torque
from haptid.fmu_build.accuracy.accuracy import Accuracy
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.provenance import Provenance
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.identification.simulators.slow_rows import Mask, rests, turns
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.support.linear_algebra import rms
from haptid.support.listener import Progress
from haptid.support.processes.threads import on_one_thread


@on_one_thread
def find_torque(  # noqa: PLR0913 # one argument an option
    study: TorqueStudy,
    catalogue: Mapping[str, Effect],
    out: Path,
    *,
    kind: Kind,
    seed: int,
    starts: int,
    tell: Progress,
    origin: Origin | None = None,
    known_free_rms: float | None = None,
) -> TorqueFinding:
    """Run all stages of the search on the torque of one joint.

    Parameters
    ----------
    study
        Study of the joint.
    catalogue
        Catalogue effects by key, in multiples of the joint's scales.
    out
        Folder below which FMUs are written.
    kind
        Kind of the FMU.
    seed
        Seed of the starts and of the bags.
    starts
        Number of starts of the nominal fit.
    tell
        Told of each step.
    origin
        What the search is run on, for the FMU; None for runs of no campaign.
    known_free_rms
        RMS error of the position of unseen runs in free simulation [rad], or [m], with the identified model; None where
        there is none.

    Returns
    -------
    TorqueFinding
        Verdict, FMU, RMS before and after, and the regions of the residual.

    Raises
    ------
    NumericalError
        If no start of the nominal fit gives a finite torque.
    InputError
        Where the reference run of the rebuilt FMU gives no finite numbers.
    """
    began = time.perf_counter()
    known = readable(catalogue, study.base, prismatic=study.prismatic)
    # Where no position is passed again in the same direction, an effect over time cannot be told from one over
    # position.
    if not study.repeats:
        known = {key: effect for key, effect in known.items() if effect.lives_in != "time"}
    found = search_torque(study, known, starts=starts, seed=seed, tell=tell)
    base, final = found.base, found.final
    energy = _maps(study, found)
    tell("closed loop")
    nominal_loop, final_loop = (refit_through_controller(model) for model in (base, final))
    found = replace(found, rivals=_rivals_in_position(found, final_loop))
    tell("free simulation")
    soundness = judge_soundness(base, final, nominal_loop, final_loop, known_free_rms)
    finding = TorqueFinding(
        search=found,
        gaps=_measure_gaps(base, final),
        regions=regions(energy),
        maps=energy,
        remaining=_remaining(found),
        floor=floor_of(final),
        black_box=black_box_rms(base),
        nominal_loop=nominal_loop,
        final_loop=final_loop,
        fmu=None,
        considered=len(known),
        wall_s=time.perf_counter() - began,
        doubted=find_doubted(final, found.stability) | soundness.doubted,
        soundness=soundness,
    )
    # A surrogate must not reach the users' model, nor an inertia that stands for something else, nor what simulates far
    # worse than the model that they have.
    if not final.effects or finding.verdict == "unlisted" or soundness.doubted or soundness.is_outdone:
        return finding
    # Built last: the FMU carries what the stages above found.
    tell("FMU")
    effects = [effect_json(finding, e) for e in final.effects]
    accuracy = of_torque_fit(final, final_loop, effects, gaps_json(finding), origin or Origin(), seed)
    # The measured torque of a joint that turns is the reading of these runs.
    largest = 0.0 if study.prismatic else finding.largest_torque
    fmu = _build_fmu(found, final_values(found, final_loop), out / "fmu", kind, accuracy, largest)
    return replace(finding, fmu=fmu, wall_s=time.perf_counter() - began)


def _rivals_in_position(found: TorqueSearch, loop: ClosedLoop | None) -> tuple[Rival, ...]:
    """Return the rivals that the position tells no better from the named effects than the torque does.

    Through a recorded controller both residuals exist, and what a wide filter takes out of the torque stays in the
    position.
    """
    if loop is None:
        return found.rivals
    left = []
    for rival in found.rivals:
        other = refit_through_controller(rival.model)
        if other is None or not loop.is_better_than(other):
            left.append(rival)
    return tuple(left)


def _measure_gaps(base: TorqueFit, final: TorqueFit) -> dict[str, Gap]:
    """Return the gaps of rows away from reversals by group; ``sealed`` are runs that took part in no choice."""
    noise, sealed = final.noise, base.study.sealed
    gaps = {
        "fit": Gap(before=rms(base.fitted_away), after=rms(final.fitted_away), noise=noise),
        "validate": Gap(before=rms(base.unseen_away), after=rms(final.unseen_away), noise=noise),
    }
    if sealed:
        rows = _away_of_sealed(base.study)
        before, after = (
            rms(np.concatenate([model.compute_missed(run)[away] for run, away in zip(sealed, rows, strict=True)]))
            for model in (base, final)
        )
        gaps["sealed"] = Gap(before=before, after=after, noise=noise)
    return gaps


def _away_of_sealed(study: TorqueStudy) -> list[Mask]:
    """Return the rows of the sealed runs away from rests and reversals, or all where these are none or none counts."""
    every = [np.ones(run.t.size, dtype=bool) for run in study.sealed]
    away = [~(rests(run) | turns(run)) for run in study.sealed] if study.turning else every
    return away if any(rows.any() for rows in away) else every


def _maps(study: TorqueStudy, found: TorqueSearch) -> tuple[Map, ...]:
    """Return the residual energy of the nominal model, in squares of the torque's noise.

    The residual torque is added to the measured position as if it were a reading, so that `localise.maps` can sort it.
    """
    turned, simulated = [], []
    for run, r, moving in zip(study.runs, found.base.residual, study.moving, strict=True):
        q = run.u
        scale = run.sensor_std
        counted = np.where(moving, r, 0.0)  # at rest friction takes any torque up to its level
        turned.append(run.but(u=run.y, y=q + counted[:, None], noise=scale, resolution=np.zeros(1)))
        simulated.append(q[:, 0])
    return maps(turned, simulated)


def _remaining(found: TorqueSearch) -> Remaining:
    q = np.concatenate([run.u[:, 0] for run in found.study.runs])
    v = np.concatenate([measured_motion(run)[:, 1] for run in found.study.runs])
    moving = np.concatenate(found.study.moving)
    q, v, r = q[moving], v[moving], np.concatenate(found.final.residual)[moving]
    bins = THRESHOLDS.finding.position_bins
    edges = np.linspace(q.min(), q.max(), bins + 1)
    place = np.clip(np.digitize(q, edges) - 1, 0, bins - 1)

    def mean(rows: Any) -> Array:
        count = np.maximum(np.bincount(place[rows], minlength=bins), 1)
        return np.asarray(np.bincount(place[rows], r[rows], minlength=bins) / count)

    # Correlated rows count once per correlation time, and half of them in each direction.
    each = np.maximum(np.bincount(place, minlength=bins) / (2.0 * found.final.correlation_time), 1.0)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return Remaining(position=middle, up=mean(v > 0), down=mean(v < 0), std=rms(r) / np.sqrt(each))


def _build_fmu(
    found: TorqueSearch, values: Mapping[str, float], out: Path, kind: Kind, accuracy: Accuracy, largest_torque: float
) -> Fmu:
    final, study = found.final, found.study
    std, source = final.std, "fitted to the torque of measured motion"
    provenance = {id: Provenance(source=source, std=error, status="identified") for id, error in std.items() if error}
    name = "_".join((f"joint{study.joint}", *(e.id for e in final.effects)))
    equations = study.driven_equations(final.effects)
    path = out / f"{name}.fmu"
    return build_fmu(
        equations, path, kind=kind, values=dict(values), provenance=provenance, accuracy=accuracy,
        largest_torque=largest_torque,
    )  # fmt: skip
