"""What every command does with a campaign first: one gate for all, then noise filled in and runs held out."""

from __future__ import annotations

from pathlib import Path

import click

from haptid.measurement.checks.clock import check_clocks
from haptid.measurement.checks.motion import check_motion
from haptid.measurement.checks.remarks import remark_lines, remarks_of
from haptid.measurement.checks.sizes import check_sizes
from haptid.measurement.checks.stated import check_stated
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.hold_out import with_validation
from haptid.measurement.signals.noise import campaign_with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.errors import LONGEST, one_line, shorten


def prepare(campaign: Campaign) -> Campaign:
    """Estimate noise and resolution where they are not given, then hold out runs where none validates."""
    return with_validation(campaign_with_noise(campaign))


def accepted(campaign: Campaign) -> Campaign:
    """Return the campaign ready for fits: the one place that decides whether a command can use it.

    Raises
    ------
    InputError
        Where numbers, clocks, stated parameters or motion allow no fit.
    """
    campaign = check_stated(check_clocks(check_sizes(campaign)))
    return check_motion(campaign, prepare(campaign))


def campaign_for_command(folder: Path | str | None) -> Campaign:
    """Read and prepare a campaign for a command: its warnings appear on stderr, its remarks are kept with it."""
    with warnings_on_stderr():
        campaign = read_campaign(folder)
        prepared = accepted(campaign)
    return prepared.but(remarks=tuple(remark_lines(remarks_of(campaign))))


def tell_remarks(campaign: Campaign) -> None:
    """Print the remarks on stderr, one line each: a command does so when it has accepted all its input."""
    for remark in campaign.remarks:
        click.echo(f"remark: {shorten(one_line(remark), LONGEST)}", err=True)
