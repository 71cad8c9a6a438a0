"""Draw the figure of the data flow, and write the tables of packages and rooms into ``docs/architecture.md``.

``python -m docs.from_code.architecture`` does both. The order of packages and rooms is that of the import contracts in
``pyproject.toml``; what each takes and returns is the first line of its own docstring.
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path
from typing import Any

import click

from docs.parts.drawing import Arrow, Box, figure
from docs.parts.tables import table, with_parts
from haptid.support.files.files import write_text
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "architecture.md"
FIGURE = ROOT / "docs" / "images" / "data_flow.svg"
TOP = "imports go downward only"  # names of contracts in pyproject.toml
OF = "rooms of "
COMMANDS = ROOT / "haptid" / "command_line"


def contracts() -> list[dict[str, Any]]:
    """Return the import contracts of the project."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = project["tool"]["importlinter"]["contracts"]
    return found


def layers_bottom_up(contract: dict[str, Any]) -> list[list[str]]:
    """Return the layers of a contract, lowest first; members of one layer do not import each other."""
    return [[name.strip() for name in layer.split("|")] for layer in reversed(contract["layers"])]


def first_sentence(path: Path) -> str:
    """Return the first line of the docstring of a package or module, without importing it."""
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    line = docstring.split("\n\n")[0].replace("\n", " ")
    return line.replace("``", "`")


def packages_table() -> str:
    """Return the packages bottom up, and what each takes and returns."""
    top = next(contract for contract in contracts() if contract["name"] == TOP)
    names = [name.removeprefix("haptid.") for layer in layers_bottom_up(top) for name in layer]
    names.append("virtual_device")  # beside the layers: a contract of its own keeps it independent
    rows = [(f"`{name}/`", first_sentence(ROOT / name)) for name in names]
    rows.append(("`haptid/`", f"{first_sentence(ROOT / 'haptid')} {first_sentence(COMMANDS)}"))
    return table(("package", "in and out"), rows)


def rooms_table(contract: dict[str, Any]) -> str:
    """Return the rooms of one package, bottom up; rooms of one layer have one number."""
    package = ROOT / contract["name"].removeprefix(OF).replace(".", "/")
    rows = []
    for level, layer in enumerate(layers_bottom_up(contract), start=1):
        for name in layer:
            shown = f"`{name}/`" if (package / name).is_dir() else f"`{name}.py`"
            rows.append((level, shown, first_sentence(package / name)))
    heading = f"### `{package.relative_to(ROOT).as_posix()}/`\n\n"
    return heading + table(("", "room", "in and out"), rows)


def rooms_tables() -> str:
    """Return the rooms of all packages."""
    return "\n".join(rooms_table(contract) for contract in contracts() if contract["name"].startswith(OF))


def with_tables(page: str) -> str:
    """Return the page with its generated parts made anew."""
    return with_parts(page, {"packages": packages_table(), "rooms": rooms_tables()}, "docs/from_code/architecture.py")


def data_flow() -> str:
    """Return the figure of the data flow."""
    wide, high = 150.0, 58.0
    parts: list[Box | Arrow] = [
        Box(at=(24, 40), size=(120, high), title="device file", lines=("TOML or URDF",), kind="file"),
        Box(at=(24, 180), size=(120, high), title="campaign", lines=("TOML and tables",), kind="file"),
        Box(at=(220, 40), size=(wide, high), title="model", lines=("equations, kernel",)),
        Box(at=(220, 180), size=(wide, high), title="measurement", lines=("read, check",)),
        Box(at=(480, 40), size=(wide, high), title="fmu_build", lines=("pack, describe",)),
        Box(at=(480, 180), size=(wide, high), title="identification", lines=("fit, joint by joint",)),
        Box(at=(350, 330), size=(wide, high), title="uq", lines=("sample, predict",)),
        Box(at=(610, 330), size=(wide, high), title="discrepancy", lines=("detect, name, refit",)),
        Box(at=(480, 440), size=(wide, 44), title="noise", lines=()),
        Box(at=(840, 40), size=(150, high), title="FMUs", lines=("joints, whole device",), kind="file"),
        Box(at=(840, 180), size=(150, high), title="report", lines=("figures, pages",)),
        Box(at=(840, 330), size=(150, high), title="results", lines=("HTML, JSON, chains",), kind="file"),
        Arrow(through=[(144, 69), (218, 69)]),
        Arrow(through=[(144, 209), (218, 209)]),
        Arrow(through=[(370, 69), (478, 69)], label=("Equations,", "Kernel"), label_at=(424, 42)),
        Arrow(through=[(555, 98), (555, 178)], label=("Fmu",), label_at=(563, 142), anchor="start"),
        Arrow(
            through=[(370, 84), (500, 178)],
            label=("Equations",),
            label_at=(420, 146),
            anchor="end",
        ),
        Arrow(through=[(370, 209), (478, 209)], label=("Campaign",), label_at=(422, 202)),
        Arrow(through=[(630, 69), (838, 69)], label=("archive with units, checks, draws",), label_at=(734, 60)),
        Arrow(through=[(520, 238), (440, 328)], label=("Fit, Runs",), label_at=(470, 280), anchor="end"),
        Arrow(through=[(590, 238), (660, 328)], label=("Runs,", "Simulator"), label_at=(644, 272), anchor="start"),
        Arrow(through=[(500, 440), (450, 390)], label=("noise model",), label_at=(555, 424)),
        Arrow(through=[(610, 440), (660, 390)]),
        Arrow(through=[(630, 209), (838, 209)], label=("Fit",), label_at=(734, 202)),
        Arrow(
            through=[(425, 388), (425, 500), (810, 500), (810, 224), (838, 224)],
            label=("Posterior",),
            label_at=(734, 494),
        ),
        Arrow(through=[(760, 350), (790, 350), (790, 216), (838, 216)], label=("Finding",), label_at=(756, 322)),
        Arrow(
            through=[(720, 330), (720, 110), (632, 84)],
            label=("Equations with", "the named effect"),
            label_at=(714, 140),
            anchor="end",
        ),
        Arrow(through=[(915, 238), (915, 328)]),
    ]
    return figure((1014, 520), "Data flow between the packages, with the types that are handed on", parts)


@click.command()
def main() -> None:
    """Draw the figure and write the tables."""
    write_text(FIGURE, data_flow())
    write_text(PAGE, with_tables(PAGE.read_text(encoding="utf-8")))
    for path in (FIGURE, PAGE):
        click.echo(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
