"""The commands that a pair of revisions is held on: campaign, command, its JSON and its longest time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.machines.campaigns import copy_campaign, write_emps

EMBEDDED = "embedded"
"""Name of the campaign that comes with the code; every other name is a folder of real measurements."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One command on one campaign.

    Parameters
    ----------
    campaign
        ``embedded``, or the folder of real measurements below the data.
    title
        Campaign and what is computed, as the page names it.
    command
        Module and options, without campaign and output.
    written
        JSON file below the output folder.
    limit_s
        Longest time of the command [s].
    """

    campaign: str
    title: str
    command: tuple[str, ...]
    written: str
    limit_s: float

    @property
    def name(self) -> str:
        """Name of the folder of results, and key of the stored JSON."""
        return f"{self.campaign}_{self.command[0].partition('.')[0]}"

    @property
    def real(self) -> bool:
        """Whether the campaign holds real measurements."""
        return self.campaign != EMBEDDED


FIT = ("identification.run", "--no-export", "--workers", "1")
SEARCH = ("discrepancy.run", "--seed", "3", "--workers", "1")
FIT_LIMIT_S, SEARCH_LIMIT_S = 280.0, 120.0
CASES = (
    Case(
        campaign=EMBEDDED,
        title="embedded campaign, fit of joint 4",
        command=(*FIT, "--joints", "4"),
        written="identification.json",
        limit_s=FIT_LIMIT_S,
    ),
    Case(
        campaign=EMBEDDED,
        title="embedded campaign, search in joint 4",
        command=(*SEARCH, "--joint", "4"),
        written="discrepancy/joint4.json",
        limit_s=SEARCH_LIMIT_S,
    ),
    Case(campaign="emps", title="EMPS, fit", command=FIT, written="identification.json", limit_s=FIT_LIMIT_S),
    Case(
        campaign="emps",
        title="EMPS, search",
        command=(*SEARCH, "--joint", "0"),
        written="discrepancy/joint0.json",
        limit_s=SEARCH_LIMIT_S,
    ),
    Case(
        campaign="dvrk_mtm_joint4",
        title="dVRK joint 4, fit",
        command=FIT,
        written="identification.json",
        limit_s=FIT_LIMIT_S,
    ),
    Case(
        campaign="dvrk_mtm_joint4",
        title="dVRK joint 4, search",
        command=(*SEARCH, "--joint", "4"),
        written="discrepancy/joint4.json",
        limit_s=SEARCH_LIMIT_S,
    ),
)
"""In the order of the page."""

WRITERS: dict[str, Callable[[Path, Path], None]] = {"emps": write_emps, "dvrk_mtm_joint4": copy_campaign}
"""Functions that write the campaigns of real measurements, by folder."""
