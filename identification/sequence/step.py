"""One fitted configuration of a campaign."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.identification.links.consistency import Agreement
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.configurations import Configuration


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A configuration with its fit; ``torque_scored`` tells that the torque was fitted, with the motion as input."""

    configuration: Configuration
    fit: Fit
    torque_scored: bool = False
    agreements: tuple[Agreement, ...] = ()
