"""The command ``haptid plan``, which is ``python -m model.plan``, declared without its work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.declaring.completion import complete_device
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES = """
haptid plan freedom6s --out my_plan
haptid plan arm.urdf --runs 3 --noise 1e-4
haptid plan arm.urdf --no-design --json | jq .locking_order
"""
WRITES = {
    "locking_plan.json": "order, torques [N m] (N), postures [rad] (m), what stays open",
    "locking_plan.html": "the same as a page",
}


@command(EXAMPLES, WRITES)
@click.argument("device", default="freedom6s", shell_complete=complete_device)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("artifacts"),
    show_default=True,
    help="Folder for the plan.",
)
@click.option(
    "--runs", default=5, show_default=True, type=click.IntRange(min=1), help="Runs to propose for each joint."
)
@click.option(
    "--tests", default=14, show_default=True, type=click.IntRange(min=0), help="Tests at other postures to propose."
)
@click.option(
    "--noise", default=2e-4, show_default=True, type=click.FloatRange(min=0, min_open=True), help="Sensor noise [rad]."
)
@click.option("--design/--no-design", default=True, show_default=True, help="Propose runs and lock postures.")
@click.option("--seed", type=int, default=0, show_default=True, help="Same seed, same plan.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
@json_option
def plan(**settings: Any) -> Any:
    """Derive the locking plan of DEVICE: a built-in name, a device TOML or a URDF.

    Which joints to lock, in which order and posture, which torques to run, and what stays unidentifiable.
    """
    return call("haptid.model.plan", "plan_device", **settings)
