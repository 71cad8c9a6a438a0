"""What a sampling of a campaign is asked for: `Job`, and the configurations that it samples."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from haptid.fmu_build.building.packaging import Kind
from haptid.identification.sequence.configurations import Configuration, configurations_of
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.errors import InputError
from haptid.uq.result.infer import InferOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Inputs of one sampling.

    Parameters
    ----------
    campaign
        Campaign that is ready for fits.
    device
        Device of the campaign; None for a single joint.
    out
        Folder of the results, perhaps with those of an identification.
    options
        Choices of the inference.
    kind
        Packaging of the FMU that the sampler runs; None runs the kernel in process.
    """

    campaign: Campaign
    device: Device | None
    out: Path
    options: InferOptions
    kind: Kind | None

    def configurations(self, wanted: tuple[int, ...] | None) -> tuple[Configuration, ...]:
        """Return the configurations of one free joint, in locking order, each joint in the first posture of its runs.

        Parameters
        ----------
        wanted
            Numbers of the joints; None for all.

        Returns
        -------
        tuple of Configuration

        Raises
        ------
        InputError
            Where no run to fit has exactly one free joint.
        """
        single: dict[tuple[int, ...], Configuration] = {}
        for one in configurations_of(self.campaign, self.device, wanted):
            if len(one.free_joints) == 1:
                single.setdefault(one.free_joints, one)
        if not single:
            raise InputError(str(self.campaign.folder), expected="a run to fit with one free joint", got="none")
        return tuple(single.values())
