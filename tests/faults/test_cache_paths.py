"""The main job, as it stands without options, wherever its cache lies and whatever was done to it."""

from __future__ import annotations

import json
import os
import py_compile
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from haptid.model.kernel.compiler import compile_shared

ROOT = Path(__file__).parents[2]
COMMAND = [
    sys.executable, "-m", "identification.run", "--campaign", "paper", "--joints", "4", "--starts", "1",
    "--workers", "1", "--quiet",
]  # fmt: skip
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def ended(cache: Path, out: Path) -> tuple[int, list[str]]:
    """Run to the end; return the exit code and the lines on stderr."""
    done = subprocess.run(
        [*COMMAND, "--out", str(out)], env={**ENVIRONMENT, "HAPTID_CACHE": str(cache)}, cwd=ROOT,
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    return done.returncode, done.stderr.splitlines()


def parameters(out: Path) -> Any:
    """Return what was identified: every digit of it."""
    (configuration,) = json.loads((out / "identification.json").read_text(encoding="utf-8"))["configurations"]
    return configuration["parameters"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """Return the cache of an undisturbed run, and what was identified."""
    folder = tmp_path_factory.mktemp("whole")
    code, errors = ended(folder / "cache", folder / "out")
    assert (code, errors) == (0, [])
    return folder / "cache", parameters(folder / "out")


@pytest.mark.long
@pytest.mark.parametrize("name", ["Prüfstand #1", "q\"'&;", "a\\b"])
def test_any_path_serves(name: str, whole: tuple[Path, Any], tmp_path: Path):
    cache = shutil.copytree(whole[0], tmp_path / name)
    shutil.rmtree(cache / "unpacked")
    code, errors = ended(cache, tmp_path / "out")
    assert (code, errors) == (0, [])
    assert parameters(tmp_path / "out") == whole[1]
    assert list((cache / "unpacked").iterdir())


@pytest.mark.parametrize("name", ["Prüfstand #1", "q\"'&;", "a\\b"])
def test_the_compiler_works_in_any_path(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HAPTID_CACHE", str(tmp_path / name))
    monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(tmp_path / name / "zig"))
    library = compile_shared({"one.c": "int one(void) { return 1; }\n"}, main=("one.c",))
    assert library.is_relative_to(tmp_path / name)


@pytest.mark.long
def test_a_path_that_the_tools_would_decode_costs_one_remark(whole: tuple[Path, Any], tmp_path: Path):
    code, errors = ended(tmp_path / "a%41b", tmp_path / "out")
    assert code == 0
    (line,) = errors
    assert line.startswith("note: no cache (")
    assert "set HAPTID_CACHE to a folder of yours" in line
    assert parameters(tmp_path / "out") == whole[1]


@pytest.mark.long
def test_bytecode_is_neither_written_nor_run(whole: tuple[Path, Any], tmp_path: Path):
    """The interpreter would run it in place of the source beside it, unseen; a damaged one never healed."""
    cache = shutil.copytree(whole[0], tmp_path / "cache")
    assert not list((cache / "unpacked").rglob("__pycache__"))
    (slave,) = (cache / "unpacked").rglob("*_slave.py")
    planted, marker = tmp_path / "planted.py", tmp_path / "marker"
    planted.write_text(f"open({str(marker)!r}, 'w')\n{slave.read_text(encoding='utf-8')}", encoding="utf-8")
    mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
    for source in slave.parent.rglob("*.py"):
        target = source.parent / "__pycache__" / f"{source.stem}.{sys.implementation.cache_tag}.pyc"
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(b"damaged")
        if source == slave:
            py_compile.compile(str(planted), str(target), invalidation_mode=mode)
    code, errors = ended(cache, tmp_path / "out")
    assert (code, errors) == (0, [])
    assert parameters(tmp_path / "out") == whole[1]
    assert not marker.exists()
    assert not list((cache / "unpacked").rglob("__pycache__"))
