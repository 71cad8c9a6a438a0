"""`ForeignCampaign`, the frozen value of a campaign about any FMU: runs, and what ``campaign.toml`` says of variables.

Names are those of the FMU's variables. Whether the FMU has them is for its reader to say (`identification.foreign`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from haptid.measurement.values.run import Run


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignCampaign:
    """Hold the runs of one FMU and what ``campaign.toml`` states about its variables.

    Parameters
    ----------
    folder
        Folder from which the campaign was read.
    title
        One line for the head of a report.
    measured
        False for synthetic data; every report says so.
    model
        The FMU.
    inputs, outputs
        Variables in the order of the runs' ``drive_inputs`` and of the columns of their ``y``.
    parameters
        ``{variable: {"initial" | "lower" | "upper" | "fixed": number, "prior": {"mean", "std"}}}``.
    runs
        In the order of ``campaign.toml``. The number of an output stands for a joint, ``drive_inputs`` holds the inputs
        by variable, and ``noise`` is that of each output in its own unit.
    starts
        Start values of a run's own by file and variable.
    noise_given
        Whether the noise of each output is stated; else it was estimated from the rows.
    places
        Place of a table's key in ``campaign.toml``, for errors: ``("parameters", "mu")`` → file, line and key.
    """

    folder: Path
    title: str
    measured: bool
    model: Path
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: Mapping[str, Mapping[str, Any]]
    runs: tuple[Run, ...]
    starts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    noise_given: Mapping[str, bool] = field(default_factory=dict)
    places: Mapping[tuple[str, str], str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """``measured`` or ``synthetic``."""
        return "measured" if self.measured else "synthetic"

    def place(self, section: str, key: str) -> str:
        """Return the place of a table's key in ``campaign.toml``, for errors.

        Parameters
        ----------
        section
            Table of ``campaign.toml``.
        key
            Key within it.

        Returns
        -------
        str
            Place that the reader recorded, else the file with the key's dotted name.
        """
        return self.places.get((section, key), f"{self.folder / 'campaign.toml'}, {section}.{key}")
