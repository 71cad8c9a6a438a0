"""Tables of loggers, campaigns about FMUs and stored pages, as targets of fuzzing."""

from __future__ import annotations

from pathlib import Path

from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.making.answers import Answers
from haptid.measurement.making.logged_table import read_logged_table
from haptid.measurement.making.prepared import describe, prepare_tables
from haptid.report.common.page import Page, Section, Table
from haptid.report.common.stored_page import content_of, read_page, write_page
from tests.fuzz.harness import Target

ROWS = "".join(f"{5 * k};{k % 7 - 3},5;{(k % 5) / 4:.2f}\n".replace(".", ",") for k in range(12))
LOGGED = f"logger 3, 2026\ntime_ms;Angle (deg);torque (Nmm)\n{ROWS}".encode("cp1252")
WITH_UNITS = f"# time\tangle\ttorque\n# ms\tdeg\tNmm\n{ROWS.replace(';', chr(9))}".encode()
ANSWERS = Answers(
    title="a test", device="single_joint", measured=True, hold="zero", noise=None, resolution=None, validate=(),
    free=None, stated={},
)  # fmt: skip
FOREIGN = b"""[campaign]
title = "decay"
measured = false
model = "decay.fmu"
hold = "linear"

[inputs]
u = { column = "force" }

[outputs]
x = { column = "level", noise = 0.005 }
v = { column = "rate" }

[parameters]
k = { initial = 1.0, lower = 0.1, upper = 5.0 }
m = { prior = { mean = 1.0, std = 0.1 } }
c = { fixed = 2 }

[[runs]]
file = "a.csv"
use = "fit"
start = { x = 2.0 }

[[runs]]
file = "b.csv"
use = "validate"
"""
TABLE = "time_s,force,level,rate\n" + "".join(f"{0.1 * k:.1f},{k % 2},{2 - 0.1 * k:.2f},{k % 3}\n" for k in range(12))
SECTION = Section(title="One", paragraphs=("A sentence.",), tables=(Table(header=("a", "b"), rows=[("1", "2")]),))
PAGE = Page(title="a page", lead="All is well.", sections=(SECTION,), synthetic=True, footer=("by a test",))


def read_logged(content: bytes, folder: Path) -> None:
    """Bring ``content``, a logger's table, into the format."""
    path = folder / "a.csv"
    path.write_bytes(content)
    table, _ = read_logged_table(path)
    describe(prepare_tables([table], ANSWERS))


def read_foreign(content: bytes, folder: Path) -> None:
    """Read ``content`` as the ``campaign.toml`` of an FMU beside two valid tables."""
    (folder / "campaign.toml").write_bytes(content)
    (folder / "decay.fmu").write_bytes(b"not looked at")
    for name in ("a.csv", "b.csv"):
        (folder / name).write_text(TABLE, encoding="utf-8")
    read_foreign_campaign(folder)


def read_stored_page(content: bytes, folder: Path) -> None:
    """Render a page from ``content``, what is stored of it."""
    page = folder / "report.html"
    content_of(page).parent.mkdir()
    content_of(page).write_bytes(content)
    read_page(page).html.encode()


def _stored() -> bytes:
    import tempfile  # noqa: PLC0415 # for this one example

    with tempfile.TemporaryDirectory() as folder:
        return content_of(write_page(Path(folder) / "report.html", PAGE)).read_bytes()


OTHERS = (
    Target(name="logged_table", examples=(LOGGED, WITH_UNITS), read=read_logged, nasty=(b";;", b"Angle", b",")),
    Target(name="foreign_campaign", examples=(FOREIGN,), read=read_foreign, nasty=(b"[inputs]", b"{ fixed = 1 }")),
    Target(name="stored_page", examples=(_stored(),), read=read_stored_page),
)
