"""Write the tables of constants of the theory pages: symbols of a page, values of the code.

``python -m docs.from_code.constants`` writes them from the list in ``docs/constants.toml``. A page states no threshold
of its own: it names a symbol, and the table gives the value that the code has.
"""

from __future__ import annotations

import importlib
import tomllib
from dataclasses import dataclass
from pathlib import Path

import click

from docs.parts.tables import table, with_parts
from haptid.support.files.files import write_text
from haptid.support.installing.environment import ROOT

THEORY = ROOT / "docs" / "theory"
LIST = ROOT / "docs" / "constants.toml"
HEADER = ("symbol", "value", "meaning", "step", "in the code")


@dataclass(frozen=True, slots=True)
class Constant:
    """A number of the code under the symbol that a page gives it.

    Parameters
    ----------
    symbol
        As the page writes it.
    module
        Below ``haptid``.
    name
        Of the constant, or an expression that the module can evaluate.
    meaning
        What it bounds or counts, with its unit.
    step
        Number of the step on the page, or the heading that uses it.
    """

    symbol: str
    module: str
    name: str
    meaning: str
    step: str

    @property
    def value(self) -> object:
        """Value in the code."""
        return eval(self.name, vars(importlib.import_module(f"haptid.{self.module}")))

    @property
    def row(self) -> tuple[str, str, str, str, str]:
        """Row of the table."""
        file = f"{self.module.replace('.', '/')}.py"
        return f"`{self.symbol}`", format_value(self.value), self.meaning, self.step, f"`{file}` `{self.name}`"


def format_value(value: object) -> str:
    """Return a number, or several, as a reader expects them.

    >>> format_value(0.0005), format_value(30000), format_value((0.1, 60.0))
    ('5·10⁻⁴', '30 000', '0.1, 60')
    """
    if isinstance(value, tuple | list):
        return ", ".join(map(format_value, value))
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e6:
        return str(int(value))
    text = f"{value:.4g}"
    if isinstance(value, float) and value and abs(value) < 2e-3:
        digits, _, power = f"{value:.3e}".partition("e")
        digits = digits.rstrip("0").rstrip(".")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{digits}·10{raised}" if digits != "1" else f"10{raised}"
    return text


def list_constants() -> dict[str, tuple[Constant, ...]]:
    """Return the constants of each theory page."""
    pages = tomllib.loads(LIST.read_text(encoding="utf-8"))
    return {page: tuple(Constant(*row) for row in rows) for page, rows in pages.items()}


def with_tables(page: Path) -> str:
    """Return a theory page with its table of constants made anew."""
    rows = [constant.row for constant in list_constants()[page.name]]
    return with_parts(
        page.read_text(encoding="utf-8"), {"constants": table(HEADER, rows)}, "docs/from_code/constants.py"
    )


@click.command()
def main() -> None:
    """Write the tables."""
    for name in list_constants():
        write_text(THEORY / name, with_tables(THEORY / name))
        click.echo(f"docs/theory/{name}")


if __name__ == "__main__":
    main()
