"""Option of the commands that run foreign FMUs."""

from __future__ import annotations

import click

from haptid.identification.thresholds import THRESHOLDS

limit_option = click.option(
    "--simulation-limit",
    "limit_s",
    type=click.FloatRange(min=0.1),
    default=THRESHOLDS.longest_simulation_s,
    show_default=True,
    metavar="SECONDS",
    help="Of an FMU: longest wait for one simulation.",
)
