"""Run all stages of the search on a torque: `TorqueStudy` in, `TorqueFinding` out, as JSON and FMU.

1. Search for missing effects among those that can be read from motion to torque.
2. Compare the RMS of the residual torque before and after, on fitted and on held-out rows.
3. Localise the residual torque of the nominal model.
4. Where a controller was recorded, refit both models and the rivals through it (`torque.closed_loop`).
5. Build the FMU with the named effects.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from haptid.discrepancy.detect.localise import Map, Region, maps, regions
from haptid.discrepancy.finding.accuracy import Origin, of_torque_fit
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.closed_loop import ClosedLoop, refit_through_controller
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque.readable import readable
from haptid.discrepancy.torque.repeatable import black_box_rms, floor_of
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.candidate import compare_candidates
from haptid.discrepancy.torque_search.certain import compute_stability, find_doubted
from haptid.discrepancy.torque_search.rivals import Rival
from haptid.discrepancy.torque_search.search import TorqueSearch, search_torque
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.fmu_build.accuracy.accuracy import Accuracy
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.provenance import Provenance
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.model.effects.effect import Effect, id_of
from haptid.support.linear_algebra import rms
from haptid.support.listener import Progress
from haptid.support.numbers import with_prefix
from haptid.support.processes.threads import on_one_thread


@dataclass(frozen=True, slots=True, kw_only=True)
class Remaining:
    """Mean residual torque over position, by direction.

    Parameters
    ----------
    position
        Middles of the bins [rad], shape (n_bins,).
    up, down
        Mean residual torque while the position grows and falls [N m], shape (n_bins,).
    std
        Standard error of these means [N m], shape (n_bins,).
    """

    position: Array
    up: Array
    down: Array
    std: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueFinding:
    """Result for one joint whose torque was scored, as page and JSON show it.

    Parameters
    ----------
    search
        Result of the search.
    gaps
        RMS before and after by ``fit``, ``validate`` and, where there are such runs, ``sealed``.
    regions, maps
        Residual energy of the nominal model, and the regions that hold most of it.
    remaining
        Mean residual torque of the final model over position.
    floor
        RMS of the final model's residual that does not repeat [N m]; None where no position is passed again.
    black_box
        RMS that a table over position and speed leaves of that residual on held-out rows [N m]; None without such rows.
    nominal_loop, final_loop
        Both models refitted and simulated through the recorded controller; None without one.
    fmu
        FMU with the effects of the final model, or None.
    considered
        Number of catalogue effects that were searched.
    stability
        Share of bags of stretches in which an effect keeps its name, by its key.
    wall_s
        Wall time of all stages [s].
    doubted
        Keys of the effects whose names are not certain (`torque_search.certain`).
    """

    search: TorqueSearch
    gaps: dict[str, Gap]
    regions: tuple[Region, ...]
    maps: tuple[Map, ...]
    remaining: Remaining
    floor: float | None
    black_box: float | None
    nominal_loop: ClosedLoop | None
    final_loop: ClosedLoop | None
    fmu: Fmu | None
    considered: int
    stability: Mapping[str, float]
    wall_s: float
    doubted: frozenset[str] = frozenset()

    @property
    def left(self) -> float:
        """RMS of the final model's residual on the rows that name effects [N m], those away from reversals.

        The larger one of fitted and held-out runs: the floor is that of all, and one run that holds what the others
        lack raises it.
        """
        final = self.search.final
        rows = ((final.fitted, final.study.fitted_rows), (final.unseen, final.study.unseen_rows))
        return max(rms(residual[final.study.names(own)]) for residual, own in rows)

    @property
    def verdict(self) -> str:
        """Verdict of INTERFACES.

        Names stand alone where they leave no more than does not repeat, on fitted and on held-out runs, or close nearly
        all that the best black box closes and most of what repeats; else they name a part. Where the runs do not tell
        one of them from another effect, they are ambiguous. Where some names are doubted, the others name a part; names
        that are all doubted are no finding, nor are those with which the recorded controller no longer holds the
        simulation near the motion.
        """
        told_apart = "ambiguous" if self.search.rivals else "named"
        if self.doubted:
            told_apart = "partly_named"
        gap, names = self.gaps["validate"], self.search.final.effects
        if self.all_doubted:
            return "unlisted"
        aim = max(gap.noise, self.floor or 0.0)
        if self.left <= THRESHOLDS.finding.largest_rms_over_torque_noise * aim and not self.worsens_position:
            return told_apart if names else "nothing_missing"
        if not names or self.worsens_position:
            return "unlisted"
        closed, possible = self.shares
        if possible is None or possible <= 0:
            return "partly_named"
        enough = max(
            THRESHOLDS.torque.least_share_of_black_box * possible,
            THRESHOLDS.torque.least_share_of_repeated * self.repeated_share,
        )
        return told_apart if closed >= enough else "partly_named"

    @property
    def all_doubted(self) -> bool:
        """Whether there are names, and none is certain."""
        names = self.search.final.effects
        return bool(self.doubted) and all(e.key in self.doubted for e in names)

    @property
    def worsens_position(self) -> bool:
        """Whether the position through the recorded controller is worse with the named effects, on runs of any use."""
        before, after = self.nominal_loop, self.final_loop
        if before is None or after is None or not self.search.final.effects:
            return False
        most = THRESHOLDS.torque.largest_rms_through_controller
        return any(after.rms[use] > most * before.rms[use] for use in after.rms)

    @property
    def repeated_share(self) -> float:
        """Share of the held-out residual's energy that repeats; where no position is passed again, all may."""
        before = max(self.gaps["validate"].before, np.finfo(float).tiny)
        return max(1.0 - ((self.floor or 0.0) / before) ** 2, 0.0)

    @property
    def shares(self) -> tuple[float, float | None]:
        """Shares of the held-out residual's energy that the named effects and the best black box close."""
        gap = self.gaps["validate"]
        energy = max(gap.before, np.finfo(float).tiny) ** 2
        box = None if self.black_box is None else 1.0 - self.black_box**2 / energy
        return 1.0 - gap.after**2 / energy, box

    @property
    def sentence(self) -> str:
        """Sentence that an engineer reads first."""
        effects = self.search.final.effects
        names = _write_names([e for e in effects if self.worsens_position or e.key not in self.doubted])
        if self.verdict == "nothing_missing":
            return "Nothing is missing: what is left of the torque does not repeat."
        if self.verdict in ("named", "ambiguous"):
            return f"Missing in the model: {names}.{self._told_of_rivals} {self._measured}"
        if self.verdict == "unlisted":
            like = (
                f" It is like {names}, but with it the position strays further from the measured one." if names else ""
            )
            if self.all_doubted and not self.worsens_position:
                like = f" It is like {_write_names(effects)}, which the runs do not hold."
            return f"Something is missing that no entry of the catalogue explains.{like} {self._measured}"
        doubted = _write_names([e for e in effects if e.key in self.doubted])
        unsure = f" Not certain: {doubted}." if doubted else ""
        return f"Missing in the model: {names}; they explain a part.{unsure}{self._told_of_rivals} {self._measured}"

    @property
    def _told_of_rivals(self) -> str:
        """Sentence on what could as well stand in the place of a named effect; empty where there is nothing."""
        places: dict[str, list[str]] = {}
        for rival in self.search.rivals:
            places.setdefault(id_of(rival.replaces), []).append(id_of(rival.key))
        told = [
            f"{' or '.join(dict.fromkeys(others))} could as well stand for {name}" for name, others in places.items()
        ]
        return f" The runs cannot tell: {'; '.join(told)}." if told else ""

    @property
    def _measured(self) -> str:
        """Sentences on what is left, what could be closed, and what does not repeat."""
        gap, unit = self.gaps["validate"], unit_for("N m", [self.search.study.prismatic])
        closed, possible = self.shares
        told = [f"On held-out rows the torque's RMS error falls from {gap.before:.3g} to {gap.after:.3g} {unit}"]
        if possible is not None:
            told.append(
                f"names close {100 * max(closed, 0.0):.0f} % of its energy, the best black box of position and speed "
                f"{100 * max(possible, 0.0):.0f} %"
            )
        if self.floor is None:
            told.append("the floor is unknown: one more sweep over the same positions would tell what repeats")
        else:
            told.append(f"{self.floor:.3g} {unit} do not repeat")
        return "; ".join(told) + "." + self._told_of_delay + self._told_of_loop

    @property
    def _told_of_delay(self) -> str:
        """Sentence on the delay that the torque has behind it; empty without one."""
        delay = self.search.study.delay
        if not delay:
            return ""
        late = "after" if delay > 0 else "before"
        return f" The torque acts {with_prefix(abs(delay), 's', 2)} {late} it is recorded, which no name stands for."

    @property
    def _told_of_loop(self) -> str:
        """Sentence on the position through the recorded controller; empty without one or without unseen runs."""
        before, after = self.nominal_loop, self.final_loop
        if before is None or after is None or "validate" not in after.mean_absolute:
            return ""
        unit = unit_for("rad", [self.search.study.prismatic])
        was, now = (loop.mean_absolute["validate"] for loop in (before, after))
        errors = f"{was:.3g} {unit} before and {now:.3g} {unit} after"
        return (
            f" Simulated through the recorded controller, the position of unseen runs is off by {errors}, on average."
        )


@on_one_thread
def find_torque(  # noqa: PLR0913 # one argument an option
    study: TorqueStudy,
    entries: Mapping[str, Effect],
    out: Path,
    *,
    kind: Kind,
    seed: int,
    starts: int,
    tell: Progress,
    origin: Origin | None = None,
) -> TorqueFinding:
    """Run all stages of the search on the torque of one joint.

    Parameters
    ----------
    study
        Study of the joint.
    entries
        Catalogue effects by key, in multiples of the joint's scales.
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
    known = readable(entries, study.base, prismatic=study.prismatic)
    # Where no position is passed again in the same direction, an effect over time cannot be told from one over
    # position.
    if not study.repeats:
        known = {key: effect for key, effect in known.items() if effect.lives_in != "time"}
    found = search_torque(study, known, starts=starts, seed=seed, tell=tell)
    noise = rms([run.sensor_std[0] for run in study.runs])
    base, final = found.base, found.final
    energy = _maps(study, found)
    tell("closed loop")
    nominal_loop, final_loop = (refit_through_controller(model) for model in (base, final))
    found = replace(found, rivals=_rivals_in_position(found, final_loop))
    stability = compute_stability(final, seed=seed)
    finding = TorqueFinding(
        search=found,
        gaps={
            "fit": Gap(before=rms(base.fitted), after=rms(final.fitted), noise=noise),
            "validate": Gap(before=rms(base.unseen), after=rms(final.unseen), noise=noise),
            **_sealed_gap(base, final, noise),
        },
        regions=regions(energy),
        maps=energy,
        remaining=_remaining(found),
        floor=floor_of(final),
        black_box=black_box_rms(base),
        nominal_loop=nominal_loop,
        final_loop=final_loop,
        fmu=None,
        considered=len(known),
        stability=stability,
        wall_s=time.perf_counter() - began,
        doubted=find_doubted(final, stability),
    )
    # A surrogate must not reach the users' model.
    if not final.effects or finding.verdict == "unlisted":
        return finding
    # Built last: the FMU carries what the stages above found.
    tell("FMU")
    effects = [_effect_json(finding, e) for e in final.effects]
    accuracy = of_torque_fit(final, final_loop, effects, _gaps_json(finding), origin or Origin(), seed)
    fmu = _build_fmu(found, _values(found, final_loop), out / "fmu", kind, accuracy)
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


def _sealed_gap(base: TorqueFit, final: TorqueFit, noise: float) -> dict[str, Gap]:
    """Return the gap of the runs that took part in no choice; nothing where there are none."""
    runs = base.study.sealed
    if not runs:
        return {}
    before, after = (rms(np.concatenate([model.compute_missed(run) for run in runs])) for model in (base, final))
    return {"sealed": Gap(before=before, after=after, noise=noise)}


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


def _write_names(effects: Sequence[Effect]) -> str:
    return " and ".join(f"{e.id} ({e.title})" for e in effects)


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


def _build_fmu(found: TorqueSearch, values: Mapping[str, float], out: Path, kind: Kind, accuracy: Accuracy) -> Fmu:
    final, study = found.final, found.study
    std, source = final.std, "fitted to the torque of measured motion"
    provenance = {id: Provenance(source=source, std=error, status="identified") for id, error in std.items() if error}
    name = "_".join((f"joint{study.joint}", *(e.id for e in final.effects)))
    equations = study.driven_equations(final.effects)
    path = out / f"{name}.fmu"
    return build_fmu(equations, path, kind=kind, values=dict(values), provenance=provenance, accuracy=accuracy)


def _values(found: TorqueSearch, loop: ClosedLoop | None) -> dict[str, float]:
    """Return the parameters of the final model by id, with those of the drive: refitted where there is a controller."""
    if loop is not None:
        return dict(loop.values)
    drive = found.study.drive
    return found.final.values if drive is None else {**found.final.values, **drive.values}


def torque_json(finding: TorqueFinding, *, measured: bool, seed: int) -> dict[str, Any]:
    """Return the content of ``discrepancy/joint<j>.json`` for a joint whose torque was scored.

    Parameters
    ----------
    finding
        Finding of one joint.
    measured
        Whether the runs were measured.
    seed
        Seed of the search.

    Returns
    -------
    dict
        Fields of INTERFACES; RMS are in N m, as the field ``scored`` says.
    """
    found, left = finding.search, finding.remaining
    return {
        "schema": "discrepancy/1",
        "joint": found.study.joint,
        "measured": measured,
        "seed": seed,
        "scored": "torque",
        "torque_delay_s": found.study.delay,
        "verdict": finding.verdict,
        "sentence": finding.sentence,
        "effects": [_effect_json(finding, e) for e in found.final.effects],
        "alternatives": _alternatives_json(found),
        "next_experiment": None,
        "where": [r.as_json() for r in finding.regions],
        "gap": _gaps_json(finding),
        "gap_unit": unit_for("N m", [found.study.prismatic]),
        "residual": "torque",
        "unnamed_shape": {
            "variable": "position_rad",
            "knots": left.position.tolist(),
            "torque_up_Nm": left.up.tolist(),
            "torque_down_Nm": left.down.tolist(),
            "std_Nm": left.std.tolist(),
        }
        if finding.verdict in ("unlisted", "partly_named")
        else None,
        "fmu": f"fmu/{finding.fmu.path.name}" if finding.fmu else None,
        "closed_loop": None
        if finding.nominal_loop is None or finding.final_loop is None
        else {"before": finding.nominal_loop.as_json(), "after": finding.final_loop.as_json()},
        "refit": _values(found, finding.final_loop),
        "rounds": len(found.steps),
        "refitted": sum(len(step.candidates) for step in found.steps),
        "simulations": found.simulations,
        "wall_s": finding.wall_s,
    }


def _gaps_json(finding: TorqueFinding) -> dict[str, Any]:
    """Return RMS torques before and after, with what does not repeat and what the best table leaves [N m]."""
    gaps: dict[str, Any] = {"sealed": None}
    for name, gap in finding.gaps.items():
        gaps[name] = {
            "before": gap.before,
            "after": gap.after,
            "noise": gap.noise,
            "closed": gap.closed,
            "floor": finding.floor,
            "black_box": finding.black_box if name == "validate" else None,
        }
    return gaps


def _alternatives_json(found: TorqueSearch) -> list[dict[str, Any]]:
    """Return the rivals; where the runs tell all names apart, the next best candidates of the rounds."""
    if found.rivals:
        over = [(rival, compare_candidates(rival.key, found.base, rival.model)) for rival in found.rivals]
        return [
            {"ids": [e.id for e in rival.model.effects], "evidence": gain.evidence, "bic": gain.bic}
            for rival, gain in over
        ]
    others = [c for step in found.steps for c in step.candidates if c is not step.taken]
    listed = others[: THRESHOLDS.verdict.most_alternatives_listed]
    return [{"ids": [id_of(c.key)], "evidence": c.evidence, "bic": c.bic} for c in listed]


def _effect_json(finding: TorqueFinding, effect: Effect) -> dict[str, Any]:
    final = finding.search.final
    std = final.std
    evidence = next(s.taken.evidence for s in finding.search.steps if s.taken is not None and s.taken.key == effect.key)
    return {
        "id": effect.id,
        "variant": effect.variant or None,
        "parameters": {
            x.id: Estimate.of_parameter(x, final.values[x.id], std[x.id]).as_json()
            for x in effect.parameters
            if not x.fixed
        },
        "evidence": evidence,
        "stability": finding.stability.get(effect.key),
        "certain": effect.key not in finding.doubted,
    }
