"""Pages of one folder of results link each other, whichever was written first."""

from __future__ import annotations

import re
from pathlib import Path

from haptid.report.common.linked_pages import link_pages
from haptid.report.common.page import Page
from haptid.report.common.stored_page import read_page, write_page


def written(folder: Path, *names: str) -> None:
    for name in names:
        write_page(folder / name, Page(title=name, lead="", sections=[], synthetic=None))


def links(path: Path) -> dict[str, str]:
    (told,) = re.findall(r'<p class="others">(.*?)</p>', path.read_text())
    return {title: address for address, title in re.findall(r'<a href="([^"]*)">([^<]*)</a>', told)}


def test_every_page_links_the_others_and_each_link_leads_to_a_page(tmp_path: Path):
    written(tmp_path, "report.html")
    assert link_pages(tmp_path) == []
    written(
        tmp_path, "posterior.html", "discrepancy/joint4.html", "discrepancy/joints01.html", "discrepancy/whole.html"
    )
    assert len(link_pages(tmp_path)) == 5
    assert links(tmp_path / "report.html") == {
        "posterior": "posterior.html",
        "missing in joint 4": "discrepancy/joint4.html",
        "missing in joints 0, 1": "discrepancy/joints01.html",
        "missing in the whole device": "discrepancy/whole.html",
    }
    finding = tmp_path / "discrepancy" / "joint4.html"
    assert links(finding)["identification"] == "../report.html"
    assert links(finding)["missing in joints 0, 1"] == "joints01.html"
    assert all((finding.parent / address).is_file() for address in links(finding).values())
    assert link_pages(tmp_path) == []


def test_a_page_that_is_gone_is_not_linked_and_one_without_content_stays(tmp_path: Path):
    written(tmp_path, "report.html", "posterior.html")
    link_pages(tmp_path)
    (tmp_path / "posterior.html").unlink()
    (tmp_path / "locking_plan.html").write_text("an earlier page")
    assert link_pages(tmp_path) == [tmp_path / "report.html"]
    assert read_page(tmp_path / "report.html").others == [("locking plan", "locking_plan.html")]
    assert (tmp_path / "locking_plan.html").read_text() == "an earlier page"
