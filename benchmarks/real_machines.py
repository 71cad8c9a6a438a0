"""All sets of real measurements by the usual commands, next to what was published about them.

``python -m benchmarks.real_machines [DATA]`` writes a campaign from each set below the folder DATA, runs
``identification.run`` and ``discrepancy.run`` on it with their defaults, and writes a picture a set and
``docs/results/real_machines.json``, from which ``docs/results/real_machines.md`` and the paragraph of README are made.
Without DATA the folder ``../shared/data`` beside the checkout or that of HAPTID_DATA is taken. ``--only`` runs some
sets anew and keeps the stored entries of the others; ``--page`` writes the pages again from the stored results.
"""

from __future__ import annotations

import datetime
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import click

from benchmarks.machines.evaluate import evaluate
from benchmarks.machines.page import page_of, readme_text
from benchmarks.machines.sets import SETS
from docs.parts.tables import with_parts
from haptid.support.installing.environment import ROOT
from tests.real_data import DATA

RESULTS = ROOT / "docs" / "results"
STORED = RESULTS / "real_machines.json"
WORK = ROOT / ".cache" / "real_machines"


def write_pages(data: dict[str, Any]) -> None:
    STORED.with_suffix(".md").write_text(page_of(data), encoding="utf-8")
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    parts = {"real machines": readme_text(data)}
    readme.write_text(with_parts(text, parts, "benchmarks/real_machines.py"), encoding="utf-8")


def version_of_code() -> str:
    asked = ("git", "rev-parse", "--short=12", "HEAD")
    done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


@click.command(help=__doc__)
@click.argument("data", type=click.Path(path_type=Path), default=DATA)
@click.option("--only", default="", metavar="SET,SET", help="Run these sets alone.")
@click.option("--limit", default=300.0, show_default=True, help="Longest time of one command [s].")
@click.option("--page", is_flag=True, help="Write the pages from the stored results, and run nothing.")
def main(data: Path, only: str, limit: float, *, page: bool) -> None:
    stored: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {"sets": []}
    if page:
        write_pages(stored)
        return
    if not data.is_dir():
        click.echo(f"real machines: no measurements in {data}; HAPTID_DATA names another folder", err=True)
        sys.exit(2)
    chosen = set(only.split(",")) if only else {machine.folder for machine in SETS}
    entries = {entry["folder"]: entry for entry in stored["sets"]}
    for machine in SETS:
        if machine.folder not in chosen:
            continue
        if not (data / machine.folder).is_dir():
            click.echo(f"{machine.folder}: not in {data}, its stored figures stay", err=True)
            continue
        click.echo(f"== {machine.title}")
        done = evaluate(machine, data, WORK, limit)
        version = {"date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(), "version": version_of_code()}
        entries[machine.folder] = done.entry | version
        if done.picture is not None:
            (RESULTS / done.entry["picture"]).write_bytes(done.picture)
        for figure in done.entry["figures"]:
            click.echo(f"{figure['name']}: {figure['reached']} {figure['unit']} (aim {figure['aim']})")
        result = {
            "schema": "real_machines/1",
            **version,
            "command": "python -m benchmarks.real_machines",
            "cores": os.cpu_count(),
            "limit_s": limit,
            "sets": [entries[one.folder] for one in SETS if one.folder in entries],
        }
        STORED.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        write_pages(result)


if __name__ == "__main__":
    main()
