"""What in a run looks like a slip of units, signs or columns: each a remark with the remedy, never a refusal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.values.run import Array, Run

MANY_TURNS = 8 * np.pi
"""Travel [rad] of a joint that turns, four turns, above which degrees are more likely."""
SLOW = 0.05
"""Time between rows [s] above which milliseconds are more likely."""
AGAINST = -0.05
"""Mean power over RMS torque times RMS velocity, below which a joint would drive its motor."""
ABOVE = 10.0
"""Torque over the device's limit above which thousandths of the unit are more likely."""
PLATEAU, SHARE = 5, 0.02
"""Equal extreme readings in a row, and their share of a run, from which it looks clipped."""
FAR = 10.0
"""Stated noise over what the rows show, and the other way round."""


def suspicions(run: Run, estimated: Run, column: int, *, limit: float = np.inf) -> list[str]:
    """Return remarks on one joint of a run.

    Parameters
    ----------
    estimated
        The run with noise and encoder step from its own rows.
    limit
        Largest torque (force) of the joint that the device states [N m] ([N]).
    """
    checks = (
        _degrees(run, column),
        _milliseconds(run),
        _thousandths(run, column, limit),
        _power(run, column),
        _clipped(run, estimated, column),
    )
    return [remark for remark in (*checks, _noise(run, estimated, column)) if remark]


def twins(runs: Sequence[Run]) -> dict[str, str]:
    """Return by file the run whose rows it repeats, where a run to fit and one to validate are the same."""
    first: dict[bytes, Run] = {}
    found = {}
    for run in runs:
        if run.use == "excluded":
            continue
        rows = run.t.tobytes() + run.u.tobytes() + run.y.tobytes()
        other = first.setdefault(rows, run)
        if other.use != run.use:
            found[run.file] = other.file
    return found


def _degrees(run: Run, column: int) -> str:
    travel = float(np.ptp(run.y[:, column]))
    if run.prismatic[column] or travel <= MANY_TURNS:
        return ""
    return f"travel {travel:.3g} rad on a revolute joint: degrees? then multiply the position by 0.0174533"


def _milliseconds(run: Run) -> str:
    usual = float(np.median(np.diff(run.t)))
    return f"rows {usual:.3g} s apart: milliseconds? then multiply the time by 0.001" if usual > SLOW else ""


def _thousandths(run: Run, column: int, limit: float) -> str:
    most, unit = float(np.abs(run.u[:, column]).max()), "N" if run.prismatic[column] else "N m"
    if most <= ABOVE * limit:
        return ""
    return f"up to {most:.3g} {unit}, the device's limit is {limit:.3g}: in m{unit}? then multiply by 0.001"


def _power(run: Run, column: int) -> str:
    """Compare ∫τ dq over whole cycles with RMS torque times RMS velocity: friction only takes, springs give back.

    Where several joints are free, one may drive another; then nothing is said.
    """
    if len(run.free_joints) > 1:
        return ""
    cycles = find_cycles(run, column)
    if not cycles.omega or cycles.count < 2:
        return ""
    period = 2 * np.pi / cycles.omega
    powers = [
        _share(run, column, run.t[-1] - (k + 1) * period, run.t[-1] - k * period) for k in range(cycles.count - 1)
    ]
    if not powers or max(powers) > AGAINST:
        return ""
    return "the joint gives more work than it takes in every cycle: is the torque's sign wrong, or are columns swapped?"


def _share(run: Run, column: int, begin: float, end: float) -> float:
    rows = (run.t >= begin) & (run.t <= end)
    t, u, y = run.t[rows], run.u[rows, column], run.y[rows, column]
    if t.size < 2 * PLATEAU:
        return 0.0
    u, v = u - u.mean(), np.gradient(y, t)
    scale = float(np.sqrt(np.mean(u**2) * np.mean(v**2)))
    work = float(np.sum(0.5 * (u[1:] + u[:-1]) * np.diff(y)))
    return work / float(t[-1] - t[0]) / scale if scale > 0 else 0.0


def _clipped(run: Run, estimated: Run, column: int) -> str:
    y = run.y[:, column]
    if np.ptp(y) == 0 or estimated.resolution[column] > 0:
        return ""
    ends = [name for name, end in (("highest", y.max()), ("lowest", y.min())) if _is_plateau(y == end)]
    return f"the position rests exactly at its {' and '.join(ends)} value: clipped, or an end stop?" if ends else ""


def _is_plateau(at_end: Array) -> bool:
    return bool(at_end.mean() > SHARE and np.convolve(at_end, np.ones(PLATEAU), "valid").max() == PLATEAU)


def _noise(run: Run, estimated: Run, column: int) -> str:
    stated, shown = float(run.noise[column]), float(estimated.sensor_std[column])
    if not np.isfinite(stated) or shown == 0 or np.ptp(run.y[:, column]) == 0:
        return ""
    step = float(run.resolution[column]) if np.isfinite(run.resolution[column]) else 0.0
    ratio = float(np.hypot(stated, step / np.sqrt(12.0))) / shown
    if 1 / FAR <= ratio <= FAR:
        return ""
    return f"a noise of {stated:.2g} is stated, the rows show {shown:.2g}: is it in the position's unit?"
