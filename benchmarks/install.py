"""How long an installation takes, and how much disk: the first lines that a newcomer types.

``python -m benchmarks.install`` copies the checkout as it is committed, installs it into new environments by ``pip
install .`` without and with pip's cache, and runs README's ``make fmu`` in a new environment with an empty cache of
haptid's, then its other two commands. It writes ``docs/results/install.json``, from which the paragraph of README is
made; ``--page`` writes that again from the stored results. Packages come from the index that pip is set up for here:
over another network the first figure is another one.
"""

from __future__ import annotations

import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import click

from docs.parts.tables import with_parts
from haptid.support.files.files import write_json
from haptid.support.installing.environment import ROOT

STORED = ROOT / "docs" / "results" / "install.json"
SCRIPT = "benchmarks/install.py"


README = {"identify": "python -m identification.run", "test": "make test"}
"""README's commands after ``make fmu``, by their step."""


def readme_text(data: dict[str, Any]) -> str:
    """Write the paragraph of README.

    Parameters
    ----------
    data
        Stored results.

    Returns
    -------
    str
        Markdown.
    """
    first, again, fmus = (data["steps"][name] for name in ("pip", "pip_cached", "make_fmu"))
    return (
        f"Measured on {data['machine']} with Python {data['python']} on {data['date']} (load {data['load'][0]:.1f} at "
        f"the beginning, {data['load'][1]:.1f} at the end): "
        f"`python -m venv` and `pip install .` take {_seconds(first)} and {first['disk_mb']:.0f} MB of disk, "
        f"{_seconds(again)} where pip has the packages already; `make fmu` in a new environment takes "
        f"{_seconds(fmus)}, the installation included, and {fmus['disk_mb']:.0f} MB."
    ) + "".join(
        f" Then `{line}` takes {_seconds(data['steps'][name])}."
        for name, line in README.items()
        if name in data["steps"]
    )


def _seconds(step: dict[str, Any]) -> str:
    return f"{step['wall_s']:.0f} s"


def write_page(data: dict[str, Any]) -> None:
    """Write the paragraph into README.

    Parameters
    ----------
    data
        Stored results.
    """
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    readme.write_text(with_parts(text, {"installation": readme_text(data)}, SCRIPT), encoding="utf-8")


def disk_mb(folder: Path) -> float:
    """Measure how much disk a folder takes.

    Parameters
    ----------
    folder
        Any folder.

    Returns
    -------
    float
        Blocks of its files [MB].
    """
    return sum(path.lstat().st_blocks * 512 for path in folder.rglob("*") if path.is_file()) / 1e6


def _timed(commands: list[list[str]], folder: Path, **environment: str) -> float:
    begun = time.perf_counter()
    for command in commands:
        done = subprocess.run(
            command, cwd=folder, env=os.environ | environment, check=False, capture_output=True, text=True
        )
        if done.returncode:
            sys.exit(f"{' '.join(command)}: {done.stderr[-2000:]}")
    return time.perf_counter() - begun


def measure(work: Path) -> dict[str, Any]:
    """Install in all ways.

    Parameters
    ----------
    work
        Empty folder.

    Returns
    -------
    dict
        Time [s] and disk [MB] by step.
    """
    clone, cache = work / "haptid", str(work / "pip")
    _timed([["git", "clone", "--quiet", str(ROOT), str(clone)]], work)
    steps = {}
    for name in ("pip", "pip_cached"):
        place = work / name
        python = str(place / "bin" / "python")
        commands = [[sys.executable, "-m", "venv", str(place)], [python, "-m", "pip", "install", "--quiet", "."]]
        steps[name] = {"wall_s": _timed(commands, clone, PIP_CACHE_DIR=cache), "disk_mb": disk_mb(place)}
        click.echo(f"{name}: {steps[name]}")
    place = work / "make"
    commands = [
        [sys.executable, "-m", "venv", str(place)],
        ["make", "fmu", f"PYTHON={place / 'bin' / 'python'}"],
    ]
    fresh = {"PIP_CACHE_DIR": str(work / "none"), "HAPTID_CACHE": str(work / "cache")}
    steps["make_fmu"] = {
        "wall_s": _timed(commands, clone, **fresh),
        "disk_mb": disk_mb(place) + disk_mb(work / "cache"),
    }
    click.echo(f"make fmu: {steps['make_fmu']}")
    python = str(place / "bin" / "python")
    lines = {"identify": [python, "-m", "identification.run", "--quiet"], "test": ["make", "test", f"PYTHON={python}"]}
    for name, line in lines.items():
        steps[name] = {"wall_s": _timed([line], clone, **fresh)}
        click.echo(f"{README[name]}: {steps[name]}")
    return steps


@click.command(help=__doc__)
@click.option("--page", is_flag=True, help="Write README's paragraph from the stored results, and run nothing.")
def main(*, page: bool) -> None:
    if not page:
        load = os.getloadavg()
        with tempfile.TemporaryDirectory() as work:
            steps = measure(Path(work))
        write_json(STORED, {
            "command": "python -m benchmarks.install",
            "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
            "machine": f"{os.cpu_count()} cores, {platform.machine()}", "python": platform.python_version(),
            "load": [round(one, 2) for one in (load[0], os.getloadavg()[0])], "steps": steps,
        })  # fmt: skip
    write_page(json.loads(STORED.read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
