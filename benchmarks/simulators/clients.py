"""Clients of FMUs on the reference runs of the FMUs: which ran, in which version, and how far any output was off.

Every locked joint, the coupled pair and the whole device, in the packagings that a client takes; each run in a process
of its own. A client that is not installed is stored with the reason. fmuloader is no development package, since it
states no licence and the lock takes none that does not: add it by ``uv pip install fmuloader==0.1.2rc0``. Results go to
``docs/results/clients.json`` and to the page on other simulators.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any

import click
from fmpy.validation import validate_fmu

from benchmarks.simulators import page, whole
from benchmarks.simulators.drivers import CLIENTS, Client
from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.support.files.files import write_json
from haptid.support.terminal import Count
from studies.ledger.version import origin_of

OUT = Path(__file__).parents[2] / "docs" / "results" / "clients.json"
KINDS: tuple[Kind, ...] = ("python", "native", "native3")
LIMIT_S = 300
ABSENT = {
    "OMSimulator": "its package on PyPI fetches the program from build.openmodelica.org, which was out of reach",
    "PyFMI": "it comes by conda; what PyPI has of it is of 2018 and does not build",
    "fmuCheck": "it is built from its source, which no package holds",
    "fmusim": "it is built from its source, which no package holds",
    "OpenModelica": "not installed",
    "Simulink": "not installed",
    "Dymola": "not installed",
}
"""Clients that did not run, with the reason."""


def build(folder: Path) -> dict[tuple[str, Kind], Path]:
    """Build the FMUs of all configurations in all packagings; the whole device at its identified values."""
    sets = [*((j,) for j in range(len(whole.device().joints))), (0, 1)]
    wanted: list[tuple[Equations, dict[str, float] | None]] = [
        *((configuration_equations(whole.device(), free), None) for free in sets),
        (whole.equations(), whole.values()),
    ]
    fmus = {}
    for equations, values in Count(wanted, title="FMUs"):
        for kind in KINDS:
            path = folder / kind / f"{equations.name}.fmu"
            fmus[equations.name, kind] = build_fmu(
                equations, path, kind=kind, values=values, platforms=this_platform()
            ).path
    return fmus


def run(word: str, archive: Path) -> dict[str, Any]:
    """Run a client on an FMU in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.simulators.drivers", word, str(archive)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return {"failed": f"no end after {LIMIT_S} s"}
    for line in done.stdout.splitlines():
        if line.startswith("NOT HERE"):
            return {"not_here": line.removeprefix("NOT HERE").strip()}
    columns = [line.split() for line in done.stdout.splitlines() if line.startswith("COLUMN")]
    if done.returncode or not columns:
        return {"failed": (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]}
    result = {"columns": len(columns), "largest_difference": max(float(text) for _, _, text in columns)}
    for line in done.stdout.splitlines():
        if line.startswith("REFERENCE"):
            result["to_reference_run"] = float(line.split()[1])
    return result


def version_of(client: Client) -> str:
    """Return the version of a client's distribution; empty where it is not installed."""
    try:
        return metadata.version(client.package)
    except metadata.PackageNotFoundError:
        return ""


@click.command(help=__doc__)
@click.option("--page", "page_alone", is_flag=True, help="Write the page from the stored results.")
def main(page_alone: bool) -> None:
    """Run all clients, and write results and page."""
    if not page_alone:
        with tempfile.TemporaryDirectory() as folder:
            fmus = build(Path(folder))
            rows = [
                {"fmu": name, "kind": kind, "client": word, **run(word, path)}
                for (name, kind), path in Count(list(fmus.items()), title="FMUs")
                for word, client in CLIENTS.items()
                if kind in client.kinds
            ]
            problems = sum(len(validate_fmu(str(path))) for path in fmus.values())
        about = {
            word: {"name": c.name, "version": version_of(c), "how": c.how, "aim": c.aim} for word, c in CLIENTS.items()
        }
        write_json(
            OUT,
            {
                **origin_of(" ".join(["python -m benchmarks.simulators.clients", *sys.argv[1:]])),
                "clients": about, "absent": ABSENT, "validated": len(fmus), "problems": problems, "rows": rows,
            },
        )  # fmt: skip
    page.write()


if __name__ == "__main__":
    main()
