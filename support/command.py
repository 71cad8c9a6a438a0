"""The conventions that all commands share: exit codes, common options, progress on stderr."""

from __future__ import annotations

import functools
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import ParamSpec, TypeVar

import click
from tqdm import tqdm

from support.errors import HaptidError, InputError, one_line

P = ParamSpec("P")
T = TypeVar("T")
INTERRUPTED, TERMINATED = 130, 143


class Terminated(KeyboardInterrupt):
    """SIGTERM, as ``timeout``, a batch system or a container sends it: a command ends as it does on Ctrl-C."""


@contextmanager
def _termination_ends_like_an_interrupt() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def exit_codes(function: Callable[P, None]) -> Callable[P, None]:
    """Turn errors into one line on stderr and the documented exit code."""

    @functools.wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with _termination_ends_like_an_interrupt():
                function(*args, **kwargs)
        except HaptidError as error:
            click.echo(f"error: {one_line(str(error))}", err=True)
            sys.exit(error.exit_code)
        except KeyboardInterrupt as stop:
            click.echo("interrupted: what was finished is kept", err=True)
            sys.exit(TERMINATED if isinstance(stop, Terminated) else INTERRUPTED)

    return wrapped


def parse_joints(text: str | None, option: str = "--joints") -> tuple[int, ...] | None:
    """Read ``--joints 4,5,3``; None where the option is absent."""
    if text is None:
        return None
    try:
        joints = tuple(int(part) for part in text.split(","))
    except ValueError:
        raise InputError(option, expected="joint numbers separated by commas, as in 4,5,3", got=repr(text)) from None
    return joints


def common_options(function: Callable[P, T]) -> Callable[P, T]:
    """Add the options of every command: --out, --joints, --seed, --workers, --scheduler, --quiet."""
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
            metavar="tcp://HOST:PORT",
            help="A running Dask scheduler to use instead of processes here.",
        ),
        click.option("--quiet", is_flag=True, help="No progress on stderr."),
    ]
    for option in reversed(options):
        function = option(function)
    return function


def progress(
    iterable: Iterable[T] | None = None, *, total: int | None = None, title: str = "", quiet: bool = False
) -> tqdm[T]:
    """Progress bar on stderr; silent under --quiet."""
    return tqdm(iterable, total=total, desc=title, disable=quiet, file=sys.stderr, dynamic_ncols=True, leave=False)  # type: ignore[return-value] # the stub allows an iterable of nothing
