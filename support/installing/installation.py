"""Installation of the project's requirements by pip or uv: into the interpreter in use, or into the project's .venv.

1. Check which requirements of the wanted part the interpreter in use lacks; with none lacking go to step 4.
2. Begin again with the interpreter of ``.venv`` where there is one; it is made where packages may not go into this one.
3. Install the locked files of the part, checked by their hashes, and check again.
4. Replace this process by the module that the arguments name.

Standard library only, because it runs before anything is installed.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from collections import deque
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NoReturn

from haptid.support.installing.environment import (
    BAD_SETUP,
    ROOT,
    VENV_PYTHON,
    in_venv,
    missing,
    replace_process,
    unfinished_mark,
)
from haptid.support.installing.lock_file import CORE, DEV, Amount, amount, locked_file
from haptid.support.interrupts import INTERRUPTED

USAGE = "usage: python support/bootstrap.py [--dev | --extra NAME] [-m module [arguments]]"
LAST_LINES = 15
"""Lines of an installer's output that are shown where it fails."""
BOOTSTRAP = ROOT / "support" / "bootstrap.py"


def fail(message: str) -> NoReturn:
    """Exit with one line on stderr and exit code 2.

    Parameters
    ----------
    message
        What is wrong and what to do.

    Raises
    ------
    SystemExit
        Always.
    """
    say(f"error: {message}")
    sys.exit(BAD_SETUP)


def say(message: str) -> None:
    """Write one line of progress to stderr.

    Parameters
    ----------
    message
        The line.
    """
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def succeeds(*command: str | Path, quiet: bool = False) -> bool:
    """Run a command and say whether it succeeded.

    Parameters
    ----------
    *command
        Program and arguments; False where the program cannot be started.
    quiet
        Whether the output is dropped; otherwise it goes to stderr.

    Returns
    -------
    bool
        True where the exit code is 0.
    """
    shown = subprocess.DEVNULL if quiet else None
    try:
        done = subprocess.run([str(c) for c in command], check=False, stdout=shown or sys.stderr, stderr=shown)
    except OSError:
        return False
    return done.returncode == 0


def uv() -> str | None:
    """Find a uv that runs: the shim of a version manager can be found and still not run.

    Returns
    -------
    str or None
        Path of the program; None where there is none.
    """
    path = shutil.which("uv")
    return path if path and succeeds(path, "--version", quiet=True) else None


def has_module(name: str) -> bool:
    """Return whether the interpreter in use has a module.

    Parameters
    ----------
    name
        Name of the module.

    Returns
    -------
    bool
        True where it can be found; it is not imported.
    """
    return importlib.util.find_spec(name) is not None


def can_install_here() -> bool:
    """Say whether packages may go into the interpreter in use.

    Returns
    -------
    bool
        True where the system does not manage the interpreter (PEP 668) and the folder of its packages is writable.
    """
    managed = (Path(sysconfig.get_path("stdlib")) / "EXTERNALLY-MANAGED").exists() and sys.prefix == sys.base_prefix
    return not managed and os.access(sysconfig.get_path("purelib"), os.W_OK)


def _by_venv(folder: Path) -> bool:
    return has_module("ensurepip") and succeeds(sys.executable, "-m", "venv", "--clear", folder)


def _by_uv(folder: Path) -> bool:
    tool = uv()
    return tool is not None and succeeds(
        tool, "venv", "--quiet", "--clear", "--seed", "--python", sys.executable, folder
    )


def _by_outer_pip(folder: Path) -> bool:
    """Fill an environment without pip by the pip outside it (Debian without python3-venv)."""
    return (
        has_module("pip")
        and succeeds(sys.executable, "-m", "venv", "--clear", "--without-pip", folder)
        and succeeds(sys.executable, "-m", "pip", "--python", VENV_PYTHON, "install", "--quiet", "pip")
    )


def make_venv() -> None:
    """Make ``.venv`` by Python's venv, else by uv, else by the pip outside it; exit where none of them can."""
    folder = ROOT / ".venv"
    say(f"{sys.executable} is managed by the system or read-only: making {folder}")
    if not any(make(folder) for make in (_by_venv, _by_uv, _by_outer_pip)):
        fail(
            "no virtual environment can be made; install Python's venv module (Debian: apt install python3-venv) or uv"
        )


def install(part: str) -> None:
    """Install the locked files of a part into the interpreter in use, every file checked by its hash.

    No dependencies are resolved: the exported files are complete, and an installer that resolved would leave the lock.
    An installation that fails or is interrupted while it downloads has changed nothing; one that ends while packages
    are copied leaves the environment marked as unfinished.

    Parameters
    ----------
    part
        ``core``, ``dev`` or an extra.
    """
    again = unfinished_mark().exists()  # what a killed installer left may have its metadata and lack its files
    told = amount(part, again=again)
    say(f"installing into {sys.prefix}: {told}")
    try:
        unfinished_mark().touch()
    except OSError as error:
        fail(f"nothing can be installed into {sys.prefix}: {error}")
    copying: list[str] = []
    try:  # the mark stays where the block ends early after copying began, or where an old mark was not yet settled
        _install(part, told, copying, again=again)
        copying.clear()
        again = False
    finally:
        if not copying and not again:
            unfinished_mark().unlink()


def _install(part: str, told: Amount, copying: list[str], *, again: bool) -> None:
    options = ("--require-hashes", "--no-deps", "-r", locked_file(part))
    tool = uv()
    if tool and _follow(
        told, copying, tool, "pip", "install", "--python", sys.executable, *["--reinstall"] * again, *options
    ):
        return
    if not has_module("pip") and not succeeds(sys.executable, "-m", "ensurepip", "--default-pip", quiet=True):
        fail(f"{sys.executable} has no pip and cannot get it; install pip or uv")
    pip = (sys.executable, "-m", "pip", "install", "--progress-bar", "off", "--disable-pip-version-check")
    if not _follow(told, copying, *pip, *["--force-reinstall"] * again, *options):
        fail("the installation failed, as said above; it needs the network this one time")


def _follow(told: Amount, copying: list[str], *command: str | Path) -> bool:
    """Run an installer and show its progress, after a failure its last lines; return whether its exit code is 0."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}
    text = [str(c) for c in command]
    last: deque[str] = deque(maxlen=LAST_LINES)
    with subprocess.Popen(
        text, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment, encoding="utf-8", errors="replace"
    ) as process:
        assert process.stdout is not None  # asked for above
        try:
            _show(process.stdout, last, copying, told.count)
        except KeyboardInterrupt:
            process.terminate()
            raise
    if process.returncode != 0:
        say("\n".join(last))
    return process.returncode == 0


def _show(output: Iterable[str], last: deque[str], copying: list[str], count: int) -> None:
    """Show the progress in an installer's output; collect its ``last`` lines, and the lines that announce copying."""
    begun = 0
    for line in output:
        last.append(line.rstrip())
        if line.startswith(("Collecting ", "Processing ")):  # pip's words: from an index, from a folder
            begun += 1
            say(f"  {begun}/{count} {Path(line.split()[1]).name}")
        if line.startswith(("Prepared ", "Installing ")):  # uv's and pip's words
            copying.append(line)
        if line.startswith(("Downloading ", "Prepared ", "Installing ", "Installed ")):
            say(f"  {line.split(':')[0].strip()}")  # pip names all of them in one line after the colon


def say_what_to_type() -> None:
    """Name the interpreter for the next commands where the shell's plain ``python`` is none that can run them."""
    name = shutil.which("python")
    if name is None or not succeeds(name, "-c", "import sys; sys.exit(sys.version_info < (3, 11))", quiet=True):
        shown = VENV_PYTHON.relative_to(ROOT) if in_venv() else Path(sys.executable).name
        say(f"this shell has no `python` of version 3.11 or newer: type `{shown} -m ...` for the other commands")


def run_module(arguments: Sequence[str]) -> NoReturn:
    """Find or make an interpreter with the requirements, and run a module in it in place of this process.

    Parameters
    ----------
    arguments
        ``[--dev | --extra NAME] [-m module arguments]``; without a module the process exits after the installation.
    """
    part, command = _understand(arguments)
    os.chdir(ROOT)
    try:
        _provide(part, arguments)
    except KeyboardInterrupt:
        say("interrupted: the set-up is not complete; the same command takes it up again")
        sys.exit(INTERRUPTED)
    if not command:
        sys.exit(0)
    replace_process([sys.executable, *command])


def _understand(arguments: Sequence[str]) -> tuple[str, Sequence[str]]:
    """Return the wanted part of the lock file, and the command to run with it; exit where the usage is wrong."""
    part, command = CORE, arguments
    if arguments[:1] == ["--dev"]:
        part, command = DEV, arguments[1:]
    elif arguments[:1] == ["--extra"] and len(arguments) > 1:
        part, command = arguments[1], arguments[2:]
    unknown = part.startswith("-") or not locked_file(part).is_file()
    incomplete = command[:1] != ["-m"] or len(command) < 2
    if unknown or (incomplete and (command or part == CORE)):
        fail(USAGE)
    return part, command


def _provide(part: str, arguments: Sequence[str]) -> None:
    """Install the requirements of the part that are lacking here, or continue in the project's .venv."""

    def lacking() -> bool:
        return bool(missing(dev=part == DEV, extra=None if part in (CORE, DEV) else part))

    if not lacking():
        return
    if not in_venv():
        if not VENV_PYTHON.is_file() and not can_install_here():
            make_venv()
        if VENV_PYTHON.is_file():
            replace_process([VENV_PYTHON, BOOTSTRAP, *arguments])
    install(part)
    if lacking():
        fail(f"{locked_file(part).relative_to(ROOT)} lacks what pyproject.toml asks for; run `make locked`")
    say_what_to_type()
