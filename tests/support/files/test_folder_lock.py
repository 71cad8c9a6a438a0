"""The lock of an output folder: seen by every process, gone with its holder, and no clutter."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from haptid.support.errors import HaptidError, InputError
from haptid.support.files import folder_lock
from haptid.support.files.folder_lock import NAME, lock_folder

ROOT = Path(__file__).parents[3]
HOLDER = """
import sys, time
from pathlib import Path
from haptid.support.files.folder_lock import lock_folder
with lock_folder(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def holder(folder: Path, temporary: Path) -> subprocess.Popen[str]:
    """Start a process that holds ``folder``, with temporary files elsewhere, and wait until it does."""
    environment = {**os.environ, "TMPDIR": str(temporary), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", HOLDER, str(folder)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_process_with_another_temporary_folder_sees_it_and_death_ends_it(tmp_path: Path):
    with holder(tmp_path / "out", tmp_path) as process:
        with pytest.raises(InputError, match="another one is writing there"), lock_folder(tmp_path / "out"):
            pass
        process.send_signal(signal.SIGKILL)
    with lock_folder(tmp_path / "out"):
        (tmp_path / "out" / "a").touch()
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a"]


def test_folders_are_made_and_go_where_nothing_was_written(tmp_path: Path):
    with lock_folder(tmp_path / "a" / "b"):
        assert (tmp_path / "a" / "b" / NAME).exists()
    assert not list(tmp_path.iterdir())
    with pytest.raises(KeyError), lock_folder(tmp_path / "a"):
        raise KeyError
    assert not list(tmp_path.iterdir())


def test_a_link_in_the_lock_s_place_is_not_followed(tmp_path: Path):
    (tmp_path / NAME).symlink_to(tmp_path / "other")
    with pytest.raises(HaptidError, match="could not be written"), lock_folder(tmp_path):
        pass
    assert not (tmp_path / "other").exists()


def test_a_file_system_without_locks_costs_a_remark(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def refused(_: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(folder_lock, "_take", refused)
    with lock_folder(tmp_path):
        pass
    assert capsys.readouterr().err.count("\n") == 1
    assert not list(tmp_path.iterdir())


AS_NOBODY = """
import fcntl, os, sys  # while they can be read
from pathlib import Path
from haptid.support.command import exit_codes
from haptid.support.files.folder_lock import lock_folder

@exit_codes
def main():
    with lock_folder(Path(".")):
        pass

os.chdir(sys.argv[1])  # the folders above may be root's alone
os.setuid(65534)
main()
"""


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can become somebody else")
@pytest.mark.parametrize("mode", [0o600, 0o644])
def test_another_user_s_lock_holds_too(mode: int, tmp_path: Path):
    """Two users of one shared folder, whatever the umask of the one who came first."""
    tmp_path.chmod(0o777)
    with lock_folder(tmp_path):
        (tmp_path / NAME).chmod(mode)
        done = subprocess.run(
            [sys.executable, "-c", AS_NOBODY, str(tmp_path)],
            env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "another one is writing there" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_draft_of_a_killed_command_goes_and_no_other_file_does(tmp_path: Path):
    killed = tmp_path / ".identification.json.0123456789ab.haptid-draft"
    others = [tmp_path / name for name in (".identification.json.0123456789ab", ".x.haptid-draft", "a.haptid-draft")]
    for path in (killed, *others):
        path.write_text("half", encoding="utf-8")
    with lock_folder(tmp_path):
        assert not killed.exists()
        assert all(path.exists() for path in others)
