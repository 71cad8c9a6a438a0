"""The conventions that all commands share: exit codes, common options, progress on stderr.

The decorators take the function of a command and return one that keeps the conventions.
"""

from __future__ import annotations

import errno
import functools
import os
import select
import shlex
import sys
import tempfile
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ParamSpec, TextIO, TypeVar

import click

from haptid.support.errors import LONGEST, HaptidError, InputError, one_line, shorten
from haptid.support.files.files import check_writable, written
from haptid.support.files.folder_lock import lock_folder
from haptid.support.interrupts import INTERRUPTED, TERMINATED, Terminated, interrupts_raise
from haptid.support.listener import Listener
from haptid.support.tables import Told
from haptid.support.terminal import Display, show

P = ParamSpec("P")
T = TypeVar("T")
CLOSED = 141
"""Exit code that shells give to commands ended by SIGPIPE: 128 plus the signal's number."""
_FULL = (errno.ENOSPC, errno.EDQUOT)


def exit_codes(function: Callable[P, None]) -> Callable[P, None]:
    """Decorate a command: its errors become one line on stderr and the documented exit code.

    Parameters
    ----------
    function
        Command, which may raise.

    Returns
    -------
    Callable
        Exits with 2 after an `InputError`, with 1 after other errors of haptid, of the system or of memory, and with
        `INTERRUPTED`, `TERMINATED` or `CLOSED` after Ctrl-C, SIGTERM or a pipe without reader.
    """

    @functools.wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        written.clear()  # files of an earlier command in this process
        try:
            with interrupts_raise():
                function(*args, **kwargs)
        except HaptidError as error:
            click.echo(f"error: {shorten(one_line(str(error)), LONGEST)}", err=True)
            sys.exit(error.exit_code)
        except BrokenExecutor:
            todo = "repeat, with fewer --workers where memory was short"
            click.echo(f"error: a worker process was killed; {_wrote_anything()}; {todo}", err=True)
            sys.exit(HaptidError.exit_code)
        except MemoryError:
            click.echo(f"error: not enough memory; {_wrote_anything()}; repeat with fewer --workers", err=True)
            sys.exit(HaptidError.exit_code)
        except OSError as error:
            if isinstance(error, BrokenPipeError) and _nobody_reads():
                sys.exit(CLOSED)
            where = f"{error.filename}: " if error.filename is not None else ""
            told = shorten(one_line(where + (error.strerror or str(error))), LONGEST - 150)
            todo = (
                f"; free some space there, in {tempfile.gettempdir()} and in the cache" if error.errno in _FULL else ""
            )
            click.echo(f"error: {told}; {_wrote_anything()}{shorten(todo, 100)}", err=True)
            sys.exit(HaptidError.exit_code)
        except (KeyboardInterrupt, click.Abort) as stop:
            sys.exit(_tell_interruption(stop))

    return wrapped


def _tell_interruption(stop: BaseException) -> int:
    """Tell on stderr that the command was interrupted, and return its exit code."""
    if isinstance(stop, click.Abort):  # Ctrl-C, or the end of the replies, at a question: its line is open
        click.echo(err=True)
    # Who knows more than that says it with the interruption.
    click.echo(f"interrupted: {one_line(str(stop)) or _wrote_anything()}", err=True)
    return TERMINATED if isinstance(stop, Terminated) else INTERRUPTED


def _nobody_reads() -> bool:
    """Whether standard output or error is a pipe whose reader has left (``| head``).

    Such a stream is redirected to nowhere, so that output at the interpreter's end causes no second error.
    """
    left = [stream for stream in (sys.stdout, sys.stderr) if _has_no_reader(stream)]
    for stream in left:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    return bool(left)


def _has_no_reader(stream: TextIO) -> bool:
    try:
        if not hasattr(select, "poll"):  # Windows: what could not be written fails again
            stream.flush()
            return False
        poll = select.poll()
        poll.register(stream, select.POLLOUT)
        return any(event & (select.POLLERR | select.POLLHUP) for _, event in poll.poll(0))
    except BrokenPipeError:
        return True
    except (OSError, ValueError):  # closed, or no file of the system's
        return False


def _wrote_anything() -> str:
    """Say whether this command has written any file outside the cache."""
    # Compiled kernels in the cache are no results that a user could find.
    cached = Path(os.environ.get("HAPTID_CACHE") or Path("~/.cache/haptid").expanduser()).absolute()
    own = any(not path.absolute().is_relative_to(cached) for path in written)
    return "what was finished is kept" if own else "nothing was finished yet"


def word_command(verb: str, module: str) -> str:
    """Return a command in the form in which the user called this one; a Python program may have no clone.

    Parameters
    ----------
    verb
        Name below ``haptid``, such as ``check``.
    module
        The same command as a module of a clone, such as ``measurement.check``.

    Returns
    -------
    str
        ``haptid check`` within a call of ``haptid`` or of the API, ``python -m measurement.check`` within one of a
        module.
    """
    context = click.get_current_context(silent=True)
    if context is None or (context.parent is not None and context.find_root().info_name == "haptid"):
        return f"haptid {verb}"
    return f"python -m {module}"


def word_again(verb: str, module: str, without: Collection[str], options: str) -> str:
    """Return the command that the user typed, with other options: how an interrupted one goes on.

    Parameters
    ----------
    verb, module
        As `word_command` takes them.
    without
        Options with a value that are left out, as ``--joints``.
    options
        Options that stand in their place.

    Returns
    -------
    str
        As it is typed, quoted where a shell needs it.
    """
    command = word_command(verb, module)
    # Below haptid the command's own name is the first argument.
    typed = iter(sys.argv[2:] if command.startswith("haptid") else sys.argv[1:])
    kept = []
    for argument in typed:
        if argument in without:
            next(typed, None)
        elif argument.partition("=")[0] not in without:
            kept.append(argument)
    return " ".join(filter(None, (command, shlex.join(kept), options)))


def parse_joints(text: str | None, option: str = "--joints") -> tuple[int, ...] | None:
    """Parse the value of ``--joints 4,5,3``.

    Parameters
    ----------
    text
        Value of the option; None where the option is absent.
    option
        Name of the option in errors.

    Returns
    -------
    tuple of int or None
        Numbers of the joints in their order; None where the option is absent.

    Raises
    ------
    InputError
        Where a part is no whole number.
    """
    if text is None:
        return None
    try:
        joints = tuple(int(part) for part in text.split(","))
    except ValueError:
        raise InputError(option, expected="joint numbers separated by commas, as in 4,5,3", got=repr(text)) from None
    return joints


def common_options(function: Callable[P, T]) -> Callable[P, T]:
    """Decorate a command with the common options: --out, --joints, --seed, --workers, --scheduler, --quiet.

    The output folder is tried for writing, and locked against other commands, before any work begins.

    Parameters
    ----------
    function
        Function of a command.

    Returns
    -------
    callable
        Command that hands on the values of its options to ``function``.
    """
    function = _with_folder(function)
    options = [
        click.option(
            "--out",
            type=click.Path(path_type=Path, file_okay=False),
            default=Path("artifacts"),
            show_default=True,
            help="Folder for everything that is written.",
        ),
        click.option("--joints", default=None, metavar="4,5,3", help="Only these joints."),
        click.option("--seed", type=int, default=0, show_default=True, help="Same seed, same result, bit for bit."),
        click.option(
            "--workers",
            type=click.IntRange(min=1),
            default=os.cpu_count() or 1,
            show_default="cores",
            help="Processes on this machine.",
        ),
        click.option(
            "--scheduler",
            default=None,
            metavar="tls://HOST:PORT",
            help="A running Dask scheduler to use instead of processes here (extra 'cluster'): tls:// with the "
            "certificates of Dask's configuration; tcp:// sends pickles, which are code, unencrypted.",
        ),
        click.option("--quiet", is_flag=True, help="No progress on stderr."),
    ]
    for option in reversed(options):  # click lists the options of a decorator applied last first
        function = option(function)
    return function


def _with_folder(function: Callable[..., T]) -> Callable[..., T]:
    @functools.wraps(function)
    @exit_codes  # type: ignore[arg-type] # what click calls returns nothing
    def wrapped(*args: Any, out: Path, **kwargs: Any) -> T:
        check_writable(out)
        with lock_folder(out):
            return function(*args, out=out, **kwargs)

    return wrapped  # type: ignore[return-value] # as above


@contextmanager
def listening(*, quiet: bool = False) -> Iterator[Listener]:
    """Listen to a computation within the block: a bar and notes on stderr, summaries of finished parts on stdout.

    Parameters
    ----------
    quiet
        Whether the bar is not shown (--quiet); notes and summaries always are.

    Yields
    ------
    Listener
        For the functions of the packages.
    """
    display = Display(quiet=quiet)

    def note(text: str) -> None:
        display.close()  # the line would stand behind the bar
        click.echo(text, err=True)

    def finished(told: Told) -> None:
        display.close()
        show(told)

    try:
        yield Listener(progress=display.show, note=note, finished=finished)
    finally:
        display.close()
