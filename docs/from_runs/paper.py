"""Write the figures of ``docs/paper.md`` and its tables: what Tam, Kubica and Wang state, and what haptid computes.

``python -m docs.from_runs.paper --from RESULTS`` reads what ``haptid identify --out RESULTS`` wrote of the embedded
campaign, draws the paper's Figs. 4 to 11 anew and stores their numbers; without it the tables alone are written again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
import numpy as np

from docs.parts.tables import table, with_parts
from haptid import Campaign, Identified
from haptid.identification.output.traces import Trace, traces_of
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.model.device.reader import load_device
from haptid.model.planning.locking_order import locking_order
from haptid.report.common.style import figure, png, style
from haptid.report.identification.figures import draw_residual, draw_signal
from haptid.support.files.files import write_bytes, write_json, write_text
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "paper.md"
STORED = ROOT / "docs" / "results" / "paper.json"
PICTURE = ROOT / "docs" / "images" / "paper_figures.png"
SCRIPT = "docs/from_runs/paper.py"
SEQUENCE_OF_PAPER = ((4,), (5,), (3,), (2,), (1,), (0,), (0, 1))
"""Free joints of configurations 1 to 7 in Table I of the paper."""
FIRST_SHOWN_S = 6.0
"""Time [s] that the figures show: some cycles of the slowest torque."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One figure of the paper.

    Parameters
    ----------
    number
        Of the figure.
    joint
        Free joint.
    omega
        Angular frequency of its torque [rad/s].
    """

    number: int
    joint: int
    omega: str


PANELS = (
    Panel(number=4, joint=0, omega="1"),
    Panel(number=5, joint=0, omega="1.33"),
    Panel(number=6, joint=0, omega="1.65"),
    Panel(number=7, joint=1, omega="1.42"),
    Panel(number=8, joint=2, omega="1.5"),
    Panel(number=9, joint=3, omega="0.88"),
    Panel(number=10, joint=4, omega="1.75"),
    Panel(number=11, joint=5, omega="1"),
)
"""The paper does not say which frequencies its Figs. 4 to 6 show: here those that it fitted."""


def traces_by_panel(identified: Identified) -> dict[int, Trace]:
    """Return the signals of each figure by its number."""
    found: dict[int, Trace] = {}
    for step in identified.steps:
        if len(step.configuration.free_joints) > 1:
            continue
        (joint,) = step.configuration.free_joints
        wanted = [panel for panel in PANELS if panel.joint == joint]
        traces = {trace.score.file: trace for trace in traces_of(step, KernelSimulator.of)}
        for panel in wanted:
            (file,) = [name for name in traces if name.endswith(f"_w{panel.omega}.csv.gz")]
            found[panel.number] = traces[file]
    return found


def draw(traces: Mapping[int, Trace]) -> bytes:
    """Return the picture of all figures: position above, residual below."""
    with style():
        made = figure(11.0, 7.5)
        axes = made.subplots(4, 4, sharex=True, height_ratios=[2, 1, 2, 1])
        for place, panel in enumerate(PANELS):
            above, below = axes[2 * (place // 4)][place % 4], axes[2 * (place // 4) + 1][place % 4]
            trace = traces[panel.number]
            draw_signal(above, trace, first=place % 4 == 0)
            draw_residual(below, trace, first=place % 4 == 0)
            above.set_ylabel("position [rad]" if place % 4 == 0 else "")
            above.set_title(f"Fig. {panel.number}: joint {panel.joint}, ω = {panel.omega} rad/s", fontsize=8)
            above.set_xlim(0.0, FIRST_SHOWN_S * 2)
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        handles, labels = axes[0][0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=2)
        return png(made)


def numbers_of(panel: Panel, trace: Trace, score: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is stored of a figure; ``score`` is the run's entry in identification.json."""
    settled = trace.t >= 0.5 * trace.t[-1]
    travel = [float(np.ptp(signal[settled, 0])) for signal in (trace.measured, trace.simulated)]
    return {
        "figure": panel.number,
        "joint": panel.joint,
        "omega_rad_s": float(panel.omega),
        "file": trace.score.file,
        "use": trace.score.use,
        "rms_rad": float(trace.score.rmse[0]),
        "over_noise": float(trace.score.over_noise),
        "plain_rms_rad": score["figures"]["baseline"]["free_rmse"],
        "travel_measured_rad": travel[0],
        "travel_simulated_rad": travel[1],
    }


def worst(entry: Mapping[str, Any], use: str) -> float | None:
    """Return the largest RMS over noise of a configuration's runs of one use; None where there is none."""
    scores = [run["rmse_over_noise"] for run in entry["runs"] if run["use"] == use]
    return max(scores) if scores else None


def stored_of(identified: Identified) -> tuple[dict[str, Any], bytes]:
    """Return the numbers and the picture of an identification of the embedded campaign."""
    traces = traces_by_panel(identified)
    scores = {run["file"]: run for entry in identified.data["configurations"] for run in entry["runs"]}
    joints = [
        {
            "free_joints": entry["free_joints"],
            "outcome": entry["outcome"],
            "fit": worst(entry, "fit"),
            "validate": worst(entry, "validate"),
            "free": len(entry["free"]),
        }
        for entry in identified.data["configurations"]
    ]
    stored = {
        "date": datetime.now(UTC).date().isoformat(),
        "command": "haptid identify",
        "code": identified.data["code"],
        "figures": [numbers_of(p, traces[p.number], scores[traces[p.number].score.file]) for p in PANELS],
        "configurations": joints,
    }
    return stored, draw(traces)


def sequence_table() -> str:
    """Return the locking order of the paper beside that which the equations give."""
    order = locking_order(load_device("freedom6s"))
    rows = []
    for number, (paper, stage) in enumerate(zip(SEQUENCE_OF_PAPER, order.stages, strict=True), start=1):
        computed = "+".join(map(str, stage.free))
        rows.append((number, "+".join(map(str, paper)), computed, len(stage.new), len(stage.contains)))
    header = ("configuration", "free in Table I", "free, computed", "new parameters", "of them all in the equation")
    return table(header, rows)


def figures_table(figures: Sequence[Mapping[str, Any]]) -> str:
    """Return the numbers of the figures."""
    rows = [
        (
            f"{one['figure']}",
            one["joint"],
            f"{one['omega_rad_s']:g}",
            one["use"],
            f"{1e3 * one['rms_rad']:.3f}",
            f"{one['over_noise']:.2f}",
            "diverges" if one["plain_rms_rad"] is None else f"{1e3 * one['plain_rms_rad']:.1f}",
            f"{one['travel_measured_rad']:.4f}",
            f"{one['travel_simulated_rad']:.4f}",
        )
        for one in figures
    ]
    header = (
        "Fig.", "joint", "ω [rad/s]", "use", "RMS [mrad]", "RMS / noise", "RMS, plain model [mrad]",
        "travel measured [rad]", "simulated [rad]",
    )  # fmt: skip
    return table(header, rows)


def configurations_table(stored: Mapping[str, Any]) -> str:
    """Return how the fits of the seven configurations ended."""
    rows = [
        (
            "+".join(map(str, one["free_joints"])),
            one["free"],
            "–" if one["fit"] is None else f"{one['fit']:.2f}",
            "–" if one["validate"] is None else f"{one['validate']:.2f}",
            one["outcome"],
        )
        for one in stored["configurations"]
    ]
    header = ("free joints", "fitted parameters", "RMS / noise, fitted runs", "RMS / noise, unseen run", "outcome")
    return f"{table(header, rows)}\n*`{stored['command']}`, {stored['date']}.*"


def with_tables(page: str, stored: Mapping[str, Any]) -> str:
    """Return the page with its tables made anew."""
    parts = {
        "locking sequence": sequence_table(),
        "figures": figures_table(stored["figures"]),
        "configurations": configurations_table(stored),
    }
    return with_parts(page, parts, SCRIPT)


@click.command()
@click.option("--from", "source", type=click.Path(path_type=Path, exists=True, file_okay=False), default=None)
def main(source: Path | None) -> None:
    """Draw the figures from a result, where one is given, and write the tables."""
    if source is not None:
        stored, picture = stored_of(Identified.read(source, Campaign.read()))
        write_json(STORED, stored)
        write_bytes(PICTURE, picture)
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    write_text(PAGE, with_tables(PAGE.read_text(encoding="utf-8"), stored))
    click.echo(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
