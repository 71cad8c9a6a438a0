"""Draw the readme's picture from a finished identification of the embedded campaign."""

from __future__ import annotations

import json
from pathlib import Path

import click

from haptid.identification.output.traces import traces_of
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import configurations_of
from haptid.identification.sequence.sequence import Sequence
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.workers.workers import Here
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.report.common.style import png
from haptid.report.identification.figures import run_figure
from haptid.support.files.files import write_bytes
from haptid.support.installing.environment import ROOT

JOINT = 4  # the first to be fitted; it needs nothing from others
SHOWN = 3


@click.command()
@click.option(
    "--from",
    "source",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    default=ROOT / "artifacts" / "identification.json",
    help="What identification.run wrote.",
)
def main(source: Path) -> None:
    """Draw the last runs of joint 4, the held-out one among them, into docs/images."""
    entries = json.loads(source.read_text(encoding="utf-8"))["configurations"]
    campaign = campaign_for_command(None)
    device = device_of(campaign)
    sequence = Sequence(
        campaign=campaign,
        device=device,
        build=KernelSimulator.of,
        options=FitOptions(),
        workers=Here(),
        kept={0: next(e for e in entries if e["free_joints"] == [JOINT])},
    )
    step = next(sequence.steps(configurations_of(campaign, device, (JOINT,))))
    traces = traces_of(step, KernelSimulator.of)
    made = run_figure(traces[-SHOWN:])
    path = write_bytes(ROOT / "docs" / "images" / f"joint{JOINT}.png", png(made))
    click.echo(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
