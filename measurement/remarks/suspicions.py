"""Look for slips of units, signs and columns in one run: `Run` in, remarks with their remedies out, no refusal.

Looked for are counts or degrees for radians, angles that begin anew after a turn, milliseconds for seconds,
thousandths of torque's unit, a wrong sign of torque, clipped readings, a number far from all others that marks missing
readings, and a stated noise that the rows contradict.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.making.usable_rows import wrap_period
from haptid.measurement.remarks.limits import Limits
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.signals.noise import contrasts, robust_std
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for

UNLIMITED = Limits()
GIVES_WORK = (
    "the joint gives more work than it takes in every cycle: is the torque's sign wrong, or are columns swapped?"
)
DIFFERENCE_ORDER = 4
"""Order of the differences that remove the motion from readings."""


def suspicions(run: Run, estimated: Run, column: int, *, limits: Limits = UNLIMITED) -> list[str]:
    """Return remarks on one joint of a run.

    Parameters
    ----------
    run
        As it was read.
    estimated
        The same run with noise and encoder step estimated from its rows, also where they are stated.
    column
        Column of the joint among ``run.free_joints``.
    limits
        Largest torque and range of motion of the joint that the device states.

    Returns
    -------
    list of str
        One sentence each, with the remedy; empty where nothing looks like a slip.
    """
    slides = (run.prismatic[column],)
    marks = (
        _missing_marked(run.t, run.y[:, column], "position", unit_for("rad", slides)),
        _missing_marked(run.t, run.u[:, column], "torque", unit_for("N m", slides)),
    )
    if any(marks):
        return [remark for remark in marks if remark]  # a number that is no reading makes travel and noise meaningless
    checks = (
        _degrees(run, estimated, column, limits.travel),
        _wrapping(run, column),
        _milliseconds(run),
        _thousandths(run, column, limits.torque),
        _power(run, column),
        _find_clipping(run, estimated, column),
    )
    return [remark for remark in (*checks, _noise(run, estimated, column)) if remark]


def _missing_marked(t: Array, readings: Array, signal: str, unit: str) -> str:
    """Look for an extreme number, in few rows and far from all others, that marks missing readings as -9999 does."""
    for end in (readings.min(), readings.max()):
        others = readings[readings != end]
        rows = np.flatnonzero(readings == end)
        if not 0 < rows.size <= THRESHOLDS.largest_share_of_marked_rows * readings.size:
            continue
        if np.min(np.abs(others - end)) > THRESHOLDS.least_distance_of_mark_over_range * np.ptp(others) > 0.0:
            where = f"{rows.size} rows, first" if rows.size > 1 else "the row"
            found = f"the {signal} is {end:.6g} {unit} in {where} at {t[rows[0]]:.6g} s, far from all others"
            return f"{found}: no reading? then empty the cells, as haptid init leaves such rows out"
    return ""


def _degrees(run: Run, estimated: Run, column: int, range_of_motion: float) -> str:
    """Look for degrees: more travel than the device or any joint has, or the step of an encoder that counts in 360.

    Such a travel in whole numbers is more likely one in counts.
    """
    travel, step = float(np.ptp(run.y[:, column])), float(estimated.resolution[column])
    if run.prismatic[column] or (step > 0 and _is_power_of_two(2 * np.pi / step)):
        return ""  # an encoder that counts in parts of a turn of 2π is read in radians
    remedy = "degrees? then multiply the position by 0.0174533"
    if travel > THRESHOLDS.largest_travel_of_revolute_joint_rad:
        if np.array_equal(run.y[:, column], np.round(run.y[:, column])):
            remedy = "counts? then multiply the position by the angle of one, as 2π/4096 = 0.00153398"
            return f"travel {travel:.3g} rad in whole numbers on a revolute joint: {remedy}"
        return f"travel {travel:.3g} rad on a revolute joint: {remedy}"
    if travel > THRESHOLDS.largest_travel_over_range * range_of_motion:
        return f"travel {travel:.3g} rad, the device's joint has {range_of_motion:.3g}: {remedy}"
    if step > 0 and _is_power_of_two(360.0 / step):
        return f"the position's step is 360/{round(360.0 / step)}: {remedy}"
    return ""


def _wrapping(run: Run, column: int) -> str:
    """Look for an angle that begins anew after each turn."""
    period = wrap_period(run.y[:, column], turns=not run.prismatic[column], step=None)
    return f"the position wraps by {period:.4g} rad: count it on over the jumps, as haptid init does" if period else ""


def _is_power_of_two(counts: float) -> bool:
    """Return whether an encoder may have so many counts per turn: a power of two from 8 to 26 bits."""
    bits = float(np.log2(counts))
    return (
        THRESHOLDS.least_encoder_bits <= bits <= THRESHOLDS.most_encoder_bits
        and abs(bits - round(bits)) < THRESHOLDS.largest_distance_from_whole_bits
    )


def _milliseconds(run: Run) -> str:
    usual = float(np.median(np.diff(run.t)))
    if usual <= 1.001 * THRESHOLDS.longest_usual_row_interval_s:
        return ""
    return f"rows {usual:.3g} s apart: milliseconds? then multiply the time by 0.001"


def _thousandths(run: Run, column: int, limit: float) -> str:
    most, unit = float(np.abs(run.u[:, column]).max()), unit_for("N m", (run.prismatic[column],))
    if most <= THRESHOLDS.largest_torque_over_limit * limit:
        return ""
    return f"up to {most:.3g} {unit}, the device's limit is {limit:.3g}: in m{unit}? then multiply by 0.001"


def _power(run: Run, column: int) -> str:
    """Compare ∫τ dq over whole cycles with RMS torque times RMS velocity.

    Over a whole cycle, friction takes work and a spring gives back what it took: the drive's work is positive unless
    the torque's sign is wrong. Where several joints are free, one may drive another; then nothing is said.
    """
    if len(run.free_joints) > 1:
        return ""
    cycles = find_cycles(run, column)
    if not cycles.omega or cycles.count < 2:
        return ""
    period = 2 * np.pi / cycles.omega
    # The count includes an unfinished cycle; one period less always fits into the run.
    powers = [
        _share(run, column, run.t[-1] - (k + 1) * period, run.t[-1] - k * period) for k in range(cycles.count - 1)
    ]
    if not powers or max(powers) > THRESHOLDS.least_power_over_rms:
        return ""
    return GIVES_WORK


def _share(run: Run, column: int, begin: float, end: float) -> float:
    rows = (run.t >= begin) & (run.t <= end)
    t, u, y = run.t[rows], run.u[rows, column], run.y[rows, column]
    if t.size < 2 * THRESHOLDS.least_rows_of_plateau:
        return 0.0
    u, v = u - u.mean(), np.gradient(y, t)
    scale = float(np.sqrt(np.mean(u**2) * np.mean(v**2)))
    work = float(np.sum(0.5 * (u[1:] + u[:-1]) * np.diff(y)))
    return work / float(t[-1] - t[0]) / scale if scale > 0 else 0.0


def _find_clipping(run: Run, estimated: Run, column: int) -> str:
    """Look for readings that rest exactly at their highest or lowest value.

    With an encoder step, a joint that reverses or sticks rests at a level, too. Such a rest is clipping only where the
    end lies between the levels, or where noise moves all other readings by more than half a step.
    """
    y, step = run.y[:, column], float(estimated.resolution[column])
    if np.ptp(y) == 0:
        return ""
    still = step == 0 or _noise_inside(run.t, y, step) > THRESHOLDS.least_noise_over_step_of_flicker * step
    ends = [
        name
        for name, end in (("highest", float(y.max())), ("lowest", float(y.min())))
        if _is_plateau(y == end) and (still or _is_beside_levels(y, end, step))
    ]
    return f"the position rests exactly at its {' and '.join(ends)} value: clipped, or an end stop?" if ends else ""


def _noise_inside(t: Array, y: Array, step: float) -> float:
    """Return the noise of the readings away from both ends, whose constant readings would hide it."""
    inside = (y > y.min()) & (y < y.max())
    whole = np.lib.stride_tricks.sliding_window_view(inside, DIFFERENCE_ORDER + 1).all(axis=1)
    values = contrasts(t, y, DIFFERENCE_ORDER)[whole]
    if values.size < THRESHOLDS.least_differences_of_noise:
        return 0.0
    return float(np.sqrt(max(robust_std(values) ** 2 - step**2 / 12.0, 0.0)))


def _is_beside_levels(y: Array, end: float, step: float) -> bool:
    """Return whether an end lies between the levels of the encoder, as its nearest reading has them."""
    others = y[y != end]
    nearest = float(others[np.argmin(np.abs(others - end))])
    counts = (end - nearest) / step
    return abs(counts - round(counts)) > THRESHOLDS.least_distance_from_level_in_steps


def _is_plateau(at_end: Array) -> bool:
    rows = THRESHOLDS.least_rows_of_plateau
    in_a_row = np.convolve(at_end, np.ones(rows), "valid").max() == rows
    return bool(at_end.mean() > THRESHOLDS.least_share_of_rows_at_end and in_a_row)


def _noise(run: Run, estimated: Run, column: int) -> str:
    stated, shown = float(run.noise[column]), float(estimated.sensor_std[column])
    if (
        not np.isfinite(stated)
        or shown == 0
        or np.ptp(run.y[:, column]) == 0
        or run.t.size < THRESHOLDS.least_differences_of_noise
    ):
        return ""
    step = float(run.resolution[column]) if np.isfinite(run.resolution[column]) else 0.0
    ratio = float(np.hypot(stated, step / np.sqrt(12.0))) / shown
    if 1 / THRESHOLDS.largest_stated_over_estimated_noise <= ratio <= THRESHOLDS.largest_stated_over_estimated_noise:
        return ""
    return f"a noise of {stated:.2g} is stated, the rows show {shown:.2g}: is it in the position's unit?"
