"""The command ``haptid missing``, which is ``python -m discrepancy.run``, declared without its work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.format.embedded import embedded_option
from haptid.measurement.format.places import allow_outside_option
from haptid.support.command import common_options, exit_codes
from haptid.support.declaring.completion import complete_files
from haptid.support.declaring.declaration import call, command, json_option

STAGES = ("gap", "where", "what")
"""Stages that may be asked for alone, as `haptid.discrepancy.finding.stages` does them."""

EXAMPLES = """
haptid missing my_campaign --joint 4 --out results
haptid missing my_campaign --joint 4 --stage gap
haptid missing my_campaign --joint 4 --out results --json | jq .verdict
"""
WRITES = {
    "discrepancy/joint<j>.json": "verdict, named effects, gap before and after",
    "discrepancy/joint<j>.html": "the same with pictures",
    "discrepancy/joint<j>.npz": "what its figures are drawn from",
    "fmu/joint<j>_<effects>.fmu": "the joint with the named effects",
}


@command(EXAMPLES, WRITES)
@click.argument("campaign", required=False, shell_complete=complete_files)
@common_options
@click.option("--joint", type=int, default=None, help="The joint to study; --joints studies several, each alone.")
@click.option("--free", default=None, metavar="0,1", help="Runs in which exactly these joints move together.")
@click.option(
    "--stage", type=click.Choice([*STAGES, "all"]), default="all", show_default=True,
    help="gap, where, what: this stage alone (is there a gap; where; what looks like it), no verdict.",
)  # fmt: skip
@click.option(
    "--effects", type=click.Path(path_type=Path), default=None, help="Folder with effects of your own, one file each."
)
@click.option("--without", default="", metavar="ID,ID", help="Leave these effects out of the catalogue.")
@click.option(
    "--starts", default=8, show_default=True, type=click.IntRange(min=1), help="Most starts of the nominal fit."
)
@click.option(
    "--effort", default=THRESHOLDS.study.most_simulated_runs, show_default=True, type=click.IntRange(min=1),
    help="Simulated runs after which no further combinations of effects are tried.",
)  # fmt: skip
@click.option("--fmu", "kind", type=click.Choice(["python", "native"]), default="python", show_default=True)
@allow_outside_option
@exit_codes
@embedded_option
@json_option
def missing(**settings: Any) -> Any:
    """Find what is missing in a joint's model, name it, add it and show the gap shrink.

    CAMPAIGN is a folder with campaign.toml; the embedded Freedom 6S one where left out. Without --joint, --joints or
    --free: every joint alone, then the runs in which several move together, with what was named in each of them.

    Gaps are RMS in rad (m for a joint that slides), in N m (N) where the torque is what is explained. With --json,
    --joint prints its finding; any other choice an object of findings by the name of their file.
    """
    return call("haptid.discrepancy.search_campaign", "search_campaign", **settings)
