"""Without a C compiler, or with one that fails, a command ends in one line that says what to do, and writes nothing.

The environments are real ones: a virtual environment with links to all that is installed here, the compiler apart.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from haptid.support.installing.environment import VENV_PYTHON

ROOT = Path(__file__).parents[2]
OPTIONS = ["--joints", "4", "--starts", "1", "--fmu", "none", "--workers", "1", "--quiet"]


@pytest.fixture
def python(tmp_path: Path) -> Path:
    """Make an environment without ziglang and return its interpreter."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(tmp_path / "env")], check=True)
    (packages,) = (tmp_path / "env").glob("lib/python*/site-packages")
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        if not entry.name.startswith("ziglang"):
            (packages / entry.name).symlink_to(entry)
    return tmp_path / "env" / "bin" / "python"


def said(command: list[str], folder: Path, tmp_path: Path, **variables: str) -> tuple[int, list[str]]:
    environment = {**os.environ, "HAPTID_CACHE": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1", **variables}
    done = subprocess.run(
        [*command, *OPTIONS, "--out", str(tmp_path / "out")],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert not (tmp_path / "out").exists()
    return done.returncode, done.stderr.splitlines()


@pytest.mark.skipif(VENV_PYTHON.is_file(), reason="the project's own .venv takes over, which has a compiler")
def test_a_clone_without_compiler_says_what_to_run(python: Path, tmp_path: Path):
    code, lines = said([str(python), "-m", "identification.run"], ROOT, tmp_path)
    assert (code, lines) == (2, [f"error: {python} lacks ziglang; run `make fmu` first"])


def test_an_installed_package_without_compiler_says_what_to_install(python: Path, tmp_path: Path):
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "haptid", tmp_path / "site" / "haptid", ignore=ignored)  # as a wheel has it: no links
    (tmp_path / "site" / "haptid-0.1.0.dist-info").mkdir()
    about = tmp_path / "site" / "haptid-0.1.0.dist-info" / "METADATA"
    about.write_text("Metadata-Version: 2.1\nName: haptid\nVersion: 0.1.0\n", encoding="utf-8")
    variables = {"PYTHONPATH": str(tmp_path / "site")}
    code, lines = said([str(python), "-m", "haptid.identification.run"], tmp_path, tmp_path, **variables)
    assert (code, lines) == (1, ["error: the C compiler is missing: install it with python -m pip install ziglang"])


@pytest.mark.long
@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("print('line one\\nline two', file=sys.stderr); sys.exit(1)", "line one line two"),
        ("sys.exit(3)", "exit code 3, without a word; is there enough memory?"),
        ("import os; os.kill(os.getpid(), 9)", "signal 9, without a word; is there enough memory?"),
    ],
    ids=["talks", "silent", "killed"],
)
def test_a_compiler_that_fails_is_one_line(body: str, told: str, python: Path, tmp_path: Path):
    (packages,) = (tmp_path / "env").glob("lib/python*/site-packages")
    (packages / "ziglang").mkdir()
    (packages / "ziglang" / "__init__.py").write_text("", encoding="utf-8")
    (packages / "ziglang" / "__main__.py").write_text(f"import sys\n{body}\n", encoding="utf-8")
    (about,) = Path(sysconfig.get_path("purelib")).glob("ziglang-*.dist-info")
    (packages / about.name).symlink_to(about)
    code, lines = said([str(python), "-m", "identification.run"], ROOT, tmp_path)
    assert (code, lines) == (1, [f"error: the C compiler failed: {told}"])
