"""Compare the runs of a campaign: runs in, a sentence by file out for repeated rows and for swapped names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run

NUMBER = re.compile(r"([A-Za-z]*)[_-]?(?<![\d.])(\d+(?:[.p]\d+)?)")
"""Number in a name with the letters before it; "p" may stand for the decimal point."""


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
    each other's.
    """
    found: dict[str, str] = {}
    periodic = _periodic(runs)
    for unit, factor in (("rad/s", 1.0), ("Hz", 1.0 / (2.0 * np.pi))):
        for named in _by_letters(periodic, factor).values():
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


def _are_swapped(one: _Named, other: _Named) -> bool:
    return _alike(one.number, other.frequency) and _alike(other.number, one.frequency)


def _alike(a: float, b: float) -> bool:
    return abs(a - b) <= THRESHOLDS.largest_relative_difference_of_named_frequency * max(abs(a), abs(b))
