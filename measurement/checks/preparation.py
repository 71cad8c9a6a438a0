"""What every consumer of a campaign wants first: noise filled in, validation runs held out where there are none."""

from __future__ import annotations

from pathlib import Path

from haptid.measurement.checks.clock import check_clocks
from haptid.measurement.checks.stated import check_stated
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.hold_out import with_validation
from haptid.measurement.signals.noise import campaign_with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr


def prepare(campaign: Campaign) -> Campaign:
    """Estimate noise and resolution where they are not given, then hold out runs where none validates."""
    return with_validation(campaign_with_noise(campaign))


def campaign_for_command(folder: Path | str | None) -> Campaign:
    """Read and prepare a campaign for a command: its warnings appear on stderr, one line each."""
    with warnings_on_stderr():
        return prepare(check_clocks(check_stated(read_campaign(folder))))
