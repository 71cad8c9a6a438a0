"""``python -m model.plan [DEVICE]``: unknowns of each configuration, locking order, postures, what stays open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.model.commands import plan as main
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.planning.lock_postures import plan_postures
from haptid.model.planning.locking_order import LockingOrder, locking_order
from haptid.model.planning.summary import Data, design_summary, plan_summary
from haptid.model.planning.torque_design import ExcitationPlan, locked_quantities, plan_excitation
from haptid.report.common.stored_page import write_page
from haptid.report.locking_plan.page import plan_page
from haptid.report.locking_plan.text import tell_plan
from haptid.support.errors import NumericalError
from haptid.support.files.files import write_json
from haptid.support.terminal import Count, show


def plan_device(device: str, out: Path, design: bool, **options: Any) -> Data:
    """Derive the locking plan of a device, and write and tell it.

    Parameters
    ----------
    device
        Built-in name, device TOML or URDF.
    out
        Folder for the plan.
    design
        Whether runs and lock postures are proposed.
    options
        Numbers of runs and tests, noise [rad], seed, and whether progress is shown.

    Returns
    -------
    dict
        Content of locking_plan.json.

    Raises
    ------
    InputError
        Where there is no such device, or its file is at fault.
    """
    loaded = load_device(device)
    for joint in range(len(loaded.joints)):
        locked_quantities(loaded, joint)  # refuses what would end the work that follows
    order = locking_order(loaded)
    plan = plan_summary(loaded, order)
    if design:
        plan |= _design(loaded, order, **options)
    show(tell_plan(plan))
    page = write_page(out / "locking_plan.html", plan_page(plan))
    data = write_json(out / "locking_plan.json", plan)
    click.echo(f"\nwritten: {page}, {data}")
    return plan


def _design(
    device: Device, order: LockingOrder, *, runs: int, tests: int, noise: float, seed: int, quiet: bool
) -> Data:
    joints = Count(range(len(device.joints)), title="runs", quiet=quiet)
    excitations = [_excitation(device, joint, runs, noise) for joint in joints]
    postures = plan_postures(device, [stage.free for stage in order.stages], extra=tests, seed=seed)
    return design_summary(excitations, postures)


def _excitation(device: Device, joint: int, runs: int, noise: float) -> ExcitationPlan | str:
    try:
        return plan_excitation(device, joint, runs=runs, noise=noise)
    except NumericalError as error:
        return str(error)


if __name__ == "__main__":
    main()
