"""What a newcomer meets: ``python -m benchmarks.front_door``.

It counts the pages of the documentation and the blocks of code on them that tests run or check. Then it takes three
commands from raw tables and a URDF of an arm (`benchmarks.simulators.newcomer_arm`) to an FMU in a second tool, times
each, and measures size and load of the report in headless Chromium, where axe-core examines the report and the built
documentation on a wide screen and on a phone. It writes ``docs/results/front_door.json``, which
``docs/results/performance.md`` shows.
"""

from __future__ import annotations

import datetime
import itertools
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from benchmarks.performance.figures import read_stored
from benchmarks.simulators.newcomer_arm import write_tables
from docs.accessibility import SCHEMES, WIDTHS, examine_pages
from docs.parts.shown_code import blocks_of
from haptid.support.files.files import write_json
from haptid.support.installing.environment import ROOT

STORED = ROOT / "docs" / "results" / "front_door.json"
LANGUAGES = ("bash", "python", "toml")
"""Languages of the blocks that tests run, compile or read."""
SIMULATE = (
    "import sys, fmpy; r = fmpy.simulate_fmu(sys.argv[1], stop_time=1.0, output_interval=0.001); assert len(r) == 1001"
)
"""The second tool: FMPy simulates a second."""


def count_pages() -> dict[str, int]:
    """Count the pages, and the blocks of code on them by language.

    Returns
    -------
    dict
        ``pages``, and a number a language.
    """
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    blocks = {language: sum(len(blocks_of(page, language)) for page in pages) for language in LANGUAGES}
    return {"pages": len(pages), **blocks}


def measure_report(report: Path) -> dict[str, float]:
    """Measure how large a report is, and how long headless Chromium takes until it has loaded it.

    Parameters
    ----------
    report
        HTML file.

    Returns
    -------
    dict
        ``size_MB``, and ``load_s``, the median of five loads.
    """
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 # a dependency of development alone

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        seconds = []
        for _ in range(5):
            page = browser.new_page()
            begun = time.perf_counter()
            page.goto(report.resolve().as_uri())
            page.wait_for_load_state("load")
            seconds.append(time.perf_counter() - begun)
            page.close()
        browser.close()
    return {"size_MB": report.stat().st_size / 1e6, "load_s": sorted(seconds)[2]}


def count_violations(pages: Sequence[Path]) -> dict[str, Any]:
    """Count what axe-core finds on pages, on a wide screen in light colours and on a phone in dark ones.

    Parameters
    ----------
    pages
        HTML files.

    Returns
    -------
    dict
        Number of ``pages``, and ``violations`` by the width of the screen [px].
    """
    views = tuple(zip(WIDTHS, SCHEMES, strict=True))
    found = dict.fromkeys(map(str, WIDTHS), 0)
    for violation in itertools.chain.from_iterable(examine_pages(pages, views)):
        found[str(violation.width)] += 1
        click.echo(f"{violation.page} at {violation.width} px: {violation.rule}")
    return {"pages": len(pages), "violations": found}


def examine_documentation() -> dict[str, Any]:
    """Build the documentation, and count what axe-core finds on its pages, as `count_violations` returns it."""
    with tempfile.TemporaryDirectory() as site:
        subprocess.run([sys.executable, "-m", "docs.build", "--out", site], cwd=ROOT, check=True, capture_output=True)
        return count_violations(sorted(Path(site).rglob("*.html")))


def measure_arm(tables: Path, work: Path) -> dict[str, Any]:
    """Take tables and a URDF to an FMU in a second tool.

    Parameters
    ----------
    tables
        Folder with tables and one URDF.
    work
        Empty folder.

    Returns
    -------
    dict
        ``commands`` with their seconds, one after the other with no edit between them, ``tables``, and the report's
        figures.
    """
    (device,) = tables.glob("*.urdf")
    haptid = [sys.executable, "-m", "haptid"]
    lines = {
        "haptid init": [*haptid, "init", str(tables), "--device", str(device), "--yes", "--out", "campaign"],
        "haptid identify": [*haptid, "identify", "campaign", "--out", "results", "--quiet"],
        "FMPy simulates the FMU": [sys.executable, "-c", SIMULATE, f"results/{_name_of(device)}.fmu"],
    }
    seconds = {}
    for name, line in lines.items():
        begun = time.perf_counter()
        subprocess.run(line, cwd=work, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True, capture_output=True)
        seconds[name] = time.perf_counter() - begun
        click.echo(f"{name}: {seconds[name]:.1f} s")
    count = len(list(tables.glob("*.csv")))
    report = work / "results" / "report.html"
    return {"commands": seconds, "tables": count, "report": measure_report(report), "axe": count_violations([report])}


def _name_of(device: Path) -> str:
    """Return the name that a URDF states, which the FMU of the device has."""
    return device.read_text(encoding="utf-8").partition('robot name="')[2].partition('"')[0]


@click.command(help=__doc__)
@click.option("--arm/--no-arm", default=True, show_default=True, help="Whether the arm is brought in, in some minutes.")
@click.option(
    "--axe/--no-axe", default=True, show_default=True, help="Whether the documentation is built and examined."
)
def main(*, arm: bool, axe: bool) -> None:
    """Measure, and store."""
    stored = read_stored(STORED.name) or {}
    stored |= {
        "command": "python -m benchmarks.front_door",
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "machine": f"{os.cpu_count()} cores, {platform.machine()}",
        "documentation": count_pages(),
    }
    if axe:
        stored["axe"] = stored.get("axe", {}) | {"documentation": examine_documentation() | {"date": stored["date"]}}
    if arm:
        with tempfile.TemporaryDirectory() as tables, tempfile.TemporaryDirectory() as work:
            write_tables(Path(tables))
            begun = os.getloadavg()[0]
            stored["arm"] = measure_arm(Path(tables), Path(work))
        stored["axe"] = stored.get("axe", {}) | {"report": stored["arm"].pop("axe") | {"date": stored["date"]}}
        stored["arm"] |= {"load": [round(one, 1) for one in (begun, os.getloadavg()[0])], "date": stored["date"]}
    write_json(STORED, stored)


if __name__ == "__main__":
    main()
