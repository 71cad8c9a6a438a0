"""One FMU per locked-joint configuration of a device."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from haptid.fmu_build.building.cached import cached_fmu
from haptid.fmu_build.building.packaging import Fmu, Kind
from haptid.model.device.device import Device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.support.errors import InputError
from haptid.support.files.files import write_bytes

COUPLED = (0, 1)
"""The coupled test: some products of inertia appear in the mass matrix's entry between these joints alone."""


def configurations(device: Device, joints: Sequence[int] | None = None) -> tuple[tuple[int, ...], ...]:
    """Return the sets of free joints that a device is tested with.

    Parameters
    ----------
    device
        Device whose joints are counted.
    joints
        Joints to choose from; None for all.

    Returns
    -------
    tuple of tuple of int
        Each joint alone, ascending, then the coupled pair (0, 1) where both are chosen.

    Raises
    ------
    InputError
        Where the device has no such joint.
    """
    count = len(device.joints)
    wanted = range(count) if joints is None else sorted(set(joints))
    unknown = [j for j in wanted if not 0 <= j < count]
    if unknown:
        raise InputError("--joints", expected=f"joints 0..{count - 1} of {device.name}", got=str(unknown[0]))
    sets: list[tuple[int, ...]] = [(j,) for j in wanted]
    if all(j in wanted for j in COUPLED):
        sets.append(COUPLED)
    return tuple(sets)


def build_configurations(
    device: Device, sets: Sequence[tuple[int, ...]], folder: Path, *, kind: Kind = "python"
) -> Iterator[Fmu]:
    """Build ``joint<j>.fmu`` and ``joints<jk>.fmu`` in a folder, or copy them from the cache.

    Parameters
    ----------
    device
        Device whose other joints are locked at 0.
    sets
        Free joints of each FMU.
    folder
        Folder to write to.
    kind
        Packaging.

    Yields
    ------
    Fmu
        One after the other, so that a command can report each.

    Raises
    ------
    InputError
        Where the first guesses of a joint are impossible, or its reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """

    def build(free: tuple[int, ...]) -> Fmu:
        turning = [joint.torque_limit for joint in (device.joints[j] for j in free) if not joint.prismatic]
        stated = max((limit for limit in turning if math.isfinite(limit)), default=0.0)
        return cached_fmu(configuration_equations(device, free), kind=kind, largest_torque=stated)

    # Most of the time is the C compiler's, which runs in processes of its own.
    pool = ThreadPoolExecutor(os.cpu_count())
    try:
        for fmu in pool.map(build, sets):
            out = write_bytes(folder / f"{fmu.equations.name}.fmu", fmu.path.read_bytes())
            yield replace(fmu, path=out)
    finally:
        pool.shutdown(cancel_futures=True)
