"""``python -m fmu_build.run``: one FMU per locked-joint configuration of a device."""

from __future__ import annotations

import time
from pathlib import Path

import click

from haptid.fmu_build.building.configurations import build_configurations, configurations
from haptid.fmu_build.building.packaging import Kind
from haptid.model.device.reader import load_device
from haptid.support.command import exit_codes, parse_joints, progress


@click.command()
@click.argument("device", default="freedom6s")
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
def main(device: str, out: Path, joints: str | None, kind: Kind, quiet: bool) -> None:
    """Build joint0.fmu … joint5.fmu and joints01.fmu of DEVICE: a built-in name or the path of a device TOML."""
    loaded = load_device(device)
    sets = configurations(loaded, parse_joints(joints))
    start, lines = time.perf_counter(), []
    for fmu in progress(
        build_configurations(loaded, sets, out / "fmu", kind=kind), total=len(sets), title="FMUs", quiet=quiet
    ):
        size = fmu.path.stat().st_size / 1024
        lines.append(f"{fmu.path}  {size:.0f} kB  digest {fmu.digest}  {fmu.equations.title}")
    click.echo("\n".join(lines))
    click.echo(f"{len(lines)} {kind} FMUs in {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main()
