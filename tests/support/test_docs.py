"""The pages build without broken links, and the readme names only what exists."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from haptid.support.installing.environment import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_pages_build(tmp_path: Path):
    done = subprocess.run(
        [sys.executable, "-m", "docs.build", "--out", tmp_path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    effects = (tmp_path / "reference" / "effects.html").read_text(encoding="utf-8")
    assert "cubic_spring" in effects
    assert "--seed" in (tmp_path / "reference" / "commands.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("target", re.findall(r"\]\(([^)#]+)\)", README))
def test_links_of_the_readme(target: str):
    assert (ROOT / target).exists()


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
