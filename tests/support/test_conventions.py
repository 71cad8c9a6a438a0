"""Exit codes, one-line errors, atomic files, joint lists."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from haptid.support.command import common_options, exit_codes, parse_joints
from haptid.support.errors import InputError, NumericalError
from haptid.support.files.cache import cache_folder
from haptid.support.files.files import WritingError, write_bytes, write_json, write_text

ROOT = Path(__file__).parents[2]


def command(error: BaseException | None) -> click.Command:
    @click.command()
    @exit_codes
    def main() -> None:
        if error is not None:
            raise error

    return main


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (None, 0, ""),
        (InputError("a.csv, line 3", expected="a number", got="'x'", todo="remove it"), 2,
         "error: a.csv, line 3: expected a number, got 'x'; remove it\n"),
        (NumericalError("no start\nconverged"), 1, "error: no start converged\n"),
        (KeyboardInterrupt(), 130, "interrupted: nothing was finished yet\n"),
    ],
)  # fmt: skip
def test_errors_end_with_their_code_and_one_line(error: BaseException | None, code: int, line: str):
    result = CliRunner().invoke(command(error))
    assert (result.exit_code, result.stderr, result.stdout) == (code, line, "")


def test_an_unforeseen_error_is_not_hidden():
    result = CliRunner().invoke(command(ZeroDivisionError()))
    assert isinstance(result.exception, ZeroDivisionError)


def test_input_errors_cross_process_boundaries():
    error = InputError("x", expected="a", got="b", todo="c")
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), str(copy), copy.todo) == (InputError, str(error), "c")


@pytest.mark.parametrize(("text", "joints"), [(None, None), ("4", (4,)), ("4,5, 3", (4, 5, 3))])
def test_joint_lists(text: str | None, joints: tuple[int, ...] | None):
    assert parse_joints(text) == joints


def test_bad_joint_list_names_the_option():
    with pytest.raises(InputError, match="--joints: expected joint numbers"):
        parse_joints("4;5")


def test_every_command_has_the_common_options():
    @click.command()
    @common_options
    def main(**_options: object) -> None: ...

    text = CliRunner().invoke(main, ["--help"]).output
    assert all(o in text for o in ("--out", "--joints", "--seed", "--workers", "--scheduler", "--quiet"))


def test_files_are_whole_or_absent(tmp_path: Path):
    path = tmp_path / "deep" / "result.json"
    write_json(path, {"a": [1, 2.5], "ω": "rad/s"})
    assert path.read_text(encoding="utf-8").startswith('{\n "a"')
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"a": float("nan")})
    assert "rad/s" in path.read_text(encoding="utf-8")
    assert [p.name for p in path.parent.iterdir()] == ["result.json"]


def test_a_failed_write_keeps_the_old_file_and_leaves_no_litter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = write_text(tmp_path / "a.txt", "old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(WritingError, match="No space left"):
        write_bytes(path, b"new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_cache_folder_follows_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HAPTID_CACHE", str(tmp_path))
    assert cache_folder("symbolic") == tmp_path / "symbolic"
    assert (tmp_path / "symbolic").is_dir()


def test_a_terminated_command_ends_as_on_ctrl_c():
    lines = (
        "import os, signal, time",
        "from haptid.support.command import exit_codes",
        "@exit_codes",
        "def main() -> None:",
        "    os.kill(os.getpid(), signal.SIGTERM)",
        "    time.sleep(60)",
        "main()",
    )
    command = [sys.executable, "-c", "\n".join(lines)]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (143, "interrupted: nothing was finished yet\n")
