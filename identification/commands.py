"""The command ``haptid identify``, which is ``python -m identification.run``, declared without its work."""

from __future__ import annotations

from typing import Any

import click

from haptid.identification.foreign.options import limit_option, model_option
from haptid.measurement.format.embedded import embedded_option
from haptid.measurement.format.places import allow_outside_option
from haptid.support.command import common_options, exit_codes
from haptid.support.declaring.completion import complete_files
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES = """
haptid identify my_campaign --out results
haptid identify my_campaign --joints 4,5 --fmu none --out quick_look
haptid identify oscillator_runs --model oscillator.fmu --out calibrated
haptid identify my_campaign --out results --json | jq '.configurations[0].parameters'
"""
WRITES = {
    "identification.json": "every parameter with value, std, unit and status",
    "report.html": "measured and simulated motion, and what to do next",
    "<device>.fmu, <device>_native.fmu": "the identified device (joint<j>.fmu of a single_joint one)",
    "parameters.ssv": "its parameter set (joint<j>.ssv of a single_joint one)",
    "draws/<model>.csv": "200 draws of the parameters of each joint and of the device, which their FMUs carry",
    "device/<file>": "a copy of the device's file, for haptid export",
    "identified.fmu": "with --model: the FMU with the identified start values",
}


@command(EXAMPLES, WRITES)
@click.argument("campaign", required=False, shell_complete=complete_files)
@common_options
@click.option(
    "--fmu",
    "kind",
    type=click.Choice(["python", "native", "none"]),
    default="python",
    show_default=True,
    help="Packaging that the fits run; none runs the kernel in process.",
)
@click.option("--starts", default=8, show_default=True, type=click.IntRange(min=1), help="Most starts of a fit.")
@click.option("--method", type=click.Choice(["slsqp", "gauss_newton"]), default="slsqp", show_default=True)
@click.option("--robust", is_flag=True, help="Pseudo-Huber loss, for gross outliers.")
@click.option("--passive", is_flag=True, help="Demand passive friction of LuGre joints: sigma2 >= sigma1 (Fs - Fc)/Fc.")
@click.option("--profile", is_flag=True, help="Follow profile likelihoods to the ends of their 95 % intervals.")
@click.option("--free-velocity", is_flag=True, help="Fit the initial velocity of every run.")
@click.option("--no-export", is_flag=True, help="Leave out the FMUs of the whole device.")
@model_option("Calibrate this FMU; CAMPAIGN is about its variables.")
@limit_option
@allow_outside_option
@exit_codes
@embedded_option
@json_option
def identify(**settings: Any) -> Any:
    """Identify a device from CAMPAIGN, a folder with campaign.toml; the embedded Freedom 6S one where left out.

    Fits joint by joint in locking order, verifies the whole device on runs that no fit saw, and exports it. A campaign
    that names the variables of an FMU, or --model, calibrates that FMU.

    Units: rad, N m, kg m² (m, N, kg for a joint that slides), s. Interrupted, the same command goes on from the
    joints that were finished; the fit under way begins anew. Exit codes: 0, 1 a numerical failure, 2 bad input, 130
    Ctrl-C.
    """
    return call("haptid.identification.identify_campaign", "identify_campaign", **settings)
