"""Homes, disks and pipes that are not as one wishes: an exit code, at most one line, and the result."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
JOB = [
    "-m", "identification.run", "--campaign", "paper", "--joints", "4", "--starts", "1", "--workers", "1", "--quiet",
]  # fmt: skip
Mount = Callable[[str], Path]


def ended(arguments: list[str], *, without: tuple[str, ...] = (), **variables: str) -> tuple[int, list[str]]:
    """Run Python to its end; return the exit code and the lines on stderr."""
    environment = {name: value for name, value in os.environ.items() if name not in without} | variables
    done = subprocess.run(
        [sys.executable, *arguments],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    return done.returncode, done.stderr.splitlines()


@pytest.fixture
def mount(tmp_path: Path) -> Iterator[Mount]:
    """Mount a tmpfs with the given options; where that is not allowed the test is left out."""
    folder = tmp_path / "mounted"

    def mounted(options: str) -> Path:
        folder.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        if not shutil.which("mount") or subprocess.run(command, capture_output=True, check=False).returncode:
            pytest.skip("no tmpfs can be mounted here")
        return folder

    yield mounted
    subprocess.run(["umount", str(folder)], capture_output=True, check=False)


@pytest.mark.long
def test_a_home_that_cannot_be_written_costs_one_remark(tmp_path: Path):
    (tmp_path / "home").touch()
    left_out = ("HAPTID_CACHE", "MPLCONFIGDIR", "XDG_CONFIG_HOME", "XDG_CACHE_HOME")
    code, lines = ended([*JOB, "--out", str(tmp_path / "out")], without=left_out, HOME=str(tmp_path / "home"))
    assert code == 0
    assert len(lines) == 1
    assert "set HAPTID_CACHE to a folder of yours" in lines[0]


@pytest.mark.long
@pytest.mark.parametrize("size", ["64k", "1m"])
def test_a_full_disk_below_the_cache_is_one_line(size: str, mount: Mount, tmp_path: Path):
    cache = mount(f"size={size}") / "cache"
    code, lines = ended(
        [*JOB, "--out", str(tmp_path / "out")], without=("ZIG_GLOBAL_CACHE_DIR",), HAPTID_CACHE=str(cache)
    )
    assert code == 1
    assert len(lines) == 1
    assert lines[0].startswith(f"error: {cache}")
    assert "No space left on device" in lines[0]
    assert "free some space" in lines[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.long
@pytest.mark.parametrize("kind", ["python", "none"])
def test_a_cache_that_no_program_may_run_from_costs_one_remark(kind: str, mount: Mount, tmp_path: Path):
    cache = mount("size=200m,noexec") / "cache"
    code, lines = ended([*JOB, "--fmu", kind, "--out", str(tmp_path / "out")], HAPTID_CACHE=str(cache))
    assert code == 0
    assert len(lines) == 1
    assert "is mounted noexec" in lines[0]
    assert "set HAPTID_CACHE to a folder of yours" in lines[0]


def test_no_folder_that_programs_may_run_from_is_one_line(mount: Mount, tmp_path: Path):
    folder = mount("size=200m,noexec")
    variables = {"HAPTID_CACHE": str(folder / "cache"), "TMPDIR": str(folder)}
    code, lines = ended([*JOB, "--out", str(tmp_path / "out")], **variables)
    assert code == 2
    assert lines[-1].startswith("error: HAPTID_CACHE: expected a folder that can hold programs that run")
    assert len(lines) <= 2


@pytest.mark.long
@pytest.mark.parametrize("buffered", ["", "1"])
@pytest.mark.parametrize("command", ["measurement.check", "model.plan", "identification.run"])
def test_a_reader_that_leaves_ends_a_command_in_silence(command: str, buffered: str, tmp_path: Path):
    options = {
        "measurement.check": ["--quiet"],
        "model.plan": ["--quiet", "--out", str(tmp_path / "out")],
        "identification.run": [*JOB[2:], "--fmu", "none", "--out", str(tmp_path / "out")],
    }
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run(
        [sys.executable, "-m", command, *options[command]], env={**os.environ, "PYTHONUNBUFFERED": buffered}, cwd=ROOT,
        stdout=theirs, stderr=subprocess.PIPE, text=True, timeout=300, check=False,
    )  # fmt: skip
    os.close(theirs)
    assert (done.returncode, done.stderr) == (141, "")


LEFT = """
import os, signal, time
from haptid.support.processes.pool import Pool

if __name__ == "__main__":
    with Pool(2) as pool:
        [task.result() for task in [pool.submit(time.sleep, 0.1) for _ in range(4)]]
        os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_command_leaves_no_words(tmp_path: Path):
    """Python's tracker of semaphores outlives the command, and would tell the terminal of those that leaked."""
    (tmp_path / "main.py").write_text(LEFT, encoding="utf-8")
    code, lines = ended([str(tmp_path / "main.py")], PYTHONPATH=str(ROOT))
    assert (code, lines) == (-9, [])
