"""Do two revisions give the same results? Both run the same commands; every file that they write is compared.

What a move of modules must not change: the locking plan, the FMU of a locked joint, fits, a posterior and a verdict,
each with a fixed seed. Dates, durations, versions and the command line are left out of JSON; the rest must agree to
the last bit. Pages (HTML, and their stored content) show dates and durations and are not compared.

``--merge COMMIT`` holds a commit against the one before it on other cases: fit and search in joint 4 of the embedded
campaign and of two sets of real measurements (`benchmarks.revisions.cases`; the folder of the measurements is that of
`benchmarks.real_machines`). Results that are not the same are compared by their figures.

``--json`` keeps the outcome beside others in that file, and writes the page that shows them all; ``--page`` writes the
page alone.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.revisions.cases import CASES
from benchmarks.revisions.merges import merges_section
from benchmarks.revisions.pairs import hold_pair, today
from benchmarks.revisions.results import result_alone
from benchmarks.revisions.runs import check_out, commit_of, environment_of
from haptid.report.common.stored_page import FOLDER
from haptid.support.files.files import write_json
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import read_truth
from tests.real_data import DATA

COMMANDS = {
    "plan": ("model.plan",),
    "fmu": ("fmu_build.run", "--joints", "4"),
    "fits": ("identification.run", "--joints", "4,5"),
    "posterior": ("uq.run", "--joints", "4", "--quick", "--seed", "3"),
    "verdict": ("discrepancy.run", "--joint", "4", "--seed", "3"),
}
"""Folder of the results: the command that writes them."""
JOINT = 4
"""Joint of the embedded campaign that pairs of commits are held on."""

INTRODUCTION = """# Are the results still the same?

Modules that move and code that is merged must leave results as they were. Compared are the files that the same commands
write before and after: the locking plan, an FMU, fits of joints 4 and 5 of the embedded campaign, a posterior and a
verdict of joint 4 with a fixed seed. JSON is compared without what tells of the run (dates, durations, versions, the
command), all other files byte for byte. Pages show dates and are left out.

"""


def run(revision: str, folder: Path) -> str:
    """Check a revision out, run the commands below ``folder``; return the commit."""
    tree = folder / "tree"
    check_out(revision, tree)
    for name, command in COMMANDS.items():
        click.echo(f"{revision}: {' '.join(command)}", err=True)
        arguments = [sys.executable, "-m", *command, "--out", str(folder / "results" / name), "--quiet"]
        environment = environment_of(folder, None)
        subprocess.run(arguments, cwd=tree, env=environment, check=True, stdout=subprocess.DEVNULL)
    return commit_of(revision)


def content(path: Path) -> object:
    """Return what of a file must agree: JSON without what tells of the run, an archive by its entries, or bytes."""
    if path.suffix == ".json":
        return result_alone(json.loads(path.read_text(encoding="utf-8")))
    if path.suffix == ".fmu":
        with zipfile.ZipFile(path) as archive:
            # macOS binaries hold the folder they were linked in
            return {name: archive.read(name) for name in archive.namelist() if not name.endswith(".dylib")}
    return path.read_bytes()


def compare(before: Path, after: Path) -> dict[str, str]:
    """Return the outcome file by file: same, differs, or missing on one side."""
    names = {
        path.relative_to(side).as_posix()
        for side in (before, after)
        for path in side.rglob("*")
        if path.is_file() and path.suffix != ".html" and path.parent.name != FOLDER
    }
    outcome = {}
    for name in sorted(names):
        both = (before / name).is_file() and (after / name).is_file()
        same = both and content(before / name) == content(after / name)
        outcome[name] = "same" if same else "differs" if both else "missing on one side"
    return outcome


def page_of(stored: dict[str, Any]) -> str:
    """Return the page of stored comparisons and merges."""
    lines = [INTRODUCTION]
    for one in stored["comparisons"]:
        files = one["files"]
        same = sum(outcome == "same" for outcome in files.values())
        lines.append(f"## {one['title']}\n\n")
        lines.append(
            f"`{one['command']}`, {one['date']}: {same} of {len(files)} files are the same. {one['remark']}\n\n"
        )
        folders = sorted({name.partition("/")[0] for name in files})
        lines.append("| folder | written by | files | the same | differing |\n| --- | --- | ---: | ---: | --- |\n")
        for folder in folders:
            inside = {name: outcome for name, outcome in files.items() if name.startswith(f"{folder}/")}
            differing = [f"`{name}` ({outcome})" for name, outcome in inside.items() if outcome != "same"]
            command = " ".join(("python -m", *COMMANDS[folder]))
            counts = f"{len(inside)} | {len(inside) - len(differing)}"
            lines.append(f"| `{folder}/` | `{command}` | {counts} | {', '.join(differing) or 'none'} |\n")
        lines.append("\n")
    lines.append(merges_section(stored))
    return "".join(lines)


def keep_pair(path: Path, pair: dict[str, Any]) -> None:
    """Keep what was measured of a pair of commits, case by case in the place of what was, and write the page."""
    stored = stored_in(path)
    others = [one for one in stored["pairs"] if one["after"] != pair["after"]]
    earlier = [one for one in stored["pairs"] if one["after"] == pair["after"]]
    held = {case["case"]: case for one in (*earlier, pair) for case in one["cases"]}
    pair = pair | {"cases": [held[case.name] for case in CASES if case.name in held]}
    order = [merge["commit"] for merge in stored["merges"]]
    stored["pairs"] = sorted(
        [*others, pair], key=lambda one: order.index(one["after"]) if one["after"] in order else -1
    )
    stored["truth"] = Arm(read_truth()).locked_joint(JOINT, np.zeros(6))
    write_json(path, stored)
    path.with_suffix(".md").write_text(page_of(stored), encoding="utf-8")


def stored_in(path: Path) -> dict[str, Any]:
    """Return the stored outcomes of a file; empty ones where there is none."""
    empty: dict[str, Any] = {"comparisons": [], "merges": [], "pairs": [], "truth": {}}
    return empty | json.loads(path.read_text(encoding="utf-8")) if path.is_file() else empty


def keep(path: Path, comparison: dict[str, Any]) -> None:
    """Keep a comparison in a file, in the place of one of the same commits, and write its page."""
    stored = stored_in(path)
    kept = stored["comparisons"]
    places = [k for k, one in enumerate(kept) if one["command"] == comparison["command"]]
    if places:  # title and remark were written by hand
        kept[places[0]] |= comparison
    else:
        kept.append({"title": f"Commits {comparison['before']} and {comparison['after']}", "remark": ""} | comparison)
    write_json(path, stored)
    path.with_suffix(".md").write_text(page_of(stored), encoding="utf-8")


@click.command()
@click.option("--before", default="HEAD~1", show_default=True, help="Revision to compare with.")
@click.option("--after", default="HEAD", show_default=True, help="Revision that is compared.")
@click.option("--merge", default=None, metavar="COMMIT", help="Hold a commit against the one before it on all cases.")
@click.option("--work", type=click.Path(path_type=Path, file_okay=False), help="Keep checkouts and results here.")
@click.option("--cases", default="", metavar="CASE,CASE", help="Hold a merge on these cases alone.")
@click.option("--packages", type=click.Path(path_type=Path, exists=True), help="Packages that old revisions need.")
@click.option("--json", "stored", type=click.Path(path_type=Path, dir_okay=False), help="Keep the outcome here.")
@click.option("--page", type=click.Path(path_type=Path, exists=True), help="Write the page of these stored outcomes.")
def main(before: str, after: str, merge: str | None, stored: Path | None, page: Path | None, **choices: Any) -> None:
    """Run two revisions and compare what they write; exit 1 where anything differs."""
    if page is not None:
        page.with_suffix(".md").write_text(page_of(stored_in(page)), encoding="utf-8")
        return
    with tempfile.TemporaryDirectory() as folder:
        if merge is not None:
            named = choices["cases"].split(",")
            cases = [case for case in CASES if case.name in named or not choices["cases"]]
            work = choices["work"] or Path(folder)
            pair = hold_pair((f"{merge}~1", merge), cases, work, DATA, choices["packages"])
            if stored is not None:
                keep_pair(stored, pair)
            sys.exit(not all(held["same"] for held in pair["cases"]))
        sides = [Path(folder) / "before", Path(folder) / "after"]
        commits = [run(revision, side) for revision, side in zip((before, after), sides, strict=True)]
        outcome = compare(*(side / "results" for side in sides))
    for name, agreement in outcome.items():
        click.echo(f"{agreement:22s}{name}")
    differing = [name for name, agreement in outcome.items() if agreement != "same"]
    click.echo(f"{len(outcome) - len(differing)} of {len(outcome)} files are the same in {commits[0]} and {commits[1]}")
    if stored is not None:
        command = f"python -m benchmarks.same_results --before {commits[0]} --after {commits[1]}"
        ends = {"before": commits[0], "after": commits[1]}
        keep(stored, {"command": command, "date": today(), **ends, "files": outcome})
    sys.exit(bool(differing))


if __name__ == "__main__":
    main()
