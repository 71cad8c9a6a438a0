"""The fixed cases of the study: what is hidden in each, which program makes it and which one works it through.

Nothing here reads a threshold. The seeds are the panel's own; no stored blind study has them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

MAKING, WORK = "studies.thresholds.making", "studies.thresholds.work"
SEED = 70_001
"""Of all cases."""
ENTRIES = ("cubic_spring", "cogging", "time_delay", "end_stop", "viscous_drift")
"""Entries of the catalogue that the searches in the position have: few, so that a run is short."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A case of the panel.

    Parameters
    ----------
    name
        In a table.
    words
        What is hidden, and what is done with it.
    make, work
        Functions as ``module:name``. The first takes a folder and ``hidden`` and writes a campaign there; the second
        takes the folder of the campaign, a folder for results and ``given`` and returns an outcome.
    hidden, given
        Arguments of both by name, as JSON can hold them.
    """

    name: str
    words: str
    make: str
    work: str
    hidden: Mapping[str, Any] = field(default_factory=dict)
    given: Mapping[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Convert to an entry of ``panel`` in the study's JSON.

        Returns
        -------
        dict
            All fields by name.
        """
        return asdict(self)


def _search(name: str, words: str, entries: tuple[str, ...] = ENTRIES, **hidden: Any) -> Case:
    return Case(
        name=name,
        words=f"search in the position: {words}",
        make=f"{MAKING}:make_free",
        work=f"{WORK}:search_joint",
        hidden={"seed": SEED, **hidden},
        given={"entries": list(entries)},
    )


NOTHING: Mapping[str, Any] = {"kind": "none", "effects": [], "size": "none"}
PANEL = (
    _search("clean", "nothing hidden", **NOTHING),
    Case(
        name="fit",
        words="fit of the position, with its plain model and intervals by profiles: nothing hidden",
        make=f"{MAKING}:make_free",
        work=f"{WORK}:identify",
        hidden={"seed": SEED, **NOTHING},
    ),
    _search("small", "a cubic spring near the threshold", kind="single", effects=["cubic_spring"], size="threshold"),
    _search("one", "cogging of nominal size", kind="single", effects=["cogging"], size="nominal"),
    _search(
        "scatter", "amplitude of the torque that scatters from cycle to cycle", (*ENTRIES[:2], "amplitude_scatter"),
        kind="scatter", effects=["amplitude_scatter"], size="nominal",
    ),
    Case(
        name="driven",
        words="search in the torque of a joint under position control: cogging",
        make=f"{MAKING}:make_controlled",
        work=f"{WORK}:search_joint",
        hidden={"seed": SEED, "cogging": 0.01},
        given={"entries": ["cogging", "cubic_spring", "time_delay", "viscous_drift"]},
    ),
    _search(
        "two", "a cubic spring and cogging of nominal size", kind="pair", effects=["cubic_spring", "cogging"],
        size="nominal",
    ),
    _search(
        "unlisted", "cogging, which the catalogue lacks", ("viscous_drift", "time_delay"), kind="single",
        effects=["cogging"], size="nominal",
    ),
    Case(
        name="posterior",
        words="posterior of the clean joint by short chains",
        make=f"{MAKING}:make_free",
        work=f"{WORK}:infer_posterior",
        hidden={"seed": SEED, **NOTHING},
    ),
)  # fmt: skip
"""In the order in which they are run: first what needs least time and what lies near a decision."""
