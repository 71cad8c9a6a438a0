"""The commands ``haptid init`` and ``haptid check``, declared without their work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.identification.foreign.options import limit_option, model_option
from haptid.measurement.format.embedded import embedded_option
from haptid.measurement.format.places import allow_outside_option
from haptid.support.command import exit_codes
from haptid.support.declaring.completion import complete_device, complete_table
from haptid.support.declaring.declaration import call, command, json_option, number_of_option

EXAMPLES_OF_CHECK = """
haptid check my_campaign
haptid check my_campaign --json | jq '.runs[] | [.file, .rate_Hz]'
"""
EXAMPLES_OF_INIT = """
haptid init my_tables --out my_campaign
haptid init my_tables --out my_campaign --measured --validate 'val_*.csv' --noise 1e-4
haptid init my_tables --out my_campaign --measured --device arm.urdf
haptid init my_tables --out my_campaign --yes
haptid init my_tables --out my_campaign --measured --map 'tau=torque_0_Nm' --json
"""
WRITES = {
    "campaign.toml": "device, runs, and which of them are kept from every fit",
    "one table per run": "time_s, torque_<j>_Nm, position_<j>_rad (force_<j>_N, position_<j>_m where a joint slides)",
}
"""What ``haptid init`` writes."""


@command(EXAMPLES_OF_CHECK, writes={})
@click.argument("campaign", required=False, type=click.Path(path_type=Path))
@allow_outside_option
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@model_option("FMU that CAMPAIGN is about.")
@limit_option
@exit_codes
@embedded_option
@json_option
def check(**settings: Any) -> Any:
    """Check a measurement CAMPAIGN (a folder with campaign.toml; the embedded Freedom 6S campaign without it).

    Prints one row per run and joint, and remarks; exit 0 where the campaign can be used, 2 with one line where not.
    "~" marks what was estimated from the data. Units: N m and rad (N and m for a joint that slides). Writes nothing.
    A campaign about an FMU is checked against the FMU's variables, and every run is simulated once.
    """
    return call("haptid.measurement.check", "check_campaign", **settings)


@command(EXAMPLES_OF_INIT, WRITES)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="New folder to write.")
@click.option("--title", default=None, help="One line that names the tests.")
@click.option(
    "--device",
    default=None,
    shell_complete=complete_device,
    help="Built-in device, device TOML or URDF (from here or from FOLDER), or single_joint (default).",
)
@click.option("--measured/--synthetic", "measured", default=None, help="Where the data come from.")
@click.option("--hold", type=click.Choice(["zero", "linear"]), default="zero", show_default=True,
              help="How torque runs between rows.")  # fmt: skip
@click.option("--noise", callback=number_of_option, metavar="FLOAT", default=None,
              help="Standard deviation of the position's noise [rad].")  # fmt: skip
@click.option("--resolution", callback=number_of_option, metavar="FLOAT", default=None,
              help="Encoder step [rad]: the angle of one count, too, as 2*pi/4096.")  # fmt: skip
@click.option("--torque-constant", type=float, default=None, metavar="N m/A",
              help="Torque of an ampere (N/A of a slide), of a recorded current or voltage; below 0 it turns "
              "the sign of a current round.")  # fmt: skip
@click.option("--resistance", type=float, default=None, metavar="OHM",
              help="Resistance of the motor's winding, where a voltage or a duty was recorded.")  # fmt: skip
@click.option("--supply", type=float, default=None, metavar="V",
              help="Voltage of which a recorded duty is a share, where no column holds it.")  # fmt: skip
@click.option(
    "--validate",
    multiple=True,
    metavar="FILE|PATTERN",
    shell_complete=complete_table,
    help="Runs kept from every fit, as in 'val_*.csv'; may be repeated.",
)
@click.option("--map", "maps", multiple=True, metavar="COLUMN=NAME[*FACTOR]",
              help="Say what a column is, as in 'enc=position_0_deg' or '…_rad*0.0015'; may be repeated.")  # fmt: skip
@click.option("--free", default=None, metavar="4", help="The joints that move, where the tables hold others too.")
@click.option("--yes", is_flag=True, help="Ask nothing: take what would be proposed, and say what was assumed.")
@exit_codes
@json_option
def init(**settings: Any) -> Any:
    """Make a campaign from the CSV, text or Parquet tables in FOLDER, one run each, or from recordings.

    FOLDER stays as it is; the tables are copied. What no flag says is asked for, where a terminal is there to ask. With
    --yes nothing is asked: the data count as measured, a device file in FOLDER is taken, noise is estimated, and each
    of these is told. Where nothing is asked, with or without --yes, runs named val… or validation… are kept from every
    fit unless --validate names others. What has no proposal (the angle of an encoder count where no line above a header
    says the counts of a turn, the torque of an ampere, a duty's supply) is still needed as a flag.

    Names such as position_0_deg, Angle (deg), Position actual value [deg], torque (Nmm), millis, q1_rad or encoder
    counts are understood and converted to SI by the unit in the name: deg, mrad, mm, counts (with --resolution), mNm,
    Nmm, mN, mA, ms, us, deg/s, rpm, %. A name without number is that of joint 0, and a time without unit is in seconds
    where that is likely. Joints that do not move in a table are locked there. CSV files may have semicolons or tabs,
    decimal commas, and lines before the header; texts (.txt, .tsv, .dat) tabs or blanks. Rows with empty cells or a
    repeated time are left out, and a run is cut where more than two rows in a row are missing.

    Recordings are read where FOLDER has no tables: MATLAB (.mat; of version 7.3 by the extra 'matlab'), logs of BAM
    (.json), joint states of ROS in MCAP (.mcap, extra 'mcap') and in bags of ROS 1 (.bag) and ROS 2 (.db3, extra
    'rosbags'), a LeRobot data set (extra 'parquet'; one run an episode).
    """
    return call("haptid.measurement.new", "make_campaign", **settings)
