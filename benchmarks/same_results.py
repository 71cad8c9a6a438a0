"""Do two revisions give the same results? Both run the same commands; every file that they write is compared.

What a move of modules must not change: the locking plan, the FMU of a locked joint, fits, a posterior and a verdict,
each with a fixed seed. Dates, durations, versions and the command line are left out of JSON; the rest must agree to
the last bit. Pages (HTML, and their stored content) show dates and durations and are not compared.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from haptid.report.common.stored_page import FOLDER
from haptid.support.files.files import write_json
from haptid.support.installing.environment import ROOT

COMMANDS = {
    "plan": ("model.plan",),
    "fmu": ("fmu_build.run", "--joints", "4"),
    "fits": ("identification.run", "--joints", "4,5"),
    "posterior": ("uq.run", "--joints", "4", "--quick", "--seed", "3"),
    "verdict": ("discrepancy.run", "--joint", "4", "--seed", "3"),
}
"""Folder of the results: the command that writes them."""
TOLD = {"code", "command", "data", "date", "inputs", "software", "version", "wall_s"}
"""Keys of JSON that tell of the run, not of its result; three of them hold the digest of the code."""


def run(revision: str, folder: Path) -> str:
    """Check a revision out, run the commands below ``folder``; return the commit."""
    tree = folder / "tree"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(tree)], check=True)
    subprocess.run(["git", "checkout", "--quiet", revision], cwd=tree, check=True)
    environment = {**os.environ, "HAPTID_CACHE": str(folder / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    for name, command in COMMANDS.items():
        click.echo(f"{revision}: {' '.join(command)}", err=True)
        arguments = [sys.executable, "-m", *command, "--out", str(folder / "results" / name), "--quiet"]
        subprocess.run(arguments, cwd=tree, env=environment, check=True, stdout=subprocess.DEVNULL)
    done = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=tree, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def content(path: Path) -> object:
    """Return what of a file must agree: JSON without what tells of the run, an archive by its entries, or bytes."""
    if path.suffix == ".json":
        return told_apart(json.loads(path.read_text(encoding="utf-8")))
    if path.suffix == ".fmu":
        with zipfile.ZipFile(path) as archive:
            # macOS binaries hold the folder they were linked in
            return {name: archive.read(name) for name in archive.namelist() if not name.endswith(".dylib")}
    return path.read_bytes()


def told_apart(value: Any) -> Any:
    """Return JSON without the keys that tell of the run."""
    if isinstance(value, dict):
        return {key: told_apart(v) for key, v in value.items() if key not in TOLD}
    return [told_apart(v) for v in value] if isinstance(value, list) else value


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


@click.command()
@click.option("--before", default="HEAD~1", show_default=True, help="Revision to compare with.")
@click.option("--after", default="HEAD", show_default=True, help="Revision that is compared.")
@click.option("--json", "stored", type=click.Path(path_type=Path, dir_okay=False), help="Keep the outcome here.")
def main(before: str, after: str, stored: Path | None) -> None:
    """Run two revisions and compare what they write; exit 1 where anything differs."""
    with tempfile.TemporaryDirectory() as folder:
        sides = [Path(folder) / "before", Path(folder) / "after"]
        commits = [run(revision, side) for revision, side in zip((before, after), sides, strict=True)]
        outcome = compare(*(side / "results" for side in sides))
    for name, told in outcome.items():
        click.echo(f"{told:22s}{name}")
    differing = [name for name, told in outcome.items() if told != "same"]
    click.echo(f"{len(outcome) - len(differing)} of {len(outcome)} files are the same in {commits[0]} and {commits[1]}")
    if stored is not None:
        command = f"python -m benchmarks.same_results --before {commits[0]} --after {commits[1]}"
        date = datetime.now(UTC).date().isoformat()
        write_json(stored, {"command": command, "date": date, "files": outcome})
    sys.exit(bool(differing))


if __name__ == "__main__":
    main()
