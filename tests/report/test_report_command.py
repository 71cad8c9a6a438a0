"""``haptid report``: pages come back byte for byte, and nothing is computed."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from haptid.command_line import main
from haptid.report.common.page import Page, Picture, Section, Table
from haptid.report.common.stored_page import content_of, write_page
from haptid.report.common.style import data_uri, figure


def made_page(uri: str | None = None) -> Page:
    picture = Picture(uri=uri or data_uri(figure()), caption="<caption>", alt="alternative")
    table = Table(header=["a", "b"], rows=[("1 µm", "<2>")])
    section = Section(
        title="One & all", anchor="one", paragraphs=["Ω"], pictures=[picture], tables=[table], folded=True
    )
    return Page(title="Title", lead="Lead.", sections=[section], synthetic=True, footer=["seed 0"])


def run_report(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["report", *map(str, arguments)])


def test_pages_come_back_as_they_were(tmp_path: Path):
    paths = [tmp_path / "report.html", tmp_path / "discrepancy" / "joint4.html"]
    before = [write_page(path, made_page()).read_bytes() for path in paths]
    for path in paths:
        path.unlink()
    done = run_report(tmp_path, "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["pages"] == sorted(map(str, paths))
    assert [path.read_bytes() for path in paths] == before


def test_results_without_a_stored_page_are_named(tmp_path: Path):
    write_page(tmp_path / "report.html", made_page())
    (tmp_path / "posterior.json").write_text("{}")
    done = run_report(tmp_path)
    assert done.exit_code == 0
    assert done.stderr == f"note: {tmp_path / 'posterior.json'} has no stored page; haptid posterior makes it\n"


@pytest.mark.parametrize("content", [b"", b"no gzip", gzip.compress(b"[]"), gzip.compress(b'{"schema": "page/9"}')])
def test_a_damaged_content_is_one_line(tmp_path: Path, content: bytes):
    content_of(tmp_path / "report.html").parent.mkdir()
    content_of(tmp_path / "report.html").write_bytes(content)
    done = run_report(tmp_path)
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "report.json.gz: expected the content of a page" in done.stderr


def test_a_picture_from_elsewhere_is_refused(tmp_path: Path):
    write_page(tmp_path / "report.html", made_page("https://example.org/a.png"))
    assert run_report(tmp_path).exit_code == 2


def test_a_folder_without_results_says_what_to_name(tmp_path: Path):
    done = run_report(tmp_path)
    assert done.exit_code == 2
    assert done.stderr.endswith("got none; name the --out of an earlier command\n")
