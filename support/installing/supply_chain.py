"""Records of third-party distributions: ``support.installing.supply_chain lock|check|sizes|sbom|licences``.

uv.lock comes in; locked requirements, sizes, a bill of materials and a list of licences go out.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from importlib.util import cache_from_source
from pathlib import Path

import click

from haptid.support.command import exit_codes
from haptid.support.errors import HaptidError
from haptid.support.files.files import write_json, write_text
from haptid.support.installing.environment import ROOT
from haptid.support.installing.licence import UNKNOWN, licence, with_licences
from haptid.support.installing.lock_file import CORE, DEV, SIZES, locked_file, pins

LICENCES = ROOT / "THIRD_PARTY.md"
SBOM = ROOT / "artifacts" / "sbom.cdx.json"
VENDORED = (
    ("report/common/uPlot.iife.min.js", "1.6.32", "MIT (report/common/uPlot.LICENSE)", "npm, uplot"),
    ("report/common/uPlot.min.css", "1.6.32", "MIT (report/common/uPlot.LICENSE)", "npm, uplot"),
)
"""File, version, licence and source of what is kept here as its makers wrote it."""
HEADER = "# Made from uv.lock by `make locked`: every file by its hash, for every platform. Do not edit.\n"


def extras() -> tuple[str, ...]:
    """List the extras with locked requirements.

    Returns
    -------
    tuple of str
        All extras but ``suggest``.
    """
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return tuple(name for name in table["optional-dependencies"] if name != "suggest")


def uv(*arguments: str) -> str:
    """Run uv without the settings of this machine, offline.

    Parameters
    ----------
    *arguments
        Command of uv with its options.

    Returns
    -------
    str
        Text that uv wrote to stdout.

    Raises
    ------
    HaptidError
        Where uv fails.
    """
    command = [sys.executable, "-m", "uv", *arguments, "--no-config", "--offline", "--quiet"]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    if done.returncode != 0:
        message = f"uv {arguments[0]}: {done.stderr or done.stdout}"
        raise HaptidError(message)
    return done.stdout


def export_locks() -> dict[str, str]:
    """Export the locked requirements with hashes from uv.lock.

    Returns
    -------
    dict
        Text of the file by part.

    Raises
    ------
    HaptidError
        Where uv is missing or fails.
    """
    wanted = {CORE: ["--no-dev"]} | {name: ["--no-dev", "--extra", name] for name in extras()}
    wanted[DEV] = ["--group", "dev"]
    options = ("--locked", "--no-emit-project", "--no-header", "--no-annotate", "--format", "requirements.txt")
    return {part: HEADER + uv("export", *options, *more) for part, more in wanted.items()}


def stale() -> tuple[Path, ...]:
    """Find the files of locked requirements that are missing or differ from uv.lock.

    Returns
    -------
    tuple of Path
        Files to export again.

    Raises
    ------
    HaptidError
        Where uv is missing or fails.
    """
    texts = {locked_file(part): text for part, text in export_locks().items()}
    return tuple(p for p, text in texts.items() if not p.is_file() or p.read_text(encoding="utf-8") != text)


def licences_page() -> str:
    """Write the page of licences.

    Returns
    -------
    str
        Markdown: locked distributions with version, the first part that needs them, and licence.
    """
    parts: dict[tuple[str, str], str] = {}
    for part in (CORE, *extras(), DEV):
        for pin in pins(part):
            parts.setdefault((pin.name, pin.version), part)
    text = "# Licences of what haptid uses\n\nMade by `make licences` from uv.lock and the packages' own metadata.\n\n"
    text += "| distribution | version | needed by | licence |\n| --- | --- | --- | --- |\n"
    text += "".join(_rows(parts.items()))
    text += "\nFiles of others that lie in haptid itself, unchanged:\n\n| file | version | licence | from |\n"
    return text + "| --- | --- | --- | --- |\n" + "".join(f"| {' | '.join(row)} |\n" for row in VENDORED)


def _rows(parts: Iterable[tuple[tuple[str, str], str]]) -> Iterable[str]:
    for (name, version), part in sorted(parts):
        try:
            said = licence(name)
        except metadata.PackageNotFoundError:
            said = UNKNOWN
        yield f"| {name} | {version} | {part} | {said.replace('|', '/')} |\n"


def installed_sizes() -> dict[str, int]:
    """Measure every locked distribution on disk.

    Sizes of distributions that are not installed here in the locked version are kept from the file.

    Returns
    -------
    dict
        Size [bytes] by name of the distribution, compiled Python left out.
    """
    found = json.loads(SIZES.read_text(encoding="utf-8")) if SIZES.is_file() else {}
    for pin in {pin for part in (CORE, *extras(), DEV) for pin in pins(part)}:
        if pin.met:
            files = metadata.distribution(pin.name).files or ()
            found[pin.name] = sum(_on_disk(Path(str(file.locate()))) for file in files if file.suffix != ".pyc")
    return dict(sorted(found.items()))


def _on_disk(path: Path) -> int:
    """Return the size on disk [bytes] of a file and its bytecode, taken as large as the source where not compiled."""
    if not path.is_file():
        return 0
    size, compiled = path.stat().st_blocks * 512, Path(cache_from_source(str(path)))
    if path.suffix == ".py":
        size += compiled.stat().st_blocks * 512 if compiled.is_file() else size
    return size


@click.group()
def main() -> None:
    """Files that are made from uv.lock."""


@main.command()
@exit_codes
def lock() -> None:
    """Write support/locked/*.txt."""
    for part, text in export_locks().items():
        write_text(locked_file(part), text)


@main.command()
@exit_codes
def check() -> None:
    """Refuse files in support/locked that are not what uv.lock says."""
    wrong = ", ".join(str(p.relative_to(ROOT)) for p in stale())
    if wrong:
        message = f"{wrong}: expected what uv.lock says; run `make locked`"
        raise HaptidError(message)


@main.command()
@exit_codes
def sbom() -> None:
    """Write a CycloneDX bill of materials, every distribution with its licence."""
    options = ("--locked", "--all-extras", "--no-dev", "--format", "cyclonedx1.5")
    bill = json.loads(uv("export", *options, "--preview-features", "sbom-export"))
    write_json(SBOM, with_licences(bill))
    click.echo(f"{SBOM.relative_to(ROOT)} written")


@main.command()
@exit_codes
def sizes() -> None:
    """Write how much disk each distribution takes, as installed here."""
    write_text(SIZES, json.dumps(installed_sizes(), indent=1) + "\n")


@main.command()
@exit_codes
def licences() -> None:
    """Write the list of licences."""
    write_text(LICENCES, licences_page())
    click.echo(f"{LICENCES.relative_to(ROOT)} written")


if __name__ == "__main__":
    main()
