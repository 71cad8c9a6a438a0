"""Two revisions on the same cases: commits in, the entry of the stored JSON out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from benchmarks.revisions.cases import Case
from benchmarks.revisions.differences import largest_of_numbers
from benchmarks.revisions.merges import result_in_words
from benchmarks.revisions.results import figures_of, result_alone
from benchmarks.revisions.runs import OUTCOME, check_out, commit_of, run_case


def hold_pair(
    revisions: tuple[str, str], cases: Sequence[Case], work: Path, data: Path, packages: Path | None
) -> dict[str, Any]:
    """Run cases with two revisions, one command after the other, and compare what they write.

    Parameters
    ----------
    revisions
        The earlier and the later one.
    cases
        Campaigns and commands.
    work
        Folder of checkouts and results, one folder a commit; what is there already is not run again.
    data
        Folder of the real measurements.
    packages
        Folder with packages that the revisions need beside the present ones; None for none.

    Returns
    -------
    dict
        Entry of ``pairs`` in the stored JSON.
    """
    commits = [commit_of(revision) for revision in revisions]
    folders = [work / commit for commit in commits]
    for commit, folder in zip(commits, folders, strict=True):
        check_out(commit, folder / "tree")
    entries = []
    for case in cases:
        before = _side_of(case, run_case(case, data, folders[0], packages))
        # What the earlier commit does not finish has nothing to be held against.
        after = {"outcome": "not run", "wall_s": 0.0, "result": None}
        if before["result"] is not None:
            after = _side_of(case, run_case(case, data, folders[1], packages))
        entries.append(compare_sides(case.name, before, after))
        click.echo(f"{commits[0]} to {commits[1]}: {result_in_words(entries[-1])}", err=True)
    needed = packages_needed(folders[0] / "tree", packages)
    return {"before": commits[0], "after": commits[1], "date": today(), "packages": needed, "cases": entries}


def packages_needed(tree: Path, packages: Path | None) -> list[str]:
    """Return the packages of a folder that a revision names as its requirements."""
    if packages is None:
        return []
    requirements = (tree / "pyproject.toml").read_text(encoding="utf-8")
    return sorted(path.name for path in packages.iterdir() if f'"{path.name}>=' in requirements)


def compare_sides(name: str, before: dict[str, Any], after: dict[str, Any]) -> dict[str, Any]:
    """Compare what two revisions wrote for one case.

    Parameters
    ----------
    name
        Name of the case.
    before, after
        Each with ``outcome``, ``wall_s`` and ``result``, its JSON without what tells of the run; None for no result.

    Returns
    -------
    dict
        ``case``, ``same``, outcome and wall time of both sides; their figures and the largest relative difference of
        all ``numbers`` where both have a result and these are not the same.
    """
    both = before["result"] is not None and after["result"] is not None
    held: dict[str, Any] = {"case": name, "same": both and before["result"] == after["result"]}
    for key, side in (("before", before), ("after", after)):
        held[key] = {"outcome": side["outcome"], "wall_s": side["wall_s"]}
        if both and not held["same"]:
            held[key]["figures"] = figures_of(side["result"])
    if both and not held["same"]:
        held["numbers"] = asdict(largest_of_numbers(before["result"], after["result"]))
    return held


def _side_of(case: Case, out: Path) -> dict[str, Any]:
    """Return outcome, wall time and the result of a case, without what tells of the run; None for no result."""
    side: dict[str, Any] = json.loads((out / OUTCOME).read_text(encoding="utf-8"))
    side["result"] = None
    if side["outcome"] == "done":
        side["result"] = result_alone(json.loads((out / case.written).read_text(encoding="utf-8")))
    return side


def today() -> str:
    """Return the date (UTC)."""
    return datetime.now(UTC).date().isoformat()
