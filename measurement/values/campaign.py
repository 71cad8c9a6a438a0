"""`Campaign`, the frozen value that `measurement.format.reading` makes of a folder: the runs of one device.

It holds the runs and the statements of ``campaign.toml`` about them: device, friction laws, stated parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from haptid.measurement.values.run import Hold, Run, Use
from haptid.model.device.device import Device
from haptid.model.equations.drive import Drive


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """Hold the runs of one device and what ``campaign.toml`` states about them.

    Parameters
    ----------
    folder
        Folder from which the campaign was read.
    title
        One line for the head of a report.
    device
        Name of a built-in device, ``single_joint``, or the path of a device TOML; where ``loaded`` is
        there, only words for a reader.
    measured
        False for synthetic data; every report says so.
    hold
        Torque between two rows, for runs that state nothing else: ``zero`` holds it, ``linear`` interpolates it.
    runs
        In the order of ``campaign.toml``.
    parameter_overrides
        ``{joint: {parameter: {"initial" | "lower" | "upper" | "fixed": number, "prior": {"mean", "std"}}}}``,
        in SI units.
    friction
        Friction law by joint; a joint that is not listed has the law of the device.
    drives
        Drive by joint; the torque is the input of a joint that is not listed.
    torque_constants
        Torque per ampere [N m/A] (force [N/A]) by joint, where a joint's table states it beside its columns.
    noise_given
        Whether the campaign states the sensor noise of every run. Where False, noise is estimated from the rows.
    remarks
        Sentences on likely slips in the data, for reports; `campaign_for_command` fills them in.
    loaded
        Device that a program handed over; None where ``device`` says which to load.
    extra
        Tables and keys that this package keeps without reading them (``source``, ``note``, …).
    """

    folder: Path
    title: str
    device: str
    measured: bool
    hold: Hold = "zero"
    runs: tuple[Run, ...]
    parameter_overrides: Mapping[int, Mapping[str, Mapping[str, Any]]] = field(default_factory=dict)
    friction: Mapping[int, str] = field(default_factory=dict)
    drives: Mapping[int, Drive] = field(default_factory=dict)
    torque_constants: Mapping[int, float] = field(default_factory=dict)
    noise_given: bool = False
    remarks: tuple[str, ...] = ()
    loaded: Device | None = None
    extra: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """``measured`` or ``synthetic``."""
        return "measured" if self.measured else "synthetic"

    @property
    def configurations(self) -> tuple[tuple[int, ...], ...]:
        """Distinct sets of free joints: smaller sets first, sets of one size in ascending order."""
        return tuple(sorted({run.free_joints for run in self.runs}, key=lambda joints: (len(joints), joints)))

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints that some run frees alone, ascending."""
        return tuple(joints[0] for joints in self.configurations if len(joints) == 1)

    def runs_of(self, free_joints: tuple[int, ...], use: Use | None = None) -> tuple[Run, ...]:
        """Return the runs of one configuration.

        Parameters
        ----------
        free_joints
            Joints that the runs free, in any order; a run must free exactly these.
        use
            ``fit``, ``validate`` or ``excluded``; None for runs of any use.

        Returns
        -------
        tuple of Run
            In the order of ``campaign.toml``; empty where there is none.
        """
        wanted = tuple(sorted(free_joints))
        return tuple(run for run in self.runs if run.free_joints == wanted and use in (None, run.use))

    def but(self, **changes: Any) -> Campaign:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Campaign
            The copy.
        """
        return replace(self, **changes)
