"""The commands that belong to no package, declared without their work: ``haptid fleet`` and ``haptid doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES_OF_DOCTOR = """
haptid doctor
haptid doctor --json
"""


@command(EXAMPLES_OF_DOCTOR, writes={})
@exit_codes
@json_option
def doctor() -> Any:
    """Check whether this installation can work, one line a check, each with what to do about a problem.

    Checked are Python, the required packages, compiler and cores, the cache (HAPTID_CACHE) and its disk, the extras,
    that a kernel compiles and that an FMU loads and runs: both are made anew in a temporary folder of the cache, which
    takes up to a minute. Exit code 1 where something is missing; an optional extra that is absent is not.
    """
    return call("haptid.doctor", "examine")


EXAMPLES_OF_FLEET = """
haptid fleet all_campaigns --out fleet
haptid fleet arm_1 arm_2 arm_3 arm_4 --workers 2 --out fleet
haptid fleet all_campaigns --json | jq .deviating
"""
WRITES_OF_FLEET = {
    "fleet.json": "outcome of each device, and every parameter with interval and robust z",
    "fleet.csv": "the same, one row a device and parameter",
    "fleet.html": "table and picture",
    "devices/<name>/": "what haptid identify writes of each device",
}


@command(EXAMPLES_OF_FLEET, WRITES_OF_FLEET)
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("fleet"), show_default=True,
              help="Folder for everything that is written.")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True,
              help="Devices that are identified at the same time, one core each.")  # fmt: skip
@click.option("--joints", default=None, metavar="4,5,3", help="Only these joints.")
@click.option("--seed", type=int, default=0, show_default=True, help="Same seed, same result, bit for bit.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
@json_option
def fleet(**settings: Any) -> Any:
    """Identify the devices in FOLDERS and say which of them deviate from the others.

    Each of FOLDERS is a campaign, or a folder of campaigns, one a device; the name of its folder names the device.
    A device whose campaign fails does not stop the rest: it is named in the table, and the exit code is 1. What was
    identified before, with the same data, options and version, is not identified again.

    A parameter deviates where its robust z is beyond what the same number of equal devices would reach in 5 % of
    fleets: (value - median) / √(spread² + std²), with the spread between devices from the median absolute deviation.
    Below four devices nothing is judged. Units: those of each parameter (rad, N m, kg m² …).
    """
    return call("haptid.fleet.run", "identify_fleet", **settings)
