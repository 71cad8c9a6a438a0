"""Describe a campaign without a model: `Campaign` in, one `Row` per run and joint out, laid out as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.measurement.checks.recorded_torque import with_torques_that_were
from haptid.measurement.remarks.remarks import Remarks, remarks_of
from haptid.measurement.remarks.shared import tell_shared
from haptid.measurement.signals.cycles import Cycles, find_cycles
from haptid.measurement.signals.noise import write_estimated_noise
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.support.tables import Table, Told

TORQUE = "torque ±"
HEADER = (
    "file",
    "joint",
    "use",
    "rows",
    "s",
    "Hz",
    "uneven",
    TORQUE,
    "travel",
    "ω rad/s",
    "cycles",
    "noise",
    "step",
)
"""Headings of the columns; torque ± is half its range, Hz the rate of the rows, step the encoder's.

`tell_table` adds the unit of the torque.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Hold what the table shows of one joint of one run.

    Parameters
    ----------
    cells
        Texts under `HEADER`, one each.
    remarks
        Sentences below the table.
    facts
        The same as numbers in SI units, by names with their units.
    """

    cells: tuple[str, ...]
    remarks: tuple[str, ...]
    facts: Mapping[str, str | int | float | None]


def unevenness(run: Run) -> float:
    """Return the share of the row intervals that differ from their median by more than 1 %, from 0 to 1.

    Parameters
    ----------
    run
        Run of at least two rows.

    Returns
    -------
    float
        Share [1]; 0 for even sampling.
    """
    gaps = np.diff(run.t)
    return float(np.mean(np.abs(gaps / np.median(gaps) - 1) > THRESHOLDS.largest_deviation_of_even_interval))


def summarise(campaign: Campaign, *, report: Callable[[], object] = lambda: None) -> tuple[Row, ...]:
    """Describe every joint of every run.

    Parameters
    ----------
    campaign
        As it was read, with NaN where no noise is stated.
    report
        Called without arguments after each run, for a progress bar.

    Returns
    -------
    tuple of Row
        In the order of the runs and of their free joints. Torques in N m, positions in rad (N and m where prismatic).

    Raises
    ------
    InputError
        Where the file of the device is at fault.
    """
    drives = with_torques_that_were(campaign).drives
    closed = [joint for joint, drive in drives.items() if drive.is_closed]
    computed = [joint for joint, drive in drives.items() if not drive.commands_torque]
    rows = []
    for one in remarks_of(campaign, closed=closed, report=report):
        rows += [_row(one, k, is_computed=joint in computed) for k, joint in enumerate(one.run.free_joints)]
    return tuple(rows)


def _row(one: Remarks, column: int, *, is_computed: bool) -> Row:
    cycles, uneven = find_cycles(one.run, column), unevenness(one.run)
    return Row(
        cells=_cells(one, column, cycles, uneven, is_computed=is_computed),
        remarks=(*one.by_joint[column], *_own_words(one.run)),
        facts=_facts(one, column, cycles, uneven),
    )


def _cells(one: Remarks, column: int, cycles: Cycles, uneven: float, *, is_computed: bool) -> tuple[str, ...]:
    """Return the cells of a row, marked by ~: estimated noise and step, torque computed from a motor's command."""
    run = one.run
    given = "" if np.isfinite(run.noise[column]) else "~"
    step_given = "" if np.isfinite(run.resolution[column]) else "~"
    beside = "" if len(run.free_joints) == 1 else f" of {','.join(map(str, run.free_joints))}"
    return (
        run.file,
        f"{run.free_joints[column]}{beside}",
        run.use,
        str(run.t.size),
        f"{run.t[-1]:.4g}",
        f"{1 / float(np.median(np.diff(run.t))):.4g}",
        "–" if uneven == 0 else f"{100 * uneven:.2g} %",
        f"{'~' if is_computed else ''}{np.ptp(run.u[:, column]) / 2:.3g}",
        f"{np.ptp(run.y[:, column]):.3g}",
        f"{cycles.omega:.4g}" if cycles.omega else "–",
        str(cycles.count) if cycles.count > 1 else "–",
        _tell_noise(one, column, given),
        f"{step_given}{one.resolution[column]:.2g}",
    )


def _tell_noise(one: Remarks, column: int, given: str) -> str:
    """Write the noise, ``given`` being the mark of an estimated one."""
    noise = float(one.noise[column])
    if not given:
        return f"{noise:.2g}"
    written = write_estimated_noise(noise, float(one.resolution[column]))
    return written if written.startswith("<") else f"{given}{written}"


def _facts(one: Remarks, column: int, cycles: Cycles, uneven: float) -> dict[str, str | int | float | None]:
    """Return what a row says as numbers, with units in the names."""
    run, slides = one.run, one.run.prismatic[column]
    position, torque = ("m", "N") if slides else ("rad", "Nm")
    return {
        "file": run.file,
        "joint": run.free_joints[column],
        "use": run.use,
        "rows": int(run.t.size),
        "duration_s": float(run.t[-1]),
        "rate_Hz": float(1 / np.median(np.diff(run.t))),
        "uneven_share": uneven,
        f"{'force' if slides else 'torque'}_half_range_{torque}": float(np.ptp(run.u[:, column]) / 2),
        f"travel_{position}": float(np.ptp(run.y[:, column])),
        "omega_rad_s": float(cycles.omega) if cycles.omega else None,
        "cycles": int(cycles.count) if cycles.count > 1 else None,
        f"noise_{position}": float(one.noise[column]),
        "noise_stated": bool(np.isfinite(run.noise[column])),
        f"resolution_{position}": float(one.resolution[column]),
        "resolution_stated": bool(np.isfinite(run.resolution[column])),
    }


def row_json(row: Row) -> dict[str, Any]:
    """Return facts and remarks of a row as a value for JSON.

    Parameters
    ----------
    row
        One joint of one run.

    Returns
    -------
    dict
        Facts in SI units by names with their units, and ``remarks`` as a list.
    """
    return {**row.facts, "remarks": list(row.remarks)}


def _own_words(run: Run) -> list[str]:
    return [*([f"excluded: {run.reason}"] if run.use == "excluded" else []), *run.notes]


def tell_table(rows: tuple[Row, ...], remarks: Sequence[str] = ()) -> Told:
    """Lay the rows out as a table, with the remarks below.

    Parameters
    ----------
    rows
        One for each joint of each run.
    remarks
        Remarks on joints or on the campaign as a whole.

    Returns
    -------
    list
        Table, and the lines of the remarks.
    """
    header = tuple(_with_unit(rows) if name == TORQUE else name for name in HEADER)
    return [Table(header=header, rows=[row.cells for row in rows]), *_remark_lines(rows, remarks)]


def _with_unit(rows: tuple[Row, ...]) -> str:
    """Return the heading of the torque with its unit: forces where all joints slide, both where some do."""
    slides = {"force_half_range_N" in row.facts for row in rows}
    return {(True,): "force ± N", (False, True): f"{TORQUE} N m, N"}.get(tuple(sorted(slides)), f"{TORQUE} N m")


def _remark_lines(rows: tuple[Row, ...], whole: Sequence[str]) -> list[str]:
    """Lay out the remarks, those on the whole first, then one line for all joints and runs that share it."""
    remarks = [(row.cells[0], row.cells[1].split()[0], remark) for row in rows for remark in row.remarks]
    shared = tell_shared(remarks, every=len({row.cells[0] for row in rows}))
    lines = [f"  {line}" for line in (*whole, *shared)]
    return ["", "Remarks", *lines] if lines else []
