"""``python -m model.plan [DEVICE]``: unknowns of each configuration, locking order, postures, what stays open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.planning.lock_postures import plan_postures
from haptid.model.planning.locking_order import LockingOrder, locking_order
from haptid.model.planning.summary import Data, design_summary, plan_summary
from haptid.model.planning.torque_design import ExcitationPlan, locked_quantities, plan_excitation
from haptid.report.locking_plan.page import plan_page
from haptid.report.locking_plan.text import plan_text
from haptid.support.command import exit_codes, progress
from haptid.support.errors import NumericalError
from haptid.support.files.files import write_json, write_text


@click.command()
@click.argument("device", default="freedom6s")
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
def main(device: str, out: Path, design: bool, **options: Any) -> None:
    """Derive the locking plan of DEVICE: a built-in name, a device TOML or a URDF."""
    loaded = load_device(device)
    for joint in range(len(loaded.joints)):
        locked_quantities(loaded, joint)  # refuses what would end the work that follows
    order = locking_order(loaded)
    plan = plan_summary(loaded, order)
    if design:
        plan |= _design(loaded, order, **options)
    click.echo(plan_text(plan))
    page = write_text(out / "locking_plan.html", plan_page(plan))
    data = write_json(out / "locking_plan.json", plan)
    click.echo(f"\nwritten: {page}, {data}")


def _design(
    device: Device, order: LockingOrder, *, runs: int, tests: int, noise: float, seed: int, quiet: bool
) -> Data:
    joints = progress(range(len(device.joints)), title="runs", quiet=quiet)
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
