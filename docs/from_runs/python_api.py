"""Run the code of the page on the Python API, and keep the figure that it draws.

``python -m docs.from_runs.python_api`` writes the figure; the tests run the same code.
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import matplotlib as mpl

from haptid.support.files.files import write_bytes
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "tutorial" / "through_python.md"
FIGURE = ROOT / "docs" / "images" / "python_api.png"
DRAWN = "pendulum.png"
"""Name under which the page's code saves its figure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ran:
    """What the code of the page left behind.

    Parameters
    ----------
    names
        Variables by name.
    printed
        All that was printed.
    """

    names: dict[str, Any]
    printed: str


def blocks(language: str) -> list[str]:
    """Return the page's blocks in one language, in their order."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def run_page(folder: Path) -> Ran:
    """Run the page's code from top to bottom, with ``folder`` as the working folder."""
    names: dict[str, Any] = {"__name__": "page"}
    printed = io.StringIO()
    mpl.use("agg")  # no window opens
    with contextlib.chdir(folder), contextlib.redirect_stdout(printed):
        for number, block in enumerate(blocks("python")):
            exec(compile(block, f"{PAGE.name}, block {number}", "exec"), names)
    return Ran(names=names, printed=printed.getvalue())


@click.command()
def main() -> None:
    """Run the code of the page and store its figure."""
    with tempfile.TemporaryDirectory() as folder:
        run_page(Path(folder))
        write_bytes(FIGURE, (Path(folder) / DRAWN).read_bytes())
    click.echo(FIGURE.relative_to(ROOT))


if __name__ == "__main__":
    main()
