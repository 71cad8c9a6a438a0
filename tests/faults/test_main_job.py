"""What the main job does when something breaks: one line, the right exit code, and no file that looks whole and is not.

The commands are real processes on an embedded campaign's first joints. HAPTID_KILLS sets how many moments are tried.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from haptid.support.files.folder_lock import lock_folder

ROOT = Path(__file__).parents[2]
KILLS = int(os.environ.get("HAPTID_KILLS", "1"))
COMMAND = [
    sys.executable, "-m", "identification.run", "--campaign", "paper", "--joints", "4,5", "--fmu", "none",
    "--starts", "1", "--quiet",
]  # fmt: skip
LEFT_OUT = ("wall_s", "command")


def started(out: Path, **options: Any) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*COMMAND, "--workers", "1", "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=ROOT, **options,
    )  # fmt: skip


def ended(out: Path, **options: Any) -> tuple[int, list[str]]:
    """Run to the end; return the exit code and the lines on stderr."""
    process = started(out, **options)
    _, errors = process.communicate(timeout=300)
    return process.returncode, errors.splitlines()


def content(out: Path) -> str:
    """Return what identification.json says, the times and the command apart."""

    def kept(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: kept(entry) for key, entry in value.items() if key not in LEFT_OUT}
        return [kept(entry) for entry in value] if isinstance(value, list) else value

    return json.dumps(kept(json.loads((out / "identification.json").read_text(encoding="utf-8"))), sort_keys=True)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """Return the folder of an undisturbed run, and the seconds that it took."""
    out = tmp_path_factory.mktemp("whole")
    begun = time.monotonic()
    code, errors = ended(out)
    assert code == 0, errors
    return out, time.monotonic() - begun


@pytest.mark.long
@pytest.mark.parametrize("moment", range(KILLS))
def test_a_killed_run_goes_on_to_the_same_bits(moment: int, whole: tuple[Path, float], tmp_path: Path):
    reference, seconds = whole
    process = started(tmp_path / "out")
    time.sleep(random.Random(moment).uniform(0.4, 1.0) * seconds)  # the first part is imports
    process.kill()
    process.communicate()
    file = tmp_path / "out" / "identification.json"
    if file.exists():
        before = json.loads(file.read_text(encoding="utf-8"))
        assert not before["complete"] or (tmp_path / "out" / "report.html").exists()
    assert ended(tmp_path / "out")[0] == 0
    assert content(tmp_path / "out") == content(reference)
    assert not [path.name for path in (tmp_path / "out").iterdir() if path.suffix == ".json" and path != file]


def configurations_in(file: Path) -> int:
    """Return how many configurations a result holds; what bears the name is whole at any moment."""
    return len(json.loads(file.read_text(encoding="utf-8"))["configurations"]) if file.exists() else 0


@pytest.mark.long
@pytest.mark.parametrize("finished", [1, 2])
def test_a_run_that_is_killed_with_partial_results_goes_on_from_them(
    finished: int, whole: tuple[Path, float], tmp_path: Path
):
    """Killed at the moment when so many of the two configurations are on the disk, before the report is."""
    file = tmp_path / "out" / "identification.json"
    process = started(tmp_path / "out")
    while configurations_in(file) < finished:
        assert process.poll() is None
        time.sleep(0.002)
    process.kill()
    process.communicate()
    before = json.loads(file.read_text(encoding="utf-8"))
    assert len(before["configurations"]) == finished
    assert not before["complete"] or (tmp_path / "out" / "report.html").exists()
    assert ended(tmp_path / "out") == (0, [])
    assert content(tmp_path / "out") == content(whole[0])
    walls = [c["wall_s"] for c in json.loads(file.read_text(encoding="utf-8"))["configurations"]]
    assert walls[:finished] == [c["wall_s"] for c in before["configurations"]]  # taken over, not fitted again
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "draws",
        "identification.json",
        "pages",
        "report.html",
    ]


@pytest.mark.long
def test_a_full_disk_leaves_nothing_that_looks_whole(whole: tuple[Path, float], tmp_path: Path):
    """The system refuses every byte of a file beyond what identification.json and the draws need, not the report."""
    before = [whole[0] / "identification.json", *(whole[0] / "draws").iterdir()]
    most = max(file.stat().st_size for file in before) + 2000
    assert (whole[0] / "report.html").stat().st_size > most

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    code, errors = ended(tmp_path / "out", preexec_fn=limited)
    assert code == 1
    assert len(errors) == 1
    assert "report.html: could not be written (File too large)" in errors[0]
    data = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))
    assert data["complete"] is False
    assert sorted(entry.name for entry in (tmp_path / "out").iterdir()) == ["draws", "identification.json"]
    assert ended(tmp_path / "out")[0] == 0
    assert content(tmp_path / "out") == content(whole[0])


def test_a_folder_that_cannot_be_made_is_told_before_any_work(tmp_path: Path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    code, errors = ended(tmp_path / "file" / "out")
    assert code == 2
    assert errors == [f"error: {tmp_path}/file/out: expected a folder, got the file {tmp_path}/file; name another one"]


def test_two_runs_into_one_folder(tmp_path: Path):
    with lock_folder(tmp_path / "out"):
        code, errors = ended(tmp_path / "out")
    assert code == 2
    assert len(errors) == 1
    assert "another one is writing there" in errors[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.long
@pytest.mark.parametrize(
    "settings",
    [
        {"LC_ALL": "C", "TZ": "Pacific/Auckland", "PYTHONUTF8": "0"},
        {"LC_ALL": "de_DE.UTF-8", "LC_NUMERIC": "de_DE.UTF-8"},
    ],
    ids=["C", "de_DE"],
)
def test_locale_and_time_zone_change_no_bit(settings: dict[str, str], whole: tuple[Path, float], tmp_path: Path):
    out = tmp_path / "mit Blank, Ümlaut & #"
    code, errors = ended(out, env={**os.environ, **settings})
    assert code == 0, errors
    assert content(out) == content(whole[0])


def test_the_umask_is_followed(tmp_path: Path):
    script = "import pathlib; from haptid.support.files.files import write_text as w; w(pathlib.Path('a.txt'), 'a')"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, check=True, umask=0o077)
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o600


WORKER = """
import os, signal
from haptid.support.command import exit_codes
from haptid.support.processes.pool import Pool

def die():
    os.kill(os.getpid(), signal.SIGKILL)

@exit_codes
def main():
    with Pool(1) as pool:
        pool.submit(die).result()

if __name__ == "__main__":
    main()
"""


def test_a_killed_worker_is_one_line(tmp_path: Path):
    (tmp_path / "main.py").write_text(WORKER, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(tmp_path / "main.py")], env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "error: a worker process was killed; nothing was finished yet; "
        "repeat, with fewer --workers where memory was short"
    ]


BEGINNING = """
import runpy, signal, sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job inherits that it is ignored
sys.argv[0] = "-m"  # as python -m has it while it imports the package
import identification

print("begun", flush=True)
runpy._run_module_as_main("identification.run")
"""


@pytest.mark.parametrize("delay", [0.05, 0.5])
def test_ctrl_c_while_modules_are_imported_is_one_line(delay: float, tmp_path: Path):
    command = [sys.executable, "-c", BEGINNING, *COMMAND[3:], "--out", str(tmp_path / "out")]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors.splitlines() == ["interrupted: nothing was finished yet"]
