"""What is hidden in one of two joints that move together, and what the search calls it.

    python -m benchmarks.search.coupled_missing

The virtual arm hides disturbances of its own formulas in joint 0 or 1 of the coupled test; the search over the
catalogue in both joints sees the runs alone. What is missed is over the noise, where amplitudes scatter over noise and
scatter together. Results go to ``docs/results``.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from haptid.discrepancy.finding.finding import find
from haptid.discrepancy.study.coupled_study import coupled_study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.campaign import header
from haptid.virtual_device.recording.inputs import COUPLED
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import write_campaign
from haptid.virtual_device.recording.whole import coupled_test
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parents[2] / "docs" / "results" / "coupled_missing.json"
SENSOR = Sensor(noise=2e-4, resolution=1.5e-4)
Scatter = Mapping[int, tuple[float, bool]]
CASES: tuple[tuple[str, Mapping[int, Mapping[str, float]], Scatter], ...] = (
    ("nothing", {}, {}),
    ("nothing", {}, {}),
    ("joint0_cogging", {0: {"cog": 1e-3, "cog_number": 12.0, "cog_phase": 1.0}}, {}),
    ("joint1_cogging", {1: {"cog": 2e-3, "cog_number": 10.0, "cog_phase": -0.5}}, {}),
    ("joint0_cubic_spring", {0: {"cubic": 0.3}}, {}),
    ("joint1_cubic_spring", {1: {"cubic": 0.15}}, {}),
    ("joint0_asymmetric_viscous", {0: {"drag_up": 2e-3}}, {}),
    ("joint1_quadratic_drag", {1: {"drag_square": 5e-3}}, {}),
    ("joint0_cogging, joint1_asymmetric_viscous", {0: {"cog": 1e-3, "cog_number": 9.0}, 1: {"drag_up": 3e-3}}, {}),
    ("scatter of joint 0's torque", {}, {0: (0.02, True)}),
    ("scatter of joint 0's torque and joint 1's reading", {}, {0: (0.02, True), 1: (0.01, False)}),
    ("joint0_cogging, scatter of joint 1's torque", {0: {"cog": 1e-3, "cog_number": 9.0}}, {1: (0.02, True)}),
    ("joint1_quadratic_drag, scatter of joint 0's reading", {1: {"drag_square": 5e-3}}, {0: (0.01, False)}),
)


def worked(hidden: Mapping[int, Mapping[str, float]], scatter: Scatter, seed: int) -> dict[str, Any]:
    """Return verdict, names, gap before and after over the noise, and the time [s] of one case."""
    arm = Arm(read_truth(), hidden)
    runs = [
        coupled_test(arm, number, sensor=SENSOR, seed=(seed, number), scatter=scatter) for number in range(len(COUPLED))
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_campaign(folder, header("coupled test, synthetic", "freedom6s", SENSOR), runs, joints=6)
        study = coupled_study_of(prepare(read_campaign(folder)), (0, 1), catalogue(), {}, threads=2)
        began = time.perf_counter()
        found = find(study, folder / "out", kind="native", seed=0, starts=4, tell=ignore_progress)
    gap, judgement = found.gaps["validate"], found.judgement
    names = [e.key for e in judgement.effects] if judgement.verdict != "nothing_missing" else []
    others = [" + ".join(t.candidate.ids) for t in judgement.alternatives if judgement.verdict == "ambiguous"]
    before, after = gap.beside or (gap.before / gap.noise, gap.after / gap.noise)
    return {
        "verdict": judgement.verdict,
        "names": names,
        "alternatives": others,
        "missed_before": before,
        "missed_after": after,
        "wall_s": time.perf_counter() - began,
    }


def page(stored: Mapping[str, Any]) -> str:
    """Return the results as Markdown."""
    lines = [
        "# What is hidden where two joints move together",
        "",
        "Synthetic: the coupled test of joints 0 and 1 of the virtual arm (three runs to fit, one that no fit saw), "
        "disturbances by the arm's own formulas, the catalogue in both joints, two threads. What is missed is the RMS "
        "on the unseen run over the noise, where amplitudes scatter over noise and scatter together.",
        "",
        tell_origin(stored),
        "",
        "| hidden | verdict | names | missed before | after | s |",
        "| --- | --- | --- | ---: | ---: | ---: |",
    ]
    for row in stored["rows"]:
        names = ", ".join(row["names"]) + (f" or {' or '.join(row['alternatives'])}" if row["alternatives"] else "")
        lines.append(
            f"| {row['hidden']} | {row['verdict']} | {names} | {row['missed_before']:.3g} | "
            f"{row['missed_after']:.3g} | {row['wall_s']:.0f} |"
        )
    lines += ["", f"{len(stored['rows'])} cases are no rate."]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
def main() -> None:
    """Work through the cases, and write results and page."""
    rows = []
    for seed, (truth, hidden, scatter) in enumerate(CASES):
        rows.append({"hidden": truth, **worked(hidden, scatter, 100 + seed)})
        click.echo(f"{truth}: {rows[-1]['verdict']} {', '.join(rows[-1]['names'])}", err=True)
    stored = {**origin_of("python -m benchmarks.search.coupled_missing"), "rows": rows}
    click.echo(store(OUT, stored, page))


if __name__ == "__main__":
    main()
