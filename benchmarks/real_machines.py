"""Two real machines with the defaults of the command, next to what was published about them.

``python -m benchmarks.real_machines DATA`` runs ``python -m identification.run`` on the campaigns
``dvrk_mtm_joint4`` and ``dfki_double_pendulum_a0`` below the folder DATA (with ``--found``, results that are there
already are taken) and writes ``docs/results/real_machines.md``.

- Tendon-driven joint, swept under position control: the torque is scored. Next to it the published kind of model, one
  polynomial of the seventh degree in the position for each direction, fitted to the same rows and judged on the same
  held-out third.
- Two-joint direct-drive arm: the combinations of the published link values that enter its motion, and the published
  values in the same simulation.
"""

from __future__ import annotations

import datetime
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.identification.sequence.equations_for import device_of, equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.observer import Observed
from haptid.identification.statistics.score import score
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.values.run import Array, Run

OUT = Path(__file__).parent.parent / "docs" / "results" / "real_machines.md"
SWEPT, ARM = "dvrk_mtm_joint4", "dfki_double_pendulum_a0"
DEGREE = 7
G = 9.81
PUBLISHED = {
    "l1": 0.3, "I1": 0.0535, "I2": 0.0239, "m1": 0.559, "m2": 0.604, "r1": 0.3, "r2": 0.184, "rotor": 7.66e-5,
    "ratio": 6.0, "Fc_0": 0.093, "Fc_1": 0.078, "sigma2_0": 0.001,
}  # fmt: skip
"""SI units; friction is Fc·atan(100·v) + sigma2·v."""


class Values:
    """Parameters alone, for `score`."""

    def __init__(self, theta: Array) -> None:
        self.theta = theta


def published_combinations() -> dict[str, float]:
    """Return the published values as the parameters of the coupled equations."""
    p = PUBLISHED
    rotor = p["rotor"] * p["ratio"] ** 2
    return {
        "M00_1": p["I1"] + p["I2"] + p["m2"] * p["l1"] ** 2 + rotor + p["rotor"],
        "M00_c1": 2 * p["m2"] * p["l1"] * p["r2"],
        "M11_1": p["I2"] + rotor,
        "V_c0": -(p["m1"] * p["r1"] + p["m2"] * p["l1"]) * G,
        "Fc_0": p["Fc_0"] * np.pi / 2,
        "Fc_1": p["Fc_1"] * np.pi / 2,
        "sigma2_0": p["sigma2_0"],
    }


def identified(data: Path, name: str, found: Path | None) -> dict[str, Any]:
    """Return identification.json of a campaign, run where it is not there yet."""
    out = (found or Path(".cache") / "real_machines") / name
    if found is None or not (out / "identification.json").exists():
        command = [sys.executable, "-m", "identification.run", str(data / name), "--out", str(out), "--no-export"]
        subprocess.run(command, check=True)
    return dict(json.loads((out / "identification.json").read_text(encoding="utf-8")))


def _speed(run: Run) -> Array:
    return np.asarray(run.v[:, 0] if run.v is not None else np.gradient(run.y[:, 0], run.t))


def polynomials(data: Path) -> dict[str, float]:
    """Return RMS torque [N m] that one polynomial per direction leaves on the fitted rows and on the held-out third.

    Rows at positions that were not fitted in that direction are left out: such polynomials say nothing there.
    """
    runs: dict[str, Run] = {str(run.use): run for run in campaign_for_command(data / SWEPT).runs}
    rows = {"fit": slice(None), "validate": runs["validate"].scored}
    seen = {use: (runs[use].y[of, 0], runs[use].u[of, 0]) for use, of in rows.items()}
    ways = {use: np.sign(_speed(runs[use])[of]) for use, of in rows.items()}
    left: dict[str, list[Array]] = {"fit": [], "validate": []}
    for way in (-1.0, 1.0):
        one = {use: (y[ways[use] == way], u[ways[use] == way]) for use, (y, u) in seen.items()}
        fitted = np.polynomial.Polynomial.fit(*one["fit"], DEGREE)
        for use, (y, u) in one.items():
            inside = (y >= one["fit"][0].min()) & (y <= one["fit"][0].max())
            left[use].append((u - fitted(y))[inside])
    residual = {use: np.concatenate(r) for use, r in left.items()}
    return {use: float(np.sqrt(np.mean(r**2))) if r.size else float("nan") for use, r in residual.items()}


def published_scores(data: Path, gain: float) -> dict[str, float]:
    """Return RMS over noise by run that the published values leave through the observer of gain [1/s]."""
    campaign = campaign_for_command(data / ARM)
    equations = equations_for(campaign, device_of(campaign), (0, 1))
    theta = np.array([published_combinations().get(q.id, q.initial) for q in equations.parameters])
    simulator = Observed(KernelSimulator.of(equations), gain)
    return {run.file: score(simulator, Values(theta), run).over_noise for run in campaign.runs if run.use != "excluded"}


def swept_section(data: Path, one: dict[str, Any]) -> list[str]:
    """Return the lines about the swept joint."""
    runs, poly = {r["use"]: r["rmse_Nm"] for r in one["runs"]}, polynomials(data)
    beyond = f"{1e3 * poly['validate']:.2f}" if np.isfinite(poly["validate"]) else "none at positions seen that way"
    known = [f"{id} {p['value']:.3g} ± {p['std']:.2g} {p['unit']}" for id, p in one["parameters"].items()
             if p["status"] == "identified"]  # fmt: skip
    open_ones = [f"{id} ({p['status']})" for id, p in one["parameters"].items()
                 if p["status"] not in {"identified", "fixed"}]  # fmt: skip
    return [
        "## Tendon-driven joint of a surgical master arm",
        "",
        f"{one['outcome_sentence'][0].upper()}{one['outcome_sentence'][1:]}.",
        "",
        "| residual torque, RMS [mN m] | fitted rows | held-out third |",
        "| --- | --- | --- |",
        f"| this model (LuGre friction, spring, gravity) | {1e3 * runs['fit']:.2f} | {1e3 * runs['validate']:.2f} |",
        f"| two polynomials of degree {DEGREE} | {1e3 * poly['fit']:.2f} | {beyond} |",
        "",
        "Published for two such polynomials, on all rows that they were fitted to: 4.2 mN m. Held-out rows "
        "at positions that were not fitted in the same direction are left out for them.",
        "",
        f"Identified: {'; '.join(known)}.",
        f"Left open by one slow sweep: {', '.join(open_ones)}.",
        f"The residual is {one['runs'][0]['rmse_over_noise']:.1f} times the torque's white noise on the fitted rows: "
        "the model lacks something, and the result says so.",
        "",
    ]


def arm_section(data: Path, one: dict[str, Any]) -> list[str]:
    """Return the lines about the arm."""
    gain, told, own = one["observer_gain_per_s"], published_combinations(), one["parameters"]
    before = published_scores(data, gain)
    rows = [
        f"| {id} | {v:.4g} | {own[id]['value']:.4g} ± {own[id]['std']:.2g} | {own[id]['unit']} |"
        for id, v in told.items()
    ]
    scores = [
        f"| {r['file']} | {r['use']} | {r['rmse_over_noise']:.1f} | {before[r['file']]:.1f} |" for r in one["runs"]
    ]
    return [
        "## Two-joint direct-drive arm",
        "",
        f"{one['outcome_sentence'][0].upper()}{one['outcome_sentence'][1:]} (gain {gain:.0f} 1/s).",
        "",
        "| parameter | published | found | unit |",
        "| --- | --- | --- | --- |",
        *rows,
        "",
        "| run | use | found: RMS / noise | published values: RMS / noise |",
        "| --- | --- | --- | --- |",
        *scores,
        "",
        _unseen(one, before),
        "",
        "Both are simulated through the same observer; for the published values the bristles take the first guesses. "
        "The published friction has neither stiction nor bristles; Coulomb levels are the arctangent's at high speed.",
        "",
        *(f"- {note}" for note in one["notes"] if "free simulation" in note),
        "",
    ]


def _unseen(one: dict[str, Any], before: dict[str, float]) -> str:
    """Say how both do on the runs that no fit saw."""
    unseen = [r for r in one["runs"] if r["use"] == "validate"]
    ours, theirs = (
        float(np.sqrt(np.mean(np.square(x))))
        for x in ([r["rmse_over_noise"] for r in unseen], [before[r["file"]] for r in unseen])
    )
    better = "better than" if ours < 0.95 * theirs else "worse than" if ours > 1.05 * theirs else "as well as"
    return (
        f"On the runs that no fit saw, what was found leaves {ours:.1f} times the noise and the published values "
        f"{theirs:.1f} times (RMS over the runs): the fit does {better} them there."
    )


@click.command(help=__doc__)
@click.argument("data", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--found", type=click.Path(path_type=Path, file_okay=False), default=None, help="Results to take.")
def main(data: Path, found: Path | None) -> None:
    """Write the page."""
    results = {name: identified(data, name, found)["configurations"][0] for name in (SWEPT, ARM)}
    lines = [
        "# Real machines",
        "",
        "`python -m identification.run` with its defaults on two measured campaigns, next to what was published.",
        "",
        f"`python -m benchmarks.real_machines DATA`, {datetime.datetime.now(tz=datetime.UTC).date().isoformat()}; "
        f"fits of {results[SWEPT]['wall_s']:.0f} s and {results[ARM]['wall_s']:.0f} s on a shared machine of 2 cores.",
        "",
        *swept_section(data, results[SWEPT]),
        *arm_section(data, results[ARM]),
    ]
    OUT.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    click.echo(OUT.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
