"""What drives a joint: `Drive` says which quantity is recorded, `Controller` which loop of the firmware makes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

DriveKind = Literal["torque", "current", "voltage", "duty"]
"""Recorded quantity of a drive."""
ControllerKind = Literal["p", "pd", "pid"]
"""Terms of a controller."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """Position loop of a drive's firmware: c = clip(gain·(r − q) − derivative_gain·v + integral_gain·∫(r − q), ±limit).

    Parameters
    ----------
    kind
        ``p``, ``pd`` or ``pid``.
    gain
        Output unit of the drive (N m without a drive) per rad ([1/m] for a prismatic joint), where a run states no
        other.
    limit
        Saturation of c, in the drive's unit.
    derivative_gain
        Drive's unit per rad/s.
    integral_gain
        Drive's unit per rad s.
    """

    kind: ControllerKind
    gain: float
    limit: float
    derivative_gain: float = 0.0
    integral_gain: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """Drive of a joint.

    Parameters
    ----------
    kind
        ``current``, ``voltage``, ``duty``, or ``torque`` (with a controller: without one there is no `Drive`).
    controller
        Loop through which the runs are simulated; None for the open loop.
    """

    kind: DriveKind
    controller: Controller | None = None

    @property
    def is_closed(self) -> bool:
        """Whether the runs are simulated through the controller."""
        return self.controller is not None

    @property
    def commands_torque(self) -> bool:
        """Whether the command is the torque itself: no parameter of a motor stands between them."""
        return self.kind == "torque"
