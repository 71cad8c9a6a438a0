"""Fuzzing of readers: valid files, changed a little by Hypothesis, must be read or refused with one printable line.

A `Target` names a reader: some valid files as bytes, and a function that reads such bytes in an empty folder. To add
one, write both and put the target into the table of `tests/fuzz/targets.py`; nothing else is needed. The suite then
runs 2,000 inputs of it (`tests/fuzz/test_fuzz.py`), ``python -m tests.fuzz.run --target NAME --inputs N`` as many as
wanted, and inputs that once failed are stored below ``tests/fuzz/seeds/NAME/`` and replayed by the suite.

    def read_note(content: bytes, folder: Path) -> None:
        (folder / "note.txt").write_bytes(content)
        my_reader(folder / "note.txt")

    Target(name="note", examples=(b"a valid note",), read=read_note)

Whatever ``read`` raises beside `HaptidError` is a fault; so is an error's line that is longer than 300 characters or
holds what no terminal prints, a call of more than 5 s of computing time, and memory that grows by more than 500 MiB.
"""

from __future__ import annotations

import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from hypothesis import strategies as st

from haptid.support.errors import LONGEST, HaptidError

IN_MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # mkdtemp makes a folder of its own
"""Where inputs lie: a disk that others use as well makes a million of them take hours."""
MOST_SECONDS = 5.0
MOST_MIB = 500.0
TOKEN = re.compile(rb"[^\s,;=<>\"'\[\]{}():]+")
NASTY = (
    b"", b" ", b"\0", b"\n", b"\r", b"\t", b";", b",", b"#", b'"', b"'", b"=", b"]]>", b"*/", b"{{ }}", b"\\\n", b"??/",
    b"nan", b"-inf", b"inf", b"1e307", b"-1e308", b"1e400", b"1e-300", b"-0", b"0", b"-1", b"1_000", b"0x1F", b"1,5",
    b"9" * 19, b"9" * 400, b"9" * 5000, b"-" + b"9" * 400, b"null", b"true", b"None", b"[]", b"{}", b"[[]]", b'""',
    b"[" * 5000, b"{" * 5000, b"(" * 5000, b"<a>" * 2000, b"a" * 300, b"a." * 2000, b"../x", b"/etc/passwd", b"a\0b",
    b"\xff", b"\xed\xa0\x80", b"\xef\xbb\xbf", "ü".encode("latin-1"), "ü𝄞\u202e\u2028".encode(), b"\x1b[2J",
    b"<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]>", b"1979-05-27T07:32:00Z", b"\"\\u0000\"", b"\"\\ud800\"",
)  # fmt: skip
"""What gets into files: other types, extreme numbers, deep nests, controls, broken and bidirectional text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A reader under test.

    Parameters
    ----------
    name
        As ``--target`` and the folder of stored inputs name it.
    examples
        Valid files, from which inputs are made.
    read
        Called with the changed bytes and an empty folder of its own.
    nasty
        Pieces beside `NASTY` that this format should meet (keys of the format, other sections, …).
    tested
        Inputs of a run of the tests.
    """

    name: str
    examples: tuple[bytes, ...]
    read: Callable[[bytes, Path], object]
    nasty: tuple[bytes, ...] = ()
    tested: int = 700


def peak_mib() -> float:
    """Return the highest resident memory of this process so far [MiB]."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10


class Fault(AssertionError):  # noqa: N818 (it is what was looked for)
    """A reader did what no reader may."""


@dataclass(slots=True)
class Tally:
    """What the inputs of one target came to: how many, read, refused, and the worst time and memory."""

    inputs: int = 0
    read: int = 0
    worst_seconds: float = 0.0
    peak_growth_mib: float = 0.0
    base_mib: float = field(default_factory=peak_mib)


def inputs_of(target: Target) -> st.SearchStrategy[bytes]:
    """Return a strategy for files of ``target``: an example with one to four changes."""
    nasty = (*target.nasty, *NASTY)
    piece = st.one_of(st.sampled_from(nasty), st.binary(max_size=6))
    change = st.tuples(st.sampled_from(CHANGES), st.integers(0, 65535), st.integers(0, 65535), piece)
    changes = st.lists(change, min_size=1, max_size=4)
    return st.builds(_changed, st.sampled_from(target.examples), changes)


def drawn(target: Target, numbers: random.Random) -> bytes:
    """Draw one such file without Hypothesis, in microseconds; half of them have a single change, which gets further."""
    nasty = (*target.nasty, *NASTY)
    changes = []
    for _ in range(numbers.choice((1, 1, 1, 2, 3, 4))):
        piece = numbers.choice(nasty) if numbers.random() < 0.5 else numbers.randbytes(numbers.randrange(7))
        changes.append((numbers.choice(CHANGES), numbers.randrange(65536), numbers.randrange(65536), piece))
    return _changed(numbers.choice(target.examples), changes)


def _changed(example: bytes, changes: list[tuple[Callable[..., bytes], int, int, bytes]]) -> bytes:
    for change, first, second, piece in changes:
        example = change(example, first, second, piece)
    return example


def _insert(data: bytes, first: int, _second: int, piece: bytes) -> bytes:
    at = _place(first, len(data))
    return data[:at] + piece + data[at:]


def _overwrite(data: bytes, first: int, _second: int, piece: bytes) -> bytes:
    at = _place(first, len(data))
    return data[:at] + piece + data[at + len(piece) :]


def _flip(data: bytes, first: int, second: int, _piece: bytes) -> bytes:
    if not data:
        return data
    at = min(_place(first, len(data)), len(data) - 1)
    return data[:at] + bytes([data[at] ^ (1 << second % 8)]) + data[at + 1 :]


def _cut(data: bytes, first: int, second: int, _piece: bytes) -> bytes:
    at = _place(first, len(data))
    return data[:at] + data[at + 1 + second % 64 :]


def _truncate(data: bytes, first: int, _second: int, _piece: bytes) -> bytes:
    return data[: _place(first, len(data))]


def _replace_token(data: bytes, first: int, _second: int, piece: bytes) -> bytes:
    tokens = list(TOKEN.finditer(data))
    if not tokens:
        return piece
    token = tokens[first % len(tokens)]
    return data[: token.start()] + piece + data[token.end() :]


def _swap_tokens(data: bytes, first: int, second: int, _piece: bytes) -> bytes:
    tokens = list(TOKEN.finditer(data))
    if not tokens:
        return data
    one, other = tokens[first % len(tokens)], tokens[second % len(tokens)]
    return _replace_token(_replace_token(data, first, 0, other.group()), second, 0, one.group())


def _drop_line(data: bytes, first: int, _second: int, _piece: bytes) -> bytes:
    lines = data.splitlines(keepends=True)
    return b"".join(line for k, line in enumerate(lines) if k != first % len(lines)) if lines else data


def _repeat_line(data: bytes, first: int, second: int, _piece: bytes) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    lines.insert(second % len(lines), lines[first % len(lines)])
    return b"".join(lines)


def _replace_line(data: bytes, first: int, _second: int, piece: bytes) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return piece
    lines[first % len(lines)] = piece + b"\n"
    return b"".join(lines)


def _place(number: int, length: int) -> int:
    return number * length // 65535  # a place in the file, spread over its length


CHANGES = (
    _replace_token, _swap_tokens, _insert, _overwrite, _flip, _cut, _truncate, _drop_line, _repeat_line, _replace_line,
)  # fmt: skip


def call(target: Target, content: bytes, tally: Tally | None = None) -> None:
    """Let the target read ``content`` in a new folder.

    Raises
    ------
    Fault
        Where the reader does anything but read or refuse in one line, in time and within the memory.
    """
    tally = tally or Tally()
    folder = Path(tempfile.mkdtemp(prefix="fuzz-", dir=IN_MEMORY))
    begun = time.process_time()
    try:
        with _time_limit(target.name), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # remarks about what was read are no fault
            target.read(content, folder)
        tally.read += 1
    except HaptidError as error:
        _check_line(target.name, str(error))
    except (Fault, KeyboardInterrupt):
        raise
    except BaseException as error:
        msg = f"{target.name}: {type(error).__name__}: {str(error)[:200]}"
        raise Fault(msg) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        tally.inputs += 1
        tally.worst_seconds = max(tally.worst_seconds, time.process_time() - begun)
        tally.peak_growth_mib = max(tally.peak_growth_mib, peak_mib() - tally.base_mib)
    if tally.peak_growth_mib > MOST_MIB:
        msg = f"{target.name}: memory grew by {tally.peak_growth_mib:.0f} MiB"
        raise Fault(msg)


def _check_line(name: str, line: str) -> None:
    if len(line) > LONGEST or not line.isprintable():
        msg = f"{name}: no printable line of at most {LONGEST} characters: {line[:400]!r}"
        raise Fault(msg)


@contextmanager
def _time_limit(name: str) -> Iterator[None]:
    """Raise in a call that computes for more than 5 s (pytest's own time limit uses the other timer)."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        msg = f"{name}: more than {MOST_SECONDS} s"
        raise Fault(msg)

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
