"""Take out what friction differs by from run to run: `TorqueFit` in, `TorqueStudy` and `RunFriction` out.

A gear that warms up over a session, or a load that is changed between runs, has other friction in every run. No effect
over position, speed or the time within a run explains that, and it hides those that are there. All torques of a
friction law scale together, so that the residual of run k is s_k·F along the model's friction torque F:

    s_k = ⟨F, r⟩ / ⟨F, F⟩ ,   1 + s_k = level of the friction of run k over that of the model.

1. Compute F of every run, and s_k: of a fitted run from all rows that count, of any other run from its first part, as
   its first rows give its initial state.
2. Take s_k·F out of the torques where that leaves clearly less, on fitted runs and on the rest of the held-out ones,
   and clearly less than the better black box of position and speed, or of speed alone: friction that only follows
   another curve over the speed differs from run to run too, where the runs differ in speed.
3. Refit, and once more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.discrepancy.torque.repeatable import black_box_rms
from haptid.discrepancy.torque.study import RunFriction, TorqueStudy
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.identification.simulators.slow_rows import Mask
from haptid.measurement.values.run import Array, Run
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import rms


def even_out_friction(model: TorqueFit) -> TorqueFit | None:
    """Take out of the runs what their friction differs by, and refit.

    Parameters
    ----------
    model
        Nominal model.

    Returns
    -------
    TorqueFit or None
        Refit; its study has evened torques and their `RunFriction`, and no held-out row that gave a level. None where
        the runs do not show it.
    """
    study = model.study
    if len(study.runs) < THRESHOLDS.torque.least_runs_of_run_friction or not _are_whole(study):
        return None
    giving = tuple(_first_part(run) for run in study.runs)
    once = _levels(model, study.runs, giving)
    before, after = _left(model, once, giving)
    most = THRESHOLDS.torque.largest_rms_with_run_friction
    if any(now > most * was for was, now in zip(before, after, strict=True)) or after[1] > most * _other(model, giving):
        return None
    levels = dict.fromkeys((run.file for run in (*study.runs, *study.sealed)), 1.0)
    # Rows of held-out runs that gave a level are scored no more.
    kept = tuple(~moving | (mask & ~seen) for moving, mask, seen in zip(study.moving, giving, study.seen, strict=True))
    for _ in range(THRESHOLDS.torque.passes_of_run_friction):
        model, levels = _without(model, levels, kept)
    told = RunFriction(levels=levels, before=before[1], after=after[1])
    return replace(model, study=replace(model.study, friction_by_run=told))


def _are_whole(study: TorqueStudy) -> bool:
    """Whether every run is fitted or held out as a whole, and both exist."""
    seen = [bool(each.all()) for each in study.seen]
    return (
        any(seen)
        and not all(seen)
        and all(whole or not each.any() for whole, each in zip(seen, study.seen, strict=True))
    )


def _first_part(run: Run) -> Mask:
    """Return the rows that give a run its level: all of a fitted run, the first part of any other."""
    return np.asarray((run.use == "fit") | (run.t <= THRESHOLDS.torque.part_that_gives_friction * run.t[-1]))


def _friction(model: TorqueFit, run: Run) -> Array:
    """Return the model's friction torque along a run [N m], shape (n_t,): what twice the friction adds."""
    equations = model.problem.simulator.equations
    torques = {row.id for row in law_named(model.study.base.friction[0]).parameters if "N" in row.unit}
    twice = [2.0 if q.id in torques else 1.0 for q in equations.parameters]
    once, more = (model.problem.simulator.simulate(theta, run).y[:, 0] for theta in (model.theta, model.theta * twice))
    friction = more - once
    # A bristle that begins at rest in a moving joint is damped by many times the friction, for a few rows.
    largest = float(np.abs(friction[THRESHOLDS.torque.rows_of_starting_bristle :]).max(initial=0.0))
    return np.asarray(np.clip(friction, -largest, largest))


def _levels(model: TorqueFit, runs: Sequence[Run], giving: Sequence[Mask]) -> list[tuple[float, Array]]:
    """Return s and F of each run; s is 0 where the model has no friction."""
    found = []
    for run, given in zip(runs, giving, strict=True):
        rows = given & (np.arange(given.size) >= THRESHOLDS.torque.rows_of_starting_bristle)
        friction, residual = _friction(model, run), model.compute_missed(run)
        energy = float(np.sum(friction[rows] ** 2))
        found.append((float(friction[rows] @ residual[rows]) / energy if energy > 0.0 else 0.0, friction))
    return found


def _left(
    model: TorqueFit, levels: Sequence[tuple[float, Array]], giving: Sequence[Mask]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the RMS of fitted and of held-out rows before and after [N m], without rows that gave a level."""
    study = model.study
    parts = []
    for take in (0.0, 1.0):
        left = [r - take * s * friction for r, (s, friction) in zip(model.residual, levels, strict=True)]
        fitted = [r[rows] for r, rows in zip(left, study.fitted_rows, strict=True)]
        unseen = [r[rows & ~mask] for r, rows, mask in zip(left, study.unseen_rows, giving, strict=True)]
        parts.append((rms(np.concatenate(fitted)), rms(np.concatenate(unseen))))
    return parts[0], parts[1]


def _other(model: TorqueFit, giving: Sequence[Mask]) -> float:
    """Return what the better black box leaves on held-out rows [N m]: over position and speed, or over speed alone.

    A table knows no speed that no fitted run has. Where every run has a speed of its own, a curve over the speed is
    what friction of each run would be taken for: sgn(v)·(c₀ + c₁·|v| + …), fitted to fitted rows.
    """
    study, degree = model.study, THRESHOLDS.torque.degree_of_speed_curve
    speeds = [measured_motion(run)[:, 1] for run in study.runs]
    largest = max(float(np.abs(v).max()) for v in speeds)
    columns = [np.sign(v)[:, None] * np.abs(v / largest)[:, None] ** np.arange(degree + 1) for v in speeds]
    seen = [(c[rows], r[rows]) for c, r, rows in zip(columns, model.residual, study.fitted_rows, strict=True)]
    A, b = (np.concatenate(parts) for parts in zip(*seen, strict=True))
    curve = np.linalg.lstsq(A, b, rcond=None)[0]
    left = [
        (r - c @ curve)[rows & ~mask]
        for c, r, rows, mask in zip(columns, model.residual, study.unseen_rows, giving, strict=True)
    ]
    table = black_box_rms(model)
    return min(rms(np.concatenate(left)), np.inf if table is None else table)


def _without(
    model: TorqueFit, levels: Mapping[str, float], resting: tuple[Mask, ...]
) -> tuple[TorqueFit, dict[str, float]]:
    """Take s·F out of all runs and refit; return the levels of friction by file, multiplied by 1 + s."""
    study, now = model.study, dict(levels)

    def even(runs: tuple[Run, ...]) -> tuple[Run, ...]:
        made = []
        found = _levels(model, runs, [_first_part(run) for run in runs])
        for run, (s, friction) in zip(runs, found, strict=True):
            now[run.file] *= 1.0 + s
            made.append(run.but(y=run.y - s * friction[:, None]))
        return tuple(made)

    evened = replace(study, runs=even(study.runs), sealed=even(study.sealed), resting=resting)
    return fit_model(evened, start=model.values), now
