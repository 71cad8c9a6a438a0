"""The whole model after the paper's tests and after the planned ones, on several virtual machines.

Each machine records the locked-joint tests of Tam, Kubica and Wang (2005), tests in the lock postures of the embedded
plan, and two runs with all six joints free. The first machine is that of the embedded campaigns; the others are drawn
around it by `virtual_device.machine.variation.vary`. Both campaigns of a machine hold the same runs at home. Both are
identified from the same first guesses, and the whole model that each yields is simulated on the two runs, which no fit
saw: through the stated controller, and from the recorded torques alone.

Results go to ``docs/results``, those of the embedded campaigns also to the page that ``haptid identify`` writes.
``--machines 1`` does the embedded one alone and keeps the stored others.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from haptid.api.campaign import Campaign
from haptid.identification.problem.options import FitOptions
from haptid.measurement.format.embedded import FOLDERS, embedded_campaign
from haptid.measurement.values.postures import locked_posture
from haptid.report.identification.campaign_comparison import STORED, worst_by_joint
from haptid.support.files.files import write_json
from haptid.support.terminal import Count
from haptid.virtual_device.make_campaign import PLAN
from haptid.virtual_device.make_campaign import main as make_campaign
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parent.parent / "docs" / "results" / "whole_model.json"
MACHINES = ((0.0, 1), (0.3, 7), (0.3, 8))
"""Width of the variation and seed of each machine; the first is that of the embedded campaigns."""
AIM = 1.5
"""Largest RMS over the noise of any joint in closed loop [1]."""
LABELS = {"planned": "planned", "paper": "the paper's"}


def campaigns_of(width: float, seed: int, folder: Path) -> dict[str, Campaign]:
    """Make both campaigns of a machine, or read the embedded ones.

    Parameters
    ----------
    width, seed
        Variation and seed of the machine, as in `MACHINES`.
    folder
        Where its tables are written.

    Returns
    -------
    dict
        Campaign by its name in `FOLDERS`.
    """
    if width == 0:
        return {name: Campaign.read(embedded_campaign(name)) for name in FOLDERS}
    arguments = ["--plan", str(PLAN), "--device-variation", str(width), "--seed", str(seed), "--out", str(folder)]
    make_campaign([*arguments, "--quiet"], standalone_mode=False)
    planned = Campaign.read(folder)
    at_home = tuple(run for run in planned.values.runs if not any(locked_posture(run)))
    return {"planned": planned, "paper": Campaign(values=planned.values.but(runs=at_home))}


def identify(campaign: Campaign, workers: int) -> dict[str, Any]:
    """Identify a campaign and return what its whole model leaves on the runs that no fit saw."""
    begun = time.perf_counter()
    made = campaign.identify(kind=None, options=FitOptions(workers=workers))
    runs = [
        {
            "file": run["file"],
            "mode": run["mode"],
            "rmse_over_noise": [joint["rmse_over_noise"] for joint in run["joints"]],
        }
        for run in made.data["verification"]["runs"]
    ]
    locked = [run["rmse_over_noise"] for c in made.data["configurations"] for run in c["runs"] if run["use"] != "fit"]
    return {
        "title": campaign.values.title,
        "runs": runs,
        "values": made.data["whole"],
        "configurations": len(made.data["configurations"]),
        "worst_locked_over_noise": max(locked),
        "wall_s": time.perf_counter() - begun,
    }


def measure(width: float, seed: int, workers: int) -> dict[str, Any]:
    """Identify both campaigns of one machine."""
    with tempfile.TemporaryDirectory() as folder:
        campaigns = campaigns_of(width, seed, Path(folder) / "campaign")
        return {
            "variation": width,
            "seed": seed,
            "campaigns": {name: identify(campaign, workers) for name, campaign in campaigns.items()},
        }


def name_of(machine: Mapping[str, Any]) -> str:
    """Return words for a machine in a table."""
    if machine["variation"] == 0:
        return "embedded"
    return f"± {100 * machine['variation']:.0f} %, seed {machine['seed']}"


def _table(machines: Sequence[Mapping[str, Any]], mode: str) -> list[str]:
    lines = ["| machine | campaign | joint 0 | 1 | 2 | 3 | 4 | 5 |", f"|{' --- |' * 8}"]
    for machine in machines:
        for name, label in LABELS.items():
            worst = worst_by_joint(machine["campaigns"][name]["runs"], mode)
            lines.append(f"| {name_of(machine)} | {label} | " + " | ".join(f"{x:.3g}" for x in worst) + " |")
    return lines


def page(kept: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    machines = kept["machines"]
    worst = {
        name: [max(worst_by_joint(one["campaigns"][name]["runs"], "closed_loop")) for one in machines]
        for name in LABELS
    }
    reached = sum(value <= AIM for value in worst["planned"])
    counts = {name: machines[0]["campaigns"][name]["configurations"] for name in LABELS}
    lines = [
        "# The whole model after the paper's tests and after the planned ones",
        "",
        "Synthetic. Every machine is tested twice: with the protocol of Tam, Kubica and Wang (2005), locked joints at "
        f"home ({counts['paper']} configurations), and with tests in planned lock postures beside it "
        f"({counts['planned']} configurations). Simulated are two runs with all six joints free that no fit saw. Given "
        "is the RMS of (measured − simulated) position over the sensor's noise, the worse run of each joint. The first "
        "machine is that of the embedded campaigns; the others are drawn around it by "
        "`virtual_device.machine.variation.vary`, and have the same plan.",
        "",
        tell_origin(kept),
        "",
        f"- Closed loop, every joint at most {AIM} times the noise after the planned tests: {reached} of "
        f"{len(machines)} machines; the worst joint of all {max(worst['planned']):.3g} times.",
        f"- After the paper's tests the worst joint of a machine leaves {min(worst['paper']):.3g} to "
        f"{max(worst['paper']):.3g} times the noise.",
        "",
        "## Closed loop: through the stated controller",
        "",
        *_table(machines, "closed_loop"),
        "",
        "## Open loop: from the recorded torques, without feedback",
        "",
        *_table(machines, "open_loop"),
    ]
    return "\n".join(lines) + "\n"


def extract(kept: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the page of an identification shows of the embedded campaigns.

    Parameters
    ----------
    kept
        Content of ``docs/results/whole_model.json``.

    Returns
    -------
    dict
        Command, date and version, and the runs of each embedded campaign by its name.
    """
    campaigns = kept["machines"][0]["campaigns"]
    runs = {name: {"title": one["title"], "runs": one["runs"]} for name, one in campaigns.items()}
    return {**{key: kept[key] for key in ("command", "date", "git")}, "campaigns": runs}


@click.command(help=__doc__)
@click.option("--machines", default=len(MACHINES), show_default=True, type=click.IntRange(1, len(MACHINES)))
@click.option("--workers", default=os.cpu_count() or 1, show_default="cores")
def main(machines: int, workers: int) -> None:
    """Identify both campaigns of all machines, and write results and pages."""
    stored = json.loads(OUT.read_text(encoding="utf-8"))["machines"] if OUT.exists() else []
    made = [measure(width, seed, workers) for width, seed in Count(MACHINES[:machines], title="machines")]
    kept = {
        **origin_of(" ".join(["python -m benchmarks.whole_model", *sys.argv[1:]])),
        "machines": [*made, *stored[machines:]],
    }
    text = store(OUT, kept, page)
    write_json(STORED, extract(kept))
    click.echo(text)


if __name__ == "__main__":
    main()
