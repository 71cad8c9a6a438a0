"""Compare the runs of a campaign: runs in, a sentence by file out for repeated rows, swapped names and odd sensors.

One sensor has one step and about one noise. A run with another step mostly has a reading that was cut or rounded, whose
distance from the levels of all others is taken for the step.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.numbers import count_of

NUMBER = re.compile(r"([A-Za-z]*)[_-]?(?<![\d.])(\d+(?:[.p]\d+)?)")
"""Number in a name with the letters before it; "p" may stand for the decimal point."""
OF_FREQUENCY = ("w", "omega", "f", "freq", "hz")
"""Letters before the number of a frequency."""


def twins(runs: Sequence[Run]) -> dict[str, str]:
    """Find runs that repeat the rows of an earlier run.

    Parameters
    ----------
    runs
        Runs in the order of the campaign; excluded ones are ignored.

    Returns
    -------
    dict
        A sentence by file, for the later run of each pair.
    """
    place = {run.file: k for k, run in enumerate(runs)}
    # Equal runs have the same length and the same spread: sorting brings them together, and neighbours are compared.
    used = sorted((run for run in runs if run.use != "excluded"), key=lambda run: (run.t.size, float(np.std(run.y))))
    found: dict[str, str] = {}
    first: Run | None = None
    for run in used:
        if first is None or not _same_rows(first, run):
            first = run
            continue
        later, earlier = (run, first) if place[run.file] > place[first.file] else (first, run)
        found[later.file] = _twin_sentence(later, earlier)
        first = earlier
    return found


def _same_rows(one: Run, other: Run) -> bool:
    for a, b in ((one.t, other.t), (one.u, other.u), (one.y, other.y)):
        if (
            a.shape != b.shape
            or np.abs(a - b).max() > THRESHOLDS.largest_relative_difference_of_copies * np.abs(a).max()
        ):
            return False
    return True


def _twin_sentence(run: Run, other: Run) -> str:
    if run.use == other.use:
        return f"it holds the same rows as {other.file}: they count twice; was a file copied over another?"
    return f"it holds the same rows as {other.file}, which is used otherwise: it shows nothing that no fit saw"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Named:
    """A number in a file's name, and the frequency of the run's torque in the same unit."""

    run: Run
    number: float
    frequency: float

    @property
    def agrees(self) -> bool:
        return _alike(self.number, self.frequency)


def find_misnamed(runs: Sequence[Run]) -> dict[str, str]:
    """Find runs whose name states another frequency than their torque has.

    Parameters
    ----------
    runs
        Runs of the campaign; excluded, coupled and aperiodic ones are ignored.

    Returns
    -------
    dict
        A sentence by file.

    Notes
    -----
    Numbers in names may mean anything. A number counts as a frequency (in rad/s or Hz) only where it agrees with the
    torque's within 3 % in most runs of the joint whose names have it after the same letters, or where two runs have
    each other's. Whole numbers up to that of the runs count the runs, unless `OF_FREQUENCY` stands before them.
    """
    found: dict[str, str] = {}
    periodic = _periodic(runs)
    for unit, factor in (("rad/s", 1.0), ("Hz", 1.0 / (2.0 * np.pi))):
        for (_, letters, _), named in _by_letters(periodic, factor).items():
            if letters.lower() not in OF_FREQUENCY and _count_runs(named, len(runs)):
                continue
            wrong = [one for one in named if not one.agrees]
            agreed = len(named) - len(wrong) >= max(2, len(wrong) + 1)
            for one in wrong:
                other = next((o for o in wrong if o is not one and _are_swapped(one, o)), None)
                if agreed or other is not None:
                    whose = "" if other is None else f", {other.run.file} has that"
                    found[one.run.file] = (
                        f"its name says {one.number:g}, its torque has {one.frequency:.4g} {unit}{whose}: "
                        "were two tables swapped?"
                    )
    return found


def _periodic(runs: Sequence[Run]) -> list[tuple[Run, float]]:
    """Return the runs of single joints whose torque repeats, with its circular frequency [rad/s]."""
    alone = [(run, find_cycles(run)) for run in runs if run.use != "excluded" and len(run.free_joints) == 1]
    least = THRESHOLDS.least_line_share_of_variance
    return [(run, cycles.omega) for run, cycles in alone if cycles.share >= least and cycles.count > 1]


def _by_letters(
    periodic: Sequence[tuple[Run, float]], factor: float
) -> Mapping[tuple[tuple[int, ...], str, int], list[_Named]]:
    """Collect the numbers in the names of periodic runs of one joint, by joint, letters before them and their place."""
    table: dict[tuple[tuple[int, ...], str, int], list[_Named]] = {}
    for run, omega in periodic:
        name = re.sub(r"\.(csv|csv\.gz|parquet)$", "", run.file.rsplit("/", 1)[-1])
        for place, (letters, digits) in enumerate(NUMBER.findall(name)):
            number = float(digits.replace("p", "."))
            named = _Named(run=run, number=number, frequency=omega * factor)
            table.setdefault((run.free_joints, letters, place), []).append(named)
    return table


def _count_runs(named: Sequence[_Named], runs: int) -> bool:
    """Say whether numbers in names are likely those of the runs, which may agree with a frequency by chance."""
    numbers = [one.number for one in named]
    return len(set(numbers)) == len(numbers) and all(n == int(n) and 0 <= n <= runs for n in numbers)


def _are_swapped(one: _Named, other: _Named) -> bool:
    return _alike(one.number, other.frequency) and _alike(other.number, one.frequency)


def _alike(a: float, b: float) -> bool:
    return abs(a - b) <= THRESHOLDS.largest_relative_difference_of_named_frequency * max(abs(a), abs(b))


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


def find_correlated_noise(runs: Sequence[Run]) -> dict[tuple[str, int], str]:
    """Find joints whose noise is correlated in time, by runs that repeat one torque.

    Parameters
    ----------
    runs
        Runs with noise and encoder step, stated or estimated; excluded and coupled ones are ignored.

    Returns
    -------
    dict
        A sentence by file and joint, for the first of the repeated runs of a joint.

    Notes
    -----
    The noise is estimated from differences of neighbouring rows, which shows white noise alone. Of K repeats y_k the
    spread is √(K/(K − 1))·RMS(y_k − ȳ), whatever its correlation.
    """
    found: dict[tuple[str, int], str] = {}
    for group in _repeats(runs):
        y = np.stack([run.y[:, 0] for run in group])
        apart = y - y.mean(axis=0)
        apart -= apart.mean(axis=1, keepdims=True)
        spread = float(np.sqrt(np.mean(apart**2) * len(group) / (len(group) - 1)))
        std = max(float(run.sensor_std[0]) for run in group)
        first, key = group[0], (group[0].file, group[0].free_joints[0])
        if any(joint == key[1] for _, joint in found):
            continue
        most = int(THRESHOLDS.longest_correlation_of_noise_over_run * first.t.size)
        rows = _correlated_rows(apart, most)
        if spread < THRESHOLDS.least_ratio_of_noise_between_repeats * std or not 1 < rows <= most:
            continue
        unit = "m" if first.prismatic[0] else "rad"
        lasts = 1e3 * rows * float(np.median(np.diff(first.t)))
        found[key] = (
            f"the position differs by {spread:.2g} between {len(group)} runs of the same torque, and white "
            f"noise explains {std:.2g}: the noise is correlated, over about {lasts:.2g} ms; "
            f"state noise_{unit} = {spread:.2g} under [sensor]"
        )
    return found


def _repeats(runs: Sequence[Run]) -> list[list[Run]]:
    """Return the runs of one joint that repeat a torque row by row, several to a group; a copy is no repeat."""
    groups: dict[tuple[tuple[int, ...], bytes], list[Run]] = {}
    for run in runs:
        if run.use != "excluded" and len(run.free_joints) == 1 and np.ptp(run.u) > 0:
            group = groups.setdefault((run.free_joints, run.u.tobytes()), [])
            if not any(np.array_equal(run.y, other.y) for other in group):
                group.append(run)
    return [group for group in groups.values() if len(group) > 1]


def _correlated_rows(apart: Array, most: int) -> int:
    """Return after how many rows the autocorrelation falls below 1/e; one more than ``most`` where it does not."""
    power = float(np.sum(apart**2))
    for lag in range(1, most + 1):
        if float(np.sum(apart[:, lag:] * apart[:, :-lag])) < power / np.e:
            return lag
    return most + 1


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
