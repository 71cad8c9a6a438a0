"""Build the documentation: the pages of this folder, and reference pages generated from the code. Broken links fail."""

from __future__ import annotations

import importlib
import importlib.util
import re
import shutil
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import click

try:
    from mkdocs.commands.build import build
    from mkdocs.config import load_config
except ModuleNotFoundError as absent:
    sys.stderr.write(f"error: {sys.executable} lacks {absent.name}; run `make docs`\n")
    sys.exit(2)

from docs.from_code.api_reference import api_page
from docs.parts.equations import with_equations
from docs.parts.tables import table
from haptid.command_line import main as haptid
from haptid.model.device.reader import load_device
from haptid.model.effects.registry import catalogue
from haptid.model.equations.joint_parameters import DRIVE_TABLE, TABLE, Row
from haptid.model.friction.registry import laws
from haptid.support.installing.environment import ROOT

SOURCES = ROOT / "docs"
OTHER_COMMANDS = (
    "studies.calibration.run",
    "studies.blind.run",
    "studies.evidence.run",
    "studies.evidence.enter",
    "studies.thresholds.run",
    "virtual_device.make_campaign",
)
"""Modules of the commands that ``haptid`` does not have."""
SEARCH_DIALOG = 'data-md-component="search" role="dialog"'
"""Element of the theme that has no name for readers without a screen."""
NAVIGATION = re.compile(
    r'(?P<before><nav [^>]*)aria-labelledby="__nav_[0-9_]+label"(?P<after>[^>]*>\s*'
    r'<label class="md-nav__title"[^>]*>\s*<span[^>]*></span>\s*(?P<title>[^<]*?)\s*</label>)'
)
"""Part of the navigation, whose label the theme leaves empty where the part has a first page."""
PICTURE = re.compile(r'<p>(?P<image><img alt="(?P<alt>[^"]*)"[^>]*>)</p>')
"""Picture that stands alone in its paragraph."""
NO_PAGES = ("*.py", "*.yml", "*.csv", "constants.toml", "campaign_keys.toml", "__pycache__")
"""Files of this folder that are left out of the pages."""


def parameters_page() -> str:
    """Return the parameters of a locked joint."""
    text = "# Parameters of a locked joint\n\n" + _rows(TABLE)
    text += "\n## Drive, where the torque is not recorded\n\n" + _rows(DRIVE_TABLE)
    for law in laws().values():
        formulas = "\n".join(f"    {line}" for line in (f"friction = {law.formulas[0]}", *law.formulas[1:]))
        text += f"\n## {law.title} friction (`{law.id}`)\n\n{formulas}\n\n{_rows(law.parameters)}"
    return text


def _rows(rows: Iterable[Row]) -> str:
    cells = ([f"`{r.id}`", r.description, r.unit, r.prismatic_unit, f"{r.lower:g} … {r.upper:g}"] for r in rows)
    return table(("id", "meaning", "unit", "unit, prismatic", "default range"), cells)


def effects_page() -> str:
    """Return the catalogue of effects."""
    text = "# Catalogue of effects\n\nOne file each in `model/effects/`; adding one means adding a file.\n\n"
    for effect in catalogue().values():
        text += f"## `{effect.key}`\n\n{effect.title[0].upper()}{effect.title[1:]}: {effect.formula}\n\n"
        rivals = ", ".join(f"`{r}`" for r in effect.rivals) or "–"
        text += f"Lives in {effect.lives_in}; enters on the {effect.side} side; easily taken for {rivals}.\n\n"
        text += table(
            ("parameter", "meaning", "unit"), ((f"`{p.id}`", p.description, p.unit) for p in effect.parameters)
        )
        text += "\n"
    return text


def device_page() -> str:
    """Return what is assumed of the built-in device."""
    device = load_device("freedom6s")
    return f"# {device.title}\n\n" + "".join(f"- {line}\n" for line in device.assumptions)


def commands_page() -> str:
    """Return the help of every command, first those of ``haptid``, then the others."""
    text = "# Commands\n\n"
    door = click.Context(haptid, info_name="haptid")
    helped = {f"haptid {name}": haptid.get_command(door, name) for name in haptid.list_commands(door)}
    helped |= {
        f"python -m {name}": importlib.import_module(name).main
        for name in OTHER_COMMANDS
        if importlib.util.find_spec(name)
    }
    for name, command in helped.items():
        context = click.Context(command, info_name=name, max_content_width=110)
        text += f"## `{name}`\n\n```\n{command.get_help(context)}\n```\n\n"
    return text


PAGES = {
    "reference/parameters.md": parameters_page,
    "reference/effects.md": effects_page,
    "reference/device.md": device_page,
    "reference/commands.md": commands_page,
    "reference/python_api.md": api_page,
}


def accessible(page: str) -> str:
    """Return a page of the theme with the names that readers without a screen or a mouse need.

    What the theme makes in the browser, ``assets/accessible.js`` names there.

    Parameters
    ----------
    page
        HTML of a page.

    Returns
    -------
    str
        The search dialog and each part of the navigation have a name, an empty cell is no header, and a picture that
        scrolls on a phone is reached by the keyboard.
    """
    page = page.replace(SEARCH_DIALOG, f'{SEARCH_DIALOG} aria-label="Search"').replace("<th></th>", "<td></td>")
    page = PICTURE.sub(r'<p class="picture" tabindex="0" role="group" aria-label="\g<alt>">\g<image></p>', page)
    return NAVIGATION.sub(lambda found: f'{found["before"]}aria-label="{found["title"]}"{found["after"]}', page)


@click.command()
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=ROOT / "artifacts" / "docs")
def main(out: Path) -> None:
    """Build the pages into a folder; start at its index.html."""
    with tempfile.TemporaryDirectory() as folder:
        pages = Path(folder) / "docs"
        shutil.copytree(
            SOURCES,
            pages,
            ignore=shutil.ignore_patterns(*NO_PAGES),
        )
        for name, page in PAGES.items():
            (pages / name).parent.mkdir(exist_ok=True)
            (pages / name).write_text(page(), encoding="utf-8")
        for path in pages.rglob("*.md"):
            path.write_text(with_equations(path.read_text(encoding="utf-8")), encoding="utf-8")
        config = load_config(str(SOURCES / "mkdocs.yml"), docs_dir=str(pages), site_dir=str(out.resolve()))
        build(config)
    (out / "404.html").unlink(missing_ok=True)  # a server's page, whose style is not found from the disk
    for path in out.rglob("*.html"):
        path.write_text(accessible(path.read_text(encoding="utf-8")), encoding="utf-8")
    click.echo(f"{out / 'index.html'}")


if __name__ == "__main__":
    main()
