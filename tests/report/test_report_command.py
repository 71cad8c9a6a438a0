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
from tests.report.reading import seen


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
    (tmp_path / "posterior.html").write_text("with pictures")
    done = run_report(tmp_path)
    assert (tmp_path / "posterior.html").read_text() == "with pictures"
    assert done.exit_code == 0
    assert done.stderr == f"note: {tmp_path / 'posterior.json'} has no stored page; haptid posterior makes it\n"


@pytest.mark.parametrize(
    "content",
    [b"", b"no gzip", gzip.compress(b"[]"), gzip.compress(b'{"schema": "page/9"}')],
    # A packed content holds the second in which it was made, so that it cannot name its test.
    ids=["empty", "no gzip", "a list", "another schema"],
)
def test_a_damaged_content_is_one_line(tmp_path: Path, content: bytes):
    content_of(tmp_path / "report.html").parent.mkdir()
    content_of(tmp_path / "report.html").write_bytes(content)
    done = run_report(tmp_path)
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "report.json.gz: expected the content of a page" in done.stderr


def test_a_picture_from_elsewhere_is_refused(tmp_path: Path):
    write_page(tmp_path / "report.html", made_page("https://example.org/a.png"))
    assert run_report(tmp_path).exit_code == 2


IDENTIFICATION = {
    "campaign": "A wrist", "measured": False,
    "configurations": [{
        "free_joints": [4], "outcome_sentence": "converged",
        "parameters": {"Ks": {"value": 0.0083, "std": 1e-5, "unit": "N m/rad", "status": "identified"}},
        "runs": [{"file": "a.csv", "use": "validate", "rmse_over_noise": 1.03}],
    }],
}  # fmt: skip
OF_KS = {"median": 0.0083, "intervals": {"0.95": [0.0082, 0.0084]}, "unit": "N m/rad"}
POSTERIOR = {"campaign": "A wrist", "measured": True, "joints": [{"joint": 4, "parameters": {"Ks": OF_KS}}]}
FINDING = {
    "joint": 4, "measured": True, "verdict": "named", "sentence": "Cogging is missing.",
    "effects": [{"id": "cogging", "parameters": {"amplitude": {"value": 1e-3, "std": 1e-5, "unit": "N m"}}}],
    "gap": {"validate": {"before": 2e-3, "after": 2.1e-4, "noise": 2e-4}, "sealed": None},
}  # fmt: skip


@pytest.mark.parametrize(
    ("data", "page", "shown"),
    [
        ("identification.json", "report.html", ["A wrist", "SYNTHETIC DATA", "Ks", "identified", "a.csv", "1.03"]),
        ("posterior.json", "posterior.html", ["A wrist", "Ks", "0.0082 … 0.0084"]),
        ("discrepancy/joint4.json", "discrepancy/joint4.html", ["Cogging is missing.", "cogging", "0.002"]),
    ],
)
def test_of_a_result_alone_a_page_of_tables_is_made(tmp_path: Path, data: str, page: str, shown: list[str]):
    contents = {"identification.json": IDENTIFICATION, "posterior.json": POSTERIOR}
    (tmp_path / "discrepancy").mkdir()
    (tmp_path / data).write_text(json.dumps(contents.get(data, FINDING)), encoding="utf-8")
    done = run_report(tmp_path)
    assert done.exit_code == 0, done.output
    text = seen((tmp_path / page).read_text(encoding="utf-8")).text
    assert all(part in text for part in shown)


def test_a_result_that_is_none_is_refused(tmp_path: Path):
    (tmp_path / "identification.json").write_text('{"measured": true}')
    done = run_report(tmp_path)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "expected a result that haptid wrote" in done.stderr


def test_a_folder_without_results_says_what_to_name(tmp_path: Path):
    done = run_report(tmp_path)
    assert done.exit_code == 2
    assert done.stderr.endswith("got none; name the --out of an earlier command\n")
