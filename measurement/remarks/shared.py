"""Write remarks that several runs share as one line: files, joints and sentences in, lines out."""

from __future__ import annotations

from collections.abc import Iterable

MOST_NAMED = 3
"""Most runs of a remark that stand in its line by their names; of more, two do, beside their number."""
MANY = 2
"""Number of runs beyond which a remark on all of them says so."""


def tell_shared(remarks: Iterable[tuple[str, str, str]], every: int) -> list[str]:
    """Write one line a sentence and group of joints, for all runs that share it.

    Parameters
    ----------
    remarks
        File, joint and sentence of each remark.
    every
        Number of runs of the campaign.

    Returns
    -------
    list of str
        As ``a.csv, joint 0, 1: …``, ``all 12 runs, joint 0: …`` or ``5 of 12 runs (a.csv, b.csv, …), joint 0: …``, in
        the order of their first places.
    """
    joints: dict[tuple[str, str], list[str]] = {}
    for file, joint, sentence in remarks:
        joints.setdefault((file, sentence), []).append(joint)
    files: dict[tuple[str, str], list[str]] = {}
    for (file, sentence), names in joints.items():
        files.setdefault((", ".join(names), sentence), []).append(file)
    return [f"{_name_runs(where, every)}, joint {names}: {sentence}" for (names, sentence), where in files.items()]


def _name_runs(files: list[str], every: int) -> str:
    if len(files) == every > MANY:
        return f"all {every} runs"
    if len(files) <= MOST_NAMED:
        return ", ".join(files)
    return f"{len(files)} of {every} runs ({', '.join(files[:2])}, …)"
