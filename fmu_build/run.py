"""``python -m fmu_build.run``: one FMU per locked-joint configuration of a device."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import click

from haptid.fmu_build.building.configurations import build_configurations, configurations
from haptid.fmu_build.building.packaging import Kind
from haptid.fmu_build.commands import fmus as main
from haptid.model.device.reader import load_device
from haptid.support.command import parse_joints
from haptid.support.terminal import Count


def build_fmus(device: str, out: Path, joints: str | None, kind: Kind, quiet: bool) -> dict[str, Any]:
    """Build one FMU per locked-joint configuration, and tell which were written.

    Parameters
    ----------
    device
        Built-in name or file of the device.
    out
        Folder below which ``fmu/`` is written.
    joints
        Numbers of the joints, separated by commas; None for all.
    kind
        Packaging.
    quiet
        Whether no progress is shown.

    Returns
    -------
    dict
        Under ``fmus`` the path, title, packaging, digest and size of each.

    Raises
    ------
    InputError
        Where there is no such device, its file is at fault, or a reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    loaded = load_device(device)
    sets = configurations(loaded, parse_joints(joints))
    start, lines, built = time.perf_counter(), [], []
    for fmu in Count(
        build_configurations(loaded, sets, out / "fmu", kind=kind), total=len(sets), title="FMUs", quiet=quiet
    ):
        built.append({
            "fmu": str(fmu.path), "title": fmu.equations.title, "kind": fmu.kind, "digest": fmu.digest,
            "bytes": fmu.path.stat().st_size,
        })  # fmt: skip
        size = fmu.path.stat().st_size / 1024
        lines.append(f"{fmu.path}  {size:.0f} kB  digest {fmu.digest}  {fmu.equations.title}")
    click.echo("\n".join(lines))
    click.echo(f"{len(lines)} {kind} FMUs in {time.perf_counter() - start:.1f} s")
    return {"fmus": built}


if __name__ == "__main__":
    main()
