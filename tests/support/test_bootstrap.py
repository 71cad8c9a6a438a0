"""From an interpreter without the requirements to a running command, offline, in a small copy of the project."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from support.environment import ROOT

PROJECT = """
[project]
name = "small"
dependencies = ["greeting>=1.2"]
[dependency-groups]
dev = []
"""
COMMAND = "import greeting, sys; print(greeting.TEXT, sys.prefix)"


def wheel(folder: Path) -> None:
    """Write a wheel of the package ``greeting``."""
    info = "greeting-1.2.dist-info"
    with zipfile.ZipFile(folder / "greeting-1.2-py3-none-any.whl", "w") as archive:
        archive.writestr("greeting.py", "TEXT = 'hello'\n")
        archive.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: greeting\nVersion: 1.2\n")
        archive.writestr(
            f"{info}/WHEEL", "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        archive.writestr(f"{info}/RECORD", "")


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An interpreter with pip and nothing else."""
    folder = tmp_path_factory.mktemp("interpreter")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    return folder / "bin" / "python"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with the real support package and one command."""
    shutil.copytree(ROOT / "support", tmp_path / "support", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "pyproject.toml").write_text(PROJECT)
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "__init__.py").write_text("from support.environment import ready\n\nready()\n")
    (tmp_path / "tool" / "run.py").write_text(COMMAND)
    wheel(tmp_path)
    return tmp_path


def run(project: Path, *arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    offline = {"PIP_NO_INDEX": "1", "UV_NO_INDEX": "1", "PIP_FIND_LINKS": str(project), "UV_FIND_LINKS": str(project)}
    environment = {**os.environ, **offline, "UV_NO_CONFIG": "1", "PIP_CONFIG_FILE": os.devnull}
    return subprocess.run(
        [str(a) for a in arguments], cwd=cwd or project, env=environment, capture_output=True, text=True, check=False
    )


def test_installs_into_the_interpreter_in_use_and_runs_from_any_folder(python: Path, project: Path, tmp_path: Path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    before = run(project, python, "-m", "tool.run")
    assert before.returncode == 2
    assert before.stderr.count("\n") == 1
    assert before.stderr.endswith("lacks greeting; run `make fmu` first\n")

    done = run(project, python, project / "support" / "bootstrap.py", "-m", "tool.run", cwd=elsewhere)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["hello", str(python.parent.parent)]
    assert run(project, python, "-m", "tool.run").stdout == done.stdout
    run(project, python, "-m", "pip", "uninstall", "--yes", "greeting")


def test_a_venv_beside_the_project_is_used_by_bootstrap_and_by_the_next_command(python: Path, project: Path):
    assert run(project, python, "-m", "venv", project / ".venv").returncode == 0
    done = run(project, python, "support/bootstrap.py", "-m", "tool.run")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["hello", str(project / ".venv")]
    assert run(project, python, "-m", "tool.run").stdout == done.stdout


def test_says_how_to_call_it(python: Path, project: Path):
    done = run(project, python, "support/bootstrap.py", "tool.run")
    assert done.returncode == 2
    assert done.stderr == "error: usage: python support/bootstrap.py [--dev] -m module [arguments]\n"
