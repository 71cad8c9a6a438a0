"""The pages build without broken links, and the readme names only what exists."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest

from benchmarks.install import readme_text
from docs import accessibility
from haptid.support.installing.environment import ROOT

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "docs.build", "--out", out], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return out


def test_pages_hold_what_is_made_from_the_code(site: Path):
    effects = (site / "reference" / "effects.html").read_text(encoding="utf-8")
    assert "cubic_spring" in effects
    assert "--seed" in (site / "reference" / "commands.html").read_text(encoding="utf-8")
    assert "<math " in (site / "theory" / "rigid_body.html").read_text(encoding="utf-8")


def test_parts_of_the_site_stand_in_their_order(site: Path):
    page = (site / "index.html").read_text(encoding="utf-8")
    tabs = re.findall(r'class="md-tabs__link">\s*(.*?)\s*</a>', page, re.S)
    assert tabs == ["Start", "Tutorial", "How-to", "Reference", "Theory", "Results", "Decisions"]


def test_pages_ask_no_server_for_anything(site: Path):
    loaded = re.compile(
        r"""<(?:script|img|iframe|source)[^>]*\ssrc=["']?(?:https?:)?//|<link[^>]*\shref=["']?https?:"""
    )
    asking = [page.name for page in site.rglob("*.html") if loaded.search(page.read_text(encoding="utf-8"))]
    assert not asking


def test_the_search_has_a_name_for_readers_without_a_screen(site: Path):
    assert 'role="dialog" aria-label="Search"' in (site / "index.html").read_text(encoding="utf-8")


KINDS_OF_PAGES = (
    "index",
    "gallery",
    "how-to/foreign_fmu",
    "results/real_machines",
    "theory/rigid_body",
    "decisions/0007-maxwell-slip",
)
"""Pages with pictures, code, wide tables, equations, empty headers, and a part of the navigation without first page."""


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_axe_finds_no_violation(site: Path):
    pytest.importorskip("axe_playwright_python", reason="a dependency of development")
    pages = [site / f"{name}.html" for name in KINDS_OF_PAGES]
    views = tuple(
        zip(accessibility.WIDTHS, accessibility.SCHEMES, strict=True)
    )  # python -m docs.accessibility: all four
    examined = list(accessibility.examine_pages(pages, views, CHROMIUM))
    assert len(examined) == len(pages) * len(views)
    assert [one for part in examined for one in part] == []


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_pictures_scroll_on_a_phone_and_keep_the_size_of_their_letters(site: Path):
    """Shrunk to a phone, letters of the gallery's pictures had 4 pixels."""
    driven = pytest.importorskip("playwright.sync_api", reason="a dependency of development")
    with driven.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        shown = opened.new_page(viewport={"width": 390, "height": 900})
        for name in ("gallery", "architecture"):
            shown.goto((site / f"{name}.html").as_uri())
            assert shown.evaluate("document.documentElement.scrollWidth") == 390
            for image in shown.locator(".picture img").all():
                image.scroll_into_view_if_needed()
                drawn = Path(unquote(urlparse(image.evaluate("one => one.src")).path))
                # Pixels at 110 dots an inch, or units of a drawing whose least letters have 12.
                whole = 1014 if drawn.suffix == ".svg" else image.evaluate("one => one.naturalWidth")
                assert image.bounding_box()["width"] >= 0.95 * whole, drawn.name
        opened.close()


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_axe_finds_what_the_theme_leaves_out(site: Path, tmp_path: Path):
    pytest.importorskip("axe_playwright_python", reason="a dependency of development")
    spoilt = tmp_path / "spoilt"
    shutil.copytree(site, spoilt)
    (spoilt / "assets" / "accessible.js").write_text("", encoding="utf-8")
    (found,) = accessibility.examine_pages([spoilt / "theory" / "rigid_body.html"], [(390, "light")], CHROMIUM)
    assert "scrollable-region-focusable" in {one.rule for one in found}


@pytest.mark.alone
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
@pytest.mark.long
def test_the_search_works_from_the_disk(site: Path, tmp_path: Path):
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}",
        "--virtual-time-budget=20000", "--dump-dom", f"file://{site}/index.html?q=presliding",
    ]  # fmt: skip
    page = subprocess.run(command, capture_output=True, text=True, check=False, timeout=200).stdout
    found = re.search(r'md-search-result__meta">([^<]*)<', page)
    assert found is not None
    assert re.fullmatch(r"\d+ matching documents", found[1])
    assert "theory/friction.html" in page.partition("md-search-result__meta")[2]


@pytest.mark.parametrize("target", re.findall(r"\]\(([^)#]+)\)", README))
def test_links_of_the_readme(target: str):
    assert (ROOT / target).exists()


def test_links_of_the_pages_lead_to_a_file_of_the_clone():
    """Pages that are generated were linked eighteen times, and were not there."""
    dead = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in sorted((ROOT / "docs").rglob("*.md"))
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
        if ":" not in target and not (page.parent / target).exists()
    ]
    assert not dead


@pytest.mark.parametrize("module", sorted(set(re.findall(r"python -m ([\w.]+)", README))))
def test_commands_of_the_readme(module: str):
    assert importlib.util.find_spec(module) is not None


@pytest.mark.parametrize("verb", sorted(set(re.findall(r"`make (\w+)`", README)) | {"fmu", "test"}))
def test_verbs_of_the_readme(verb: str):
    assert f"\n{verb}: ;" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_every_page_is_reached_from_an_index():
    docs = ROOT / "docs"
    linked = {
        (index.parent / target).resolve()
        for index in (docs / "index.md", docs / "decisions" / "index.md")
        for target in re.findall(r"\]\(([^)#]+)\)", index.read_text(encoding="utf-8"))
    }
    lost = [
        str(p.relative_to(docs)) for p in docs.rglob("*.md") if p != docs / "index.md" and p.resolve() not in linked
    ]
    assert not lost


def test_decisions_have_number_and_title_of_their_index():
    index = (ROOT / "docs" / "decisions" / "index.md").read_text(encoding="utf-8")
    listed = {page: f"# {number}. {title}" for number, title, page in re.findall(r"(\d+)\. \[(.+)\]\((.+)\)", index)}
    pages = [p for p in (ROOT / "docs" / "decisions").glob("*.md") if p.name != "index.md"]
    assert {page.name: page.read_text(encoding="utf-8").partition("\n")[0] for page in pages} == listed


PACKAGES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["root_packages"]
WITH_EXAMPLES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for name in PACKAGES
    for path in sorted((ROOT / name).rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_in_docstrings(module: str):
    done = doctest.testmod(importlib.import_module(module))
    assert done.attempted > 0
    assert done.failed == 0


def test_the_readme_says_what_was_measured_of_the_installation():
    stored = json.loads((ROOT / "docs" / "results" / "install.json").read_text(encoding="utf-8"))
    assert readme_text(stored) in README
    more = {name: step | {"wall_s": step["wall_s"] + 100.0} for name, step in stored["steps"].items()}
    assert readme_text(stored | {"steps": more}) not in README
