"""Configurations of a campaign in the order of their fits: `Campaign` and `Device` in, `Configuration`s out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.postures import locked_posture
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.planning.locking_order import locking_order
from haptid.support.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration:
    """Free joints, posture of the locked joints, and the runs that were recorded in it.

    Parameters
    ----------
    free_joints
        Numbers of the free joints.
    posture
        Positions of the locked joints [rad], one entry per joint of the device.
    runs
        Runs of this configuration, whatever their use.
    number
        Number of the posture among those in which these joints were tested, from 1.
    """

    free_joints: tuple[int, ...]
    posture: tuple[float, ...]
    runs: tuple[Run, ...]
    number: int = 1

    @property
    def name(self) -> str:
        """``joint 4``, ``joints 0, 1``, or ``joint 3, posture 2``."""
        plural = "s" if len(self.free_joints) > 1 else ""
        named = f"joint{plural} {', '.join(map(str, self.free_joints))}"
        return named if self.number == 1 else f"{named}, posture {self.number}"

    @property
    def anchor(self) -> str:
        """Name for links in the report, of letters, digits and a hyphen."""
        joined = "joints" + "".join(map(str, self.free_joints))
        return joined if self.number == 1 else f"{joined}-{self.number}"

    @property
    def locked(self) -> str:
        """Positions of the locked joints [rad] as a sentence; empty where all positions are 0."""
        if not any(self.posture):
            return ""
        places = [f"{j} at {x:+.3g}" for j, x in enumerate(self.posture) if j not in self.free_joints]
        return f"Locked joints: {', '.join(places)} rad."


def order_of(campaign: Campaign, device: Device | None) -> tuple[tuple[int, ...], ...]:
    """List the sets of free joints that have runs to fit, in the order of their fits.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    device
        Device with its locking order; None for a single joint.

    Returns
    -------
    tuple of tuple of int
        Sets in the device's locking order, then those that the locking order does not have, as the campaign lists them.
    """
    fitted = [joints for joints in campaign.configurations if campaign.runs_of(joints, "fit")]
    planned = [stage.free for stage in locking_order(device).stages] if device is not None else []
    return tuple([joints for joints in planned if joints in fitted] + [j for j in fitted if j not in planned])


def configurations_of(
    campaign: Campaign, device: Device | None, joints: Sequence[int] | None = None
) -> tuple[Configuration, ...]:
    """List the configurations to fit, one for every set of free joints and posture.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    device
        Device with its locking order; None for a single joint.
    joints
        Joints that the free joints of a configuration must be among; all configurations where None.

    Returns
    -------
    tuple of Configuration

    Raises
    ------
    InputError
        Where one of ``joints`` has no run to fit, or no configuration matches.
    """
    order = order_of(campaign, device)
    chosen = [free for free in order if joints is None or set(free) <= set(joints)]
    missing = sorted(set(joints or ()) - {j for free in order for j in free})
    if missing or not chosen:
        tested = ", ".join(str(j) for j in sorted({j for free in order for j in free}))
        got = ", ".join(map(str, missing or joints or ())) or "none"
        raise InputError("--joints", expected=f"joints with runs to fit ({tested})", got=got)
    made = []
    for free in chosen:
        runs = campaign.runs_of(free)
        postures = dict.fromkeys(locked_posture(run) for run in runs if run.use == "fit")
        for number, posture in enumerate(postures, start=1):
            own = tuple(run for run in runs if locked_posture(run) == posture)
            made.append(Configuration(free_joints=free, posture=posture, runs=own, number=number))
    return tuple(made)
