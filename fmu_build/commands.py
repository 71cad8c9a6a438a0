"""The commands ``haptid fmus`` and ``haptid export``, declared without their work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.declaring.completion import complete_device, complete_files
from haptid.support.declaring.declaration import call, command, json_option

EXAMPLES_OF_EXPORT = """
haptid export --from results --out arm.fmu
haptid export --from results/identification.json --out arm.fmu --kind native --fmi 3.0
haptid export --from results/identification.json --out arm.fmu --with results/discrepancy/joint3.json
haptid export --from results/identification.json --out arm.xml
haptid export --from results/identification.json --out arm.urdf
"""
EXAMPLES_OF_FMUS = """
haptid fmus freedom6s --out build
haptid fmus arm.toml --joints 4,5 --fmu native --json
"""
WRITES = {"fmu/joint<j>.fmu": "one per locked-joint configuration, at the device's first guesses in SI units"}
"""What ``haptid fmus`` writes."""


@command(EXAMPLES_OF_EXPORT, writes={})
@click.option(
    "--from", "source", type=click.Path(path_type=Path), required=True,
    help="An identification.json, or the folder that holds it.",
)  # fmt: skip
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    required=True,
    help="The file to write; an FMU's ends in .fmu.",
)
@click.option(
    "--kind", type=click.Choice(["python", "native", "urdf", "mjcf"]), default=None,
    show_default="urdf for .urdf, mjcf for .xml, else python",
    help="An FMU, by pythonfmu or of native code; or the bodies of the device for simulators of rigid bodies.",
)  # fmt: skip
@click.option("--fmi", type=click.Choice(["2.0", "3.0"]), default="2.0", show_default=True, help="3.0: native alone.")
@click.option("--joints", default=None, metavar="4", help="This joint alone instead of the whole device.")
@click.option(
    "--with", "named", type=click.Path(path_type=Path), multiple=True, metavar="joint3.json",
    help="A discrepancy/joint<j>.json whose effects the whole device takes along; may be given several times.",
)  # fmt: skip
@click.option(
    "--values", "start", type=click.Path(path_type=Path), default=None, metavar="parameters.ssv",
    help="A parameter set (SSP 1.0) whose values the FMU starts from instead.",
)  # fmt: skip
@click.option("--effects", type=click.Path(path_type=Path), default=None, help="Folder with the effects of your own.")
@click.option(
    "--device", default=None, metavar="FILE", shell_complete=complete_files,
    help="The device's file, where the results have no copy of it.",
)  # fmt: skip
@click.option(
    "--friction", type=click.Choice(["lugre", "frictionloss"]), default="lugre", show_default=True,
    help="Friction of an MJCF: MuJoCo 4.0's LuGre bristle where the joint's is LuGre, or Coulomb and viscous alone.",
)  # fmt: skip
@exit_codes
@json_option
def export(**settings: Any) -> Any:
    """Package the model that an identification.json holds as an FMU, URDF or MJCF, the file that --out names.

    URDF and MJCF hold the whole device at the values of its FMU; the command says what they do not carry.
    --with takes along what haptid missing named, at the values of its refit: into the FMU of all joints.
    Variables of the FMU are in SI units: rad, N m (m, N for a joint that slides), s.
    """
    return call("haptid.fmu_build.export", "export_result", **settings)


@command(EXAMPLES_OF_FMUS, WRITES)
@click.argument("device", default="freedom6s", shell_complete=complete_device)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("artifacts"),
    show_default=True,
    help="Folder below which fmu/ is written.",
)
@click.option("--joints", default=None, metavar="4,5,3", help="Only these joints.")
@click.option(
    "--fmu",
    "kind",
    type=click.Choice(["python", "native"]),
    default="python",
    show_default=True,
    help="Packaging: by pythonfmu, or native code that needs no Python.",
)
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
@json_option
def fmus(**settings: Any) -> Any:
    """Build joint0.fmu … joint5.fmu and joints01.fmu of DEVICE: a built-in name or the path of a device TOML."""
    return call("haptid.fmu_build.run", "build_fmus", **settings)
