"""Do two revisions give the same results? Both run the same commands; every file that they write is compared.

What a move of modules must not change: the locking plan, the FMU of a locked joint, fits, a posterior and a verdict,
each with a fixed seed. Dates, durations, versions and the command line are left out of JSON; the rest must agree to
the last bit. Pages (HTML, and their stored content) show dates and durations and are not compared.

``--json`` keeps the outcome beside others in that file, and writes the page that shows them all; ``--page`` writes the
page alone.
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


INTRODUCTION = """# Are the results still the same?

Modules that move and code that is merged must leave results as they were. Compared are the files that the same commands
write before and after: the locking plan, an FMU, fits of joints 4 and 5 of the embedded campaign, a posterior and a
verdict of joint 4 with a fixed seed. JSON is compared without what tells of the run (dates, durations, versions, the
command), all other files byte for byte. Pages show dates and are left out.

"""


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
    lines.append("## Merges\n\nWhat each merge was held against, before the code that it replaces went. ")
    lines.append("Where there is no record, nothing was kept of a comparison. The real sets take a quarter of an ")
    lines.append("hour, and were run on the merged code afterwards only: [real machines](real_machines.md).\n\n")
    lines.append("| merge | commit | held against what it replaces | on the real sets |\n| --- | --- | --- | --- |\n")
    for merge in stored["merges"]:
        lines.append(f"| {merge['merge']} | {merge['commit']} | {merge['held']} | {merge['real']} |\n")
    return "".join(lines)


def keep(path: Path, comparison: dict[str, Any]) -> None:
    """Keep a comparison in a file, in the place of one of the same commits, and write its page."""
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"comparisons": [], "merges": []}
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
@click.option("--json", "stored", type=click.Path(path_type=Path, dir_okay=False), help="Keep the outcome here.")
@click.option("--page", type=click.Path(path_type=Path, exists=True), help="Write the page of these stored outcomes.")
def main(before: str, after: str, stored: Path | None, page: Path | None) -> None:
    """Run two revisions and compare what they write; exit 1 where anything differs."""
    if page is not None:
        text = page_of(json.loads(page.read_text(encoding="utf-8")))
        page.with_suffix(".md").write_text(text, encoding="utf-8")
        return
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
        ends = {"before": commits[0], "after": commits[1]}
        keep(stored, {"command": command, "date": date, **ends, "files": outcome})
    sys.exit(bool(differing))


if __name__ == "__main__":
    main()
