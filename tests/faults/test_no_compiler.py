"""Without a C compiler a command ends in one line that says how to get one, and nothing is written."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.identification.run import main
from haptid.model.kernel import compiler


@pytest.fixture(autouse=True)
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HAPTID_CACHE", str(tmp_path / "cache"))


def lines(out: Path) -> list[str]:
    arguments = ["--joints", "4", "--starts", "1", "--fmu", "none", "--workers", "1", "--quiet", "--out", str(out)]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 1
    return done.output.splitlines()


def test_a_missing_compiler_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(compiler, "available", lambda: False)
    (line,) = lines(tmp_path / "out")
    assert line == "error: the C compiler is missing: install it with python -m pip install ziglang"
    assert not list((tmp_path / "out").glob("*"))


def test_a_compiler_that_fails_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\necho 'line one' >&2; echo 'line two' >&2; exit 1\n", encoding="utf-8")
    broken.chmod(0o700)
    monkeypatch.setattr(compiler.sys, "executable", str(broken))
    (line,) = lines(tmp_path / "out")
    assert line.startswith("error: the C compiler failed: line one")
    assert len(line) <= 300
    assert not list((tmp_path / "out").glob("*"))
