"""Prepare a campaign for a command: folder in, `Campaign` with noise, held-out runs and remarks out.

1. Read the folder.
2. Refuse numbers, clocks and stated parameters that allow no fit.
3. Recognise positions that are averages over rows, and estimate noise and encoder step, where they are not stated;
   then hold out runs for validation.
4. Refuse configurations at rest, which only the noise decides.
5. Collect the remarks on likely slips.
"""

from __future__ import annotations

from pathlib import Path

from haptid.measurement.checks.clock import check_clocks
from haptid.measurement.checks.motion import check_motion
from haptid.measurement.checks.recorded_torque import with_torques_that_were
from haptid.measurement.checks.sizes import check_sizes
from haptid.measurement.checks.stated import check_stated
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.remarks.remarks import remark_lines, remarks_of
from haptid.measurement.signals.averaging import with_averaging
from haptid.measurement.signals.hold_out import with_validation
from haptid.measurement.signals.noise import campaign_with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.errors import LONGEST, one_line, shorten
from haptid.support.listener import Listener


def prepare(campaign: Campaign) -> Campaign:
    """Recognise averages over rows, estimate noise and resolution, then hold out runs where none validates.

    Parameters
    ----------
    campaign
        As it was read; NaN marks noise and resolution that nobody stated.

    Returns
    -------
    Campaign
        With noise and resolution in every run, and a validation run in every fitted configuration that allows one.
    """
    # Noise first: the estimates are from whole runs, and both parts of a split run get the same noise.
    return with_validation(campaign_with_noise(with_averaging(campaign)))


def prepare_campaign(campaign: Campaign) -> Campaign:
    """Return a campaign ready for fits; no other function decides whether a command can use a campaign.

    Parameters
    ----------
    campaign
        As `read_campaign` returns it.

    Returns
    -------
    Campaign
        With noise and resolution of every run, and a validation run for each configuration that has enough rows.

    Raises
    ------
    InputError
        Where numbers, clocks, stated parameters or motion allow no fit.
    """
    # Sizes first: everything after computes with the numbers, which must not overflow.
    campaign = check_stated(check_clocks(check_sizes(campaign)))
    return check_motion(campaign, prepare(campaign))


def campaign_for_command(folder: Path | str | None) -> Campaign:
    """Read and prepare a campaign for a command; its warnings go to stderr.

    Parameters
    ----------
    folder
        Folder with ``campaign.toml``; None for the embedded Freedom 6S campaign.

    Returns
    -------
    Campaign
        Ready for fits, with its remarks; `tell_remarks` prints them.

    Raises
    ------
    InputError
        Where the folder is at fault, or the campaign allows no fit.
    """
    with warnings_on_stderr():
        return ready_for_fits(read_campaign(folder))


def ready_for_fits(campaign: Campaign) -> Campaign:
    """Return a campaign ready for fits, with its remarks.

    Parameters
    ----------
    campaign
        As `read_campaign` returns it; the remarks that it has already come first.

    Returns
    -------
    Campaign
        As `prepare_campaign` returns it, with sentences on likely slips; `tell_remarks` tells them.

    Raises
    ------
    InputError
        Where the campaign allows no fit.
    """
    used = with_torques_that_were(campaign)
    prepared = prepare_campaign(used)
    # Remarks are on the campaign as it was read: the prepared one no longer shows which noise was stated.
    return prepared.but(remarks=(*used.remarks, *remark_lines(remarks_of(campaign))))


def tell_remarks(campaign: Campaign, listener: Listener) -> None:
    """Tell the remarks, one line each, after all input was accepted.

    Parameters
    ----------
    campaign
        Campaign with its remarks; a long one is shortened.
    listener
        Its ``note`` takes the lines.
    """
    for remark in campaign.remarks:
        listener.note(f"remark: {shorten(one_line(remark), LONGEST)}")
