"""A measurement campaign: runs of one device, with what the user said about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from haptid.measurement.values.run import Hold, Run, Use


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """Runs and their circumstances, as read from a folder.

    Parameters
    ----------
    folder
        Where it was read from.
    title
        One line for the head of a report.
    device
        Name of a built-in device, ``single_joint``, or the path of a device TOML.
    measured
        False for synthetic data; every report says so.
    hold
        How torque runs between rows, unless a run says otherwise.
    runs
        In the order of ``campaign.toml``.
    parameter_overrides
        ``{joint: {parameter: {"initial" | "lower" | "upper" | "fixed": number, "prior": {"mean", "std"}}}}``.
    friction
        Friction law by joint where the campaign names one; the device's otherwise.
    noise_given
        Whether the campaign states the sensor noise of every run; else it is estimated from the data.
    remarks
        Sentences on what looks like a slip in it, for reports; filled in for commands.
    extra
        Tables and keys that nothing here interprets (``source``, ``note``, …).
    """

    folder: Path
    title: str
    device: str
    measured: bool
    hold: Hold = "zero"
    runs: tuple[Run, ...]
    parameter_overrides: Mapping[int, Mapping[str, Mapping[str, Any]]] = field(default_factory=dict)
    friction: Mapping[int, str] = field(default_factory=dict)
    noise_given: bool = False
    remarks: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """``measured`` or ``synthetic``."""
        return "measured" if self.measured else "synthetic"

    @property
    def configurations(self) -> tuple[tuple[int, ...], ...]:
        """Distinct sets of free joints, the smaller sets first, each in ascending order."""
        return tuple(sorted({run.free_joints for run in self.runs}, key=lambda joints: (len(joints), joints)))

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints that some run frees alone, ascending."""
        return tuple(joints[0] for joints in self.configurations if len(joints) == 1)

    def runs_of(self, free_joints: tuple[int, ...], use: Use | None = None) -> tuple[Run, ...]:
        """Return the runs with exactly these free joints, and of this use where one is named."""
        wanted = tuple(sorted(free_joints))
        return tuple(run for run in self.runs if run.free_joints == wanted and use in (None, run.use))

    def but(self, **changes: Any) -> Campaign:
        """Return a copy with ``changes``."""
        return replace(self, **changes)
