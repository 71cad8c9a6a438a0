"""First guess of a drive from its runs: `Equations` and `Run`s in, `Equations` and the runs with their torque out.

The equation of motion of a driven joint in gross sliding, divided by the drive's gain g, is linear in what is unknown:

    A = (M·q̈ + Fv·q̇ + Fc·sgn q̇ + g_c·cos q + g_s·sin q + c + h·e·q̇)/g

with A the torque of the drive without back-EMF at g = 1, e = 0 while the motor is let go, g = kt/R and h = kt²/R by
voltage or duty, g = kt and h = 0 by current.

1. Solve it over all fitted runs, with M, Fv, Fc, h ≥ 0. Its errors are those of A, in which the model's errors lie.
2. Where gravity is known, its share in A gives g. Otherwise no torque is known in N m, and g stays at its first guess.
3. Where the runs let the motor go, the back-EMF differs from viscous friction, and kt = h/g. Otherwise kt stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haptid.identification.baseline.baseline import moving_rows
from haptid.identification.baseline.driven import with_torque
from haptid.identification.baseline.least_squares import weighted_least_squares
from haptid.measurement.signals.filtered_motion import common_width, filter_run
from haptid.measurement.values.run import Run
from haptid.model.equations.drive import Drive
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.drive_terms import drive_quantities

CONSTANT, RESISTANCE = "torque_constant", "resistance_ohm"
"""Ids of the drive's parameters."""
COLUMNS = ("inertia", "Fv", "Fc", "back_emf", "offset", "gravity_cos", "gravity_sin")
"""Columns of the equation."""
NONNEGATIVE = np.array([True, True, True, True, False, False, False])
"""Which of them physics forbids to be negative."""


def guess_drive(equations: Equations, runs: Sequence[Run], given: Mapping[str, Mapping[str, object]]) -> Equations:
    """Set the first guess of a drive's torque constant and resistance from the runs.

    Parameters
    ----------
    equations
        Equations of a single joint, with a drive or without.
    runs
        Runs that the guess is estimated from.
    given
        Entries of the campaign by parameter id; what is fixed or has a prior stays as it is.

    Returns
    -------
    Equations
        With the ranges that they had.
    """
    drive = equations.drive
    if drive is None or drive.kind == "torque":
        return equations
    constant = equations.parameter(CONSTANT)
    resistance = equations.parameter(RESISTANCE) if drive.kind != "current" else None
    shares = _shares(drive, runs)
    gain = _gain(equations, shares)
    if gain is None:
        return equations
    changes: dict[str, dict[str, object]] = {}
    kt = constant.initial
    if resistance is None:
        kt = gain
    elif shares["back_emf"] > 0 and _is_free(constant, given):
        kt = shares["back_emf"]
    if _is_free(constant, given):
        kt = _clip(kt, constant)
        changes[CONSTANT] = _range(constant, kt)
    if resistance is not None and _is_free(resistance, given):
        changes[RESISTANCE] = _range(resistance, _clip(kt / gain, resistance))
    return equations.with_parameters(changes)


def with_torques(equations: Equations, runs: Sequence[Run]) -> list[Run]:
    """Return the runs with the torque of the drive at its first guess as their input.

    Parameters
    ----------
    equations
        Equations of a single joint.
    runs
        Its runs.

    Returns
    -------
    list of Run
        The same runs where the joint has no drive.
    """
    drive = equations.drive
    if drive is None:
        return list(runs)
    values = {q.id: q.initial for q in equations.parameters}
    return [with_torque(run, drive, values) for run in runs]


def _shares(drive: Drive, runs: Sequence[Run]) -> dict[str, float]:
    """Solve the equation of motion over the drive's gain; the back-EMF's share is kt [N m/A] where it was seen."""
    unit = {q.id: 1.0 if q.id in (CONSTANT, RESISTANCE) else q.initial for q in drive_quantities(drive)}
    width = common_width(runs)
    columns, targets = [], []
    for run in runs:
        without_speed, with_speed = (with_torque(run.but(v=v), drive, unit) for v in (np.zeros_like(run.y), run.v))
        # The command takes the place of the torque, so that motion and command pass through one filter.
        motion = filter_run(without_speed, width)
        back_emf = filter_run(run.but(u=without_speed.u - with_speed.u), width).torque
        ones = np.ones_like(motion.q)
        sign = motion.through_filter(np.sign(motion.v))
        table = [motion.a, motion.v, sign, back_emf, ones, np.cos(motion.q), np.sin(motion.q)]
        raw = np.stack(table, axis=2)
        moving = moving_rows(motion)
        columns.append((motion.through_filter(raw) * moving[:, :, None])[motion.interior])
        targets.append((motion.through_filter(motion.torque) * moving)[motion.interior])
    if not _lets_go(runs):
        # One column for viscous friction and back-EMF, which act alike while the motor holds.
        columns = [np.where(np.arange(len(COLUMNS)) == COLUMNS.index("back_emf"), 0.0, W) for W in columns]
    estimate = weighted_least_squares(columns, targets, NONNEGATIVE)
    return dict(zip(COLUMNS, estimate.theta.tolist(), strict=True))


def _gain(equations: Equations, shares: Mapping[str, float]) -> float | None:
    """Return g from the known gravity; None where it is not known, or where the runs show none of it."""
    ids = ("gravity_cos", "gravity_sin")
    rows = [q for q in equations.parameters if q.id in ids]
    known = np.array([q.initial for q in rows])
    seen = np.array([shares[q.id] for q in rows])
    if not rows or not all(q.fixed for q in rows) or not np.any(known):
        return None
    # Projected on the known gravity: what stands across it is the model's error.
    share = float(seen @ known / (known @ known))
    return 1.0 / share if share > 0 else None


def _lets_go(runs: Sequence[Run]) -> bool:
    return any(np.any(run.drive_inputs["enabled"] <= 0) for run in runs if "enabled" in run.drive_inputs)


def _is_free(quantity: Quantity, given: Mapping[str, Mapping[str, object]]) -> bool:
    return not quantity.fixed and "prior" not in given.get(quantity.id, {})


def _clip(value: float, quantity: Quantity) -> float:
    return float(np.clip(value, quantity.lower, quantity.upper))


def _range(quantity: Quantity, value: float) -> dict[str, object]:
    return {"initial": value, "lower": quantity.lower, "upper": quantity.upper}
