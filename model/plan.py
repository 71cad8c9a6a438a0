"""``python -m model.plan [DEVICE]``: unknowns of each configuration, locking order, what stays unidentifiable."""

from __future__ import annotations

from pathlib import Path

import click

from model.device_file import load_device
from model.locking_order import locking_order
from model.plan_summary import plan_summary
from report.locking_plan import plan_page, plan_text
from support.command import exit_codes
from support.files import write_json, write_text


@click.command()
@click.argument("device", default="freedom6s")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("artifacts"),
    show_default=True,
    help="Folder for the plan.",
)
@exit_codes
def main(device: str, out: Path) -> None:
    """Derive the locking plan of DEVICE: a built-in name, a device TOML or a URDF."""
    plan = plan_summary(loaded := load_device(device), locking_order(loaded))
    click.echo(plan_text(plan))
    page = write_text(out / "locking_plan.html", plan_page(plan))
    data = write_json(out / "locking_plan.json", plan)
    click.echo(f"\nwritten: {page}, {data}")


if __name__ == "__main__":
    main()
