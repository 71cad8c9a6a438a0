"""What can be said of a campaign without a model: one row per run and joint, and remarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from haptid.measurement.checks.stated import torque_limits
from haptid.measurement.checks.suspicions import suspicions, twins
from haptid.measurement.signals.control_detection import position_control
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.signals.noise import with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run

HEADER = (
    "file",
    "joint",
    "use",
    "rows",
    "s",
    "Hz",
    "uneven",
    "torque ±",
    "travel",
    "ω rad/s",
    "cycles",
    "noise",
    "step",
)
EVEN = 0.01
"""Row intervals within this share of their median count as even."""
AT_REST = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One joint of one run: cells under `HEADER`, and remarks in words."""

    cells: tuple[str, ...]
    remarks: tuple[str, ...]


def unevenness(run: Run) -> float:
    """Share of the row intervals that differ from their median by more than 1 %."""
    gaps = np.diff(run.t)
    return float(np.mean(np.abs(gaps / np.median(gaps) - 1) > EVEN))


def summarise(campaign: Campaign, *, report: Callable[[], object] = lambda: None) -> tuple[Row, ...]:
    """Describe every joint of every run; ``report`` is called after each run."""
    same, limits = twins(campaign.runs), torque_limits(campaign)
    rows = []
    for run in campaign.runs:
        full = with_noise(run)
        estimated = (
            with_noise(run.but(noise=np.full(run.noise.shape, np.nan))) if np.isfinite(run.noise).any() else full
        )
        for column, joint in enumerate(run.free_joints):
            doubts = suspicions(run, estimated, column, limit=limits.get(joint, np.inf))
            rows.append(_row(run, full, column, doubts, same.get(run.file)))
        report()
    return tuple(rows)


def _row(run: Run, full: Run, column: int, doubts: list[str], twin: str | None) -> Row:
    cycles = find_cycles(run, column)
    uneven = unevenness(run)
    given = "" if np.isfinite(run.noise[column]) else "~"
    step_given = "" if np.isfinite(run.resolution[column]) else "~"
    cells = (
        run.file,
        str(run.free_joints[column])
        + ("" if len(run.free_joints) == 1 else f" of {','.join(map(str, run.free_joints))}"),
        run.use,
        str(run.t.size),
        f"{run.t[-1]:.4g}",
        f"{1 / float(np.median(np.diff(run.t))):.4g}",
        "–" if uneven == 0 else f"{100 * uneven:.2g} %",
        f"{np.ptp(run.u[:, column]) / 2:.3g}",
        f"{np.ptp(run.y[:, column]):.3g}",
        f"{cycles.omega:.4g}" if cycles.omega else "–",
        str(cycles.count) if cycles.count > 1 else "–",
        f"{given}{full.noise[column]:.2g}",
        f"{step_given}{full.resolution[column]:.2g}",
    )
    return Row(cells=cells, remarks=tuple(_remarks(run, full, column, doubts, twin)))


def _remarks(run: Run, full: Run, column: int, doubts: list[str], twin: str | None) -> list[str]:
    sensor = float(full.sensor_std[column])
    found = []
    sign = position_control(run, column)
    if sign:
        found.append(f"{sign}: recorded under position control, an open-loop simulation from the torque would drift")
    if np.ptp(run.u[:, column]) == 0:
        found.append("the torque never changes: nothing excites the joint")
    if np.ptp(run.y[:, column]) < AT_REST * sensor:
        found.append(f"the joint hardly moves: its travel is below {AT_REST:.0f} times the sensor noise")
    if float(np.diff(run.t).max()) > 5 * float(np.median(np.diff(run.t))):
        row = int(np.argmax(np.diff(run.t)))
        found.append(f"a gap of {np.diff(run.t).max():.3g} s after {run.t[row] + run.start_time:.4g} s")
    if run.v is not None and abs(run.v[0, column]) > 0.1 * float(np.abs(run.v[:, column]).max()):
        found.append("it starts in motion: the initial velocity should be measured or fitted")
    found += doubts
    if twin is not None:
        found.append(f"it holds the same rows as {twin}, which is used otherwise: it shows nothing that no fit saw")
    if run.use == "excluded":
        found.append(f"excluded: {run.reason}")
    return [*found, *run.notes]


def table_text(rows: tuple[Row, ...]) -> str:
    """Lay the rows out as text, the remarks below."""
    cells = [HEADER, *(row.cells for row in rows)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(HEADER))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in cells]
    return "\n".join([*lines, *_remark_lines(rows)])


def _remark_lines(rows: tuple[Row, ...]) -> list[str]:
    """Lay out the remarks, one line for all joints of a run that share it."""
    joints: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        for remark in row.remarks:
            joints.setdefault((row.cells[0], remark), []).append(row.cells[1].split()[0])
    lines = [f"  {file}, joint {', '.join(names)}: {remark}" for (file, remark), names in joints.items()]
    return ["", "Remarks", *lines] if lines else []
