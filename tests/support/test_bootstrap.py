"""From an interpreter without the requirements to a running command, offline, in a small copy of the project."""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from haptid.support.installing.environment import ROOT

PROJECT = """
[project]
name = "small"
dependencies = ["greeting>=1.2"]
[project.optional-dependencies]
loud = ["shouting>=3"]
[dependency-groups]
dev = []
"""
COMMAND = "import greeting, sys; print(greeting.TEXT, sys.prefix)"


LOCK = """
[[package]]
name = "{name}"
version = "{version}"
wheels = [{{ url = "https://index.example/{wheel}", hash = "sha256:{digest}", size = 6000000 }}]
"""


def wheel(folder: Path, name: str, version: str, locked: str) -> str:
    """Write a wheel with a text and its entry in uv.lock, and return its pin."""
    info = f"{name}-{version}.dist-info"
    path = folder / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"{name}.py", "TEXT = 'hello'\n")
        archive.writestr(f"{info}/METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        archive.writestr(
            f"{info}/WHEEL", "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        archive.writestr(f"{info}/RECORD", "")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    with (folder / "uv.lock").open("a") as lock:
        lock.write(LOCK.format(name=name, version=version, wheel=path.name, digest=digest))
    pin = f"{name}=={version} \\\n    --hash=sha256:{digest}\n"
    with (folder / "support" / "installing" / "locked" / f"{locked}.txt").open("a") as stream:
        stream.write(pin)
    return pin


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
    shutil.copytree(ROOT / "haptid", tmp_path / "haptid", symlinks=True)
    (tmp_path / "pyproject.toml").write_text(PROJECT)
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "__init__.py").write_text(
        "from haptid.support.installing.environment import ready\n\nready()\n"
    )
    (tmp_path / "tool" / "run.py").write_text(COMMAND)
    locked = tmp_path / "support" / "installing" / "locked"
    shutil.rmtree(locked)
    locked.mkdir()
    core = wheel(tmp_path, "greeting", "1.2", "core")
    (locked / "loud.txt").write_text(core)
    wheel(tmp_path, "shouting", "3.0", "loud")
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
    told = "1 distribution, 6 MB to download, about 24 MB on disk"
    assert f"installing into {python.parent.parent}: {told}\n  1/1 greeting" in done.stderr
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
    assert done.stderr == "error: usage: python support/bootstrap.py [--dev | --extra NAME] [-m module [arguments]]\n"


def test_a_file_that_the_lock_does_not_know_is_not_installed(python: Path, project: Path):
    with zipfile.ZipFile(project / "greeting-1.2-py3-none-any.whl", "a") as archive:
        archive.writestr("more.py", "")
    done = run(project, python, "support/bootstrap.py", "-m", "tool.run")
    assert done.returncode == 2
    assert "DO NOT MATCH THE HASHES" in done.stderr
    assert done.stderr.endswith("error: the installation failed, as said above; it needs the network this one time\n")
    assert run(project, python, "-c", "import greeting").returncode == 1


def test_an_extra_is_installed_when_it_is_asked_for(python: Path, project: Path):
    done = run(project, python, "support/bootstrap.py", "--extra", "loud")
    assert done.returncode == 0, done.stderr
    assert "2 distributions, 12 MB to download" in done.stderr
    assert run(project, python, "-c", "import greeting, shouting").returncode == 0
    assert run(project, python, "support/bootstrap.py", "--extra", "loud").stderr == ""
    assert run(project, python, "support/bootstrap.py", "--extra", "silent").returncode == 2
    run(project, python, "-m", "pip", "uninstall", "--yes", "greeting", "shouting")


def test_an_interrupted_installation_is_one_line_and_is_done_again(python: Path, project: Path):
    slow = project / "pip"  # an installer that has copied one of two packages and hangs
    slow.mkdir()
    (slow / "__init__.py").touch()
    (slow / "__main__.py").write_text(
        "import time; print('Collecting greeting\\nInstalling it', flush=True); time.sleep(60)"
    )
    command = [str(python), "support/bootstrap.py", "-m", "tool.run"]
    environment = {**os.environ, "PYTHONPATH": str(project), "PATH": "/usr/bin:/bin"}
    begun = time.monotonic()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job hands down that it is ignored
    try:
        process = subprocess.Popen(command, cwd=project, env=environment, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, before)
    with process:
        assert process.stderr is not None
        assert "to download" in process.stderr.readline()
        assert "1/1 greeting" in process.stderr.readline()
        assert "Installing it" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == "interrupted: the set-up is not complete; the same command takes it up again\n"
    assert process.returncode == 130
    assert time.monotonic() - begun < 30

    shutil.rmtree(slow)
    run(project, python, "-m", "pip", "install", "--no-deps", project / "greeting-1.2-py3-none-any.whl")
    assert "run `make fmu` first" in run(project, python, "-m", "tool.run").stderr  # there, yet not known to be whole
    done = run(project, python, "support/bootstrap.py", "-m", "tool.run")
    assert done.returncode == 0, done.stderr
    assert "1/1 greeting" in done.stderr
    assert run(project, python, "-m", "tool.run").returncode == 0
    run(project, python, "-m", "pip", "uninstall", "--yes", "greeting")


def test_after_a_failed_installation_it_is_done_anew(python: Path, project: Path):
    (project / "greeting-1.2-py3-none-any.whl").rename(project / "away")
    assert run(project, python, "support/bootstrap.py", "-m", "tool.run").returncode == 2
    assert not list(python.parent.parent.rglob("haptid-installation-unfinished"))  # it failed before it copied anything
    (project / "away").rename(project / "greeting-1.2-py3-none-any.whl")
    assert run(project, python, "support/bootstrap.py", "-m", "tool.run").returncode == 0
    run(project, python, "-m", "pip", "uninstall", "--yes", "greeting")
