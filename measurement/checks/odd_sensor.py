"""Compare the position sensor between runs: runs with estimated noise in, a sentence by file and joint out.

One sensor has one step and about one noise. A run with another step mostly has a reading that was cut or rounded, whose
distance from the levels of all others is taken for the step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.numbers import count_of


def find_odd_sensors(estimated: Sequence[Run]) -> dict[tuple[str, int], str]:
    """Find runs whose encoder step or noise differs greatly from that of the joint's other runs.

    Parameters
    ----------
    estimated
        Runs with noise and encoder step estimated from their rows, also where they are stated; excluded ones are
        ignored.

    Returns
    -------
    dict
        A sentence by file and joint.
    """
    by_joint: dict[int, list[tuple[Run, int]]] = {}
    for run in estimated:
        if run.use == "excluded":
            continue
        for column, joint in enumerate(run.free_joints):
            if np.ptp(run.y[:, column]) > 0:
                by_joint.setdefault(joint, []).append((run, column))
    found: dict[tuple[str, int], str] = {}
    for joint, runs in by_joint.items():
        # Of two runs the finer step and the larger noise is the odd one: a fault adds levels and scatter.
        steps = sorted(float(run.resolution[column]) for run, column in runs)
        stds = sorted(float(run.sensor_std[column]) for run, column in runs)
        step, std = steps[len(steps) // 2], stds[(len(stds) - 1) // 2]
        for run, column in runs:
            sentence = _odd_step(run, column, step) or _odd_noise(run, column, std, steps[-1])
            if sentence:
                found[run.file, joint] = sentence
    return found


def _odd_step(run: Run, column: int, usual: float) -> str:
    step, same = float(run.resolution[column]), THRESHOLDS.largest_ratio_of_equal_steps
    if usual == 0 or 1 / same < step / usual < same:
        return ""
    beside = _rows_beside(run.y[:, column], usual)
    # Where most readings lie beside the levels, they are of another sensor; where few do, they are at fault.
    few = 0 < beside.size < THRESHOLDS.least_share_of_rows_at_end * run.t.size
    most = THRESHOLDS.largest_ratio_of_steps_between_runs
    if not few and (step == 0 or 1 / most < step / usual < most):
        return ""
    found = f"its step is {step:.2g}" if step else "it has no step"
    lie = "lies" if beside.size == 1 else "lie"
    first = f"{run.t[beside[0]] + run.start_time:.6g} s" if few else ""
    where = f" ({count_of(int(beside.size), 'reading')} {lie} between those levels, first at {first})" if few else ""
    return (
        f"the position: {found}, that of the joint's other runs is {usual:.2g}{where}: "
        "was a cell cut or rounded, or another sensor read?"
    )


def _rows_beside(y: Array, step: float) -> NDArray[np.intp]:
    """Return the rows whose reading lies between the levels that most readings have."""
    phase = np.exp(2j * np.pi * y / step)
    # The median of each part is that of the levels, whatever few readings lie beside them.
    centre = np.median(phase.real) + 1j * np.median(phase.imag)
    distance = np.abs(np.angle(phase * np.conj(centre))) / (2 * np.pi)
    return np.flatnonzero(distance > THRESHOLDS.least_distance_from_level_in_steps)


def _odd_noise(run: Run, column: int, usual: float, step: float) -> str:
    std = float(run.sensor_std[column])
    # Noise below the step depends on the motion: a slow one rests within a level.
    least = max(THRESHOLDS.largest_ratio_of_noise_between_runs * usual, step)
    if usual == 0 or run.t.size < THRESHOLDS.least_differences_of_noise or std < least:
        return ""
    return (
        f"the position's noise is {std:.2g}, that of the joint's other runs {usual:.2g}: "
        "is it in another unit, or was another sensor read?"
    )
