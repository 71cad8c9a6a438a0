"""TOML and JSON text in, plain values out; values that a later step cannot take are refused with line or key."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from haptid.support.errors import InputError

MOST_NESTED_LEVELS = 64
"""Most levels of tables and lists: no format that is read needs a third of them."""
MOST_DIGITS = 4300
"""Most digits of a whole number that Python converts from text."""
FITTING = "numbers of at most 64 bits"
"""Whole numbers that are accepted, in the words of an error."""
_HALF_CHARACTER = re.compile(r"\\u[dD][89a-fA-F]")
OPEN_ENDED = ("lower", "upper", "position_limits")
"""Keys under which infinity means that there is no bound."""


def parse_toml(text: str, path: str, *, finite: bool = False) -> dict[str, Any]:
    """Parse a TOML text.

    Parameters
    ----------
    text
        Content of the file.
    path
        Name of the file in errors.
    finite
        Whether NaN is refused, and infinity where it is no bound (`OPEN_ENDED`).

    Returns
    -------
    dict
        Content of the file, tables as dicts.

    Raises
    ------
    InputError
        Where the text is no TOML (the error names the line), is nested too deeply, or holds a whole number of more than
        64 bits or a number that ``finite`` refuses.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+)", str(error))
        line = found.group(1) if found else str(len(text.splitlines()))
        where = f"{path}, line {line}"
        raise InputError(where, expected="valid TOML", got=str(error)) from None
    except RecursionError:
        raise _too_deep(path) from None
    except ValueError:  # of all numbers only those of thousands of digits get here
        raise _too_long(path, text) from None
    _check_values(data, path, text, finite=finite)
    return data


def parse_json(text: str, path: str, wanted: str = "") -> Any:
    """Parse a JSON text.

    Parameters
    ----------
    text
        Content of the file.
    path
        Name of the file in errors.
    wanted
        Kind of file that is expected, in words.

    Returns
    -------
    Any
        Value that the text stands for: dict, list, str, number, bool or None.

    Raises
    ------
    InputError
        Where the text is no JSON (NaN and Infinity are none), is nested too deeply, names a key twice in one object, or
        holds half a character, a whole number of more than 64 bits or a number that overflows.
    """
    try:
        data = json.loads(text, parse_constant=_Refused, parse_int=_whole, object_pairs_hook=_distinct)
        if _HALF_CHARACTER.search(text):  # what cannot be written again, or shown
            json.dumps(data, ensure_ascii=False, default=str).encode()
    except json.JSONDecodeError as error:
        where = f"{path}, line {error.lineno}"
        todo = "the file may have been cut off" if error.pos >= len(text.rstrip()) else ""
        raise InputError(where, expected=f"JSON, {wanted}".rstrip(", "), got=error.msg, todo=todo) from None
    except UnicodeEncodeError:
        raise InputError(path, expected="whole characters", got=r"half of one, as \ud800") from None
    except RecursionError:
        raise _too_deep(path) from None
    _check_values(data, path, finite=True)
    return data


@dataclass(frozen=True, slots=True)
class _Refused:
    """Mark of a value that Python's reader takes and JSON forbids, kept in place until its key is known."""

    got: str
    expected: str = "JSON"


def _whole(text: str) -> int | _Refused:
    digits = len(text.lstrip("-"))  # counted first: Python refuses to convert more than `MOST_DIGITS`
    if digits < MOST_DIGITS and -(2**63) <= int(text) < 2**63:
        return int(text)
    return _Refused(f"a number of {digits} digits", FITTING)


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any] | _Refused:
    found = dict(pairs)
    if len(found) == len(pairs):
        return found
    times = Counter(name for name, _ in pairs)
    return _Refused(f"{next(name for name in times if times[name] > 1)!r} twice in one object")


def _too_deep(path: str) -> InputError:
    return InputError(path, expected=f"at most {MOST_NESTED_LEVELS} levels of brackets", got="more")


def _too_long(path: str, text: str) -> InputError:
    """Name the line of a whole number that Python does not convert; no fraction and no text has as many digits."""
    number = re.search(rf"\d[\d_]{{{MOST_DIGITS - 1},}}", text)
    line = f", line {text.count(chr(10), 0, number.start()) + 1}" if number else ""
    got = f"a number of {len(number.group().replace('_', ''))} digits" if number else "a number that is too long"
    return InputError(f"{path}{line}", expected=FITTING, got=got)


def _line_of(digits: str, path: str, text: str) -> str:
    """Name the line of a TOML text in which a whole number stands, ``''`` where it is not written in plain digits."""
    number = re.search(rf"(?<![\w.]){'_?'.join(digits)}(?![\w.])", text)
    return f"{path}, line {text.count(chr(10), 0, number.start()) + 1}" if number else ""


def _check_values(data: Any, path: str, text: str = "", *, finite: bool) -> None:
    """Refuse values nested too deeply, whole numbers of more than 64 bits, and NaN or infinity where ``finite``."""
    for key, depth, value in _walk(data):
        where = f"{path}: {key}"
        if depth > MOST_NESTED_LEVELS:
            raise _too_deep(path)
        if isinstance(value, _Refused):
            raise InputError(where if key else path, expected=value.expected, got=value.got)
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            digits = str(abs(value))
            raise InputError(
                _line_of(digits, path, text) or where, expected=FITTING, got=f"a number of {len(digits)} digits"
            )
        if finite and isinstance(value, float) and not _is_allowed(key, value):
            raise InputError(where, expected="a finite number", got=repr(value))


def _is_allowed(key: str, value: float) -> bool:
    bound = re.sub(r"\[\d+\]$", "", key).rpartition(".")[2] in OPEN_ENDED
    return math.isfinite(value) or (bound and not math.isnan(value))


def _walk(data: Any) -> Iterator[tuple[str, int, Any]]:
    """Yield key path, depth and value of every value, the outermost first."""
    left: list[tuple[str, int, Any]] = [("", 0, data)]  # a list and no recursion: the depth is not checked yet
    while left:
        key, depth, value = left.pop()
        yield key, depth, value
        if isinstance(value, dict):
            left += [(f"{key}.{name}" if key else str(name), depth + 1, entry) for name, entry in value.items()]
        elif isinstance(value, list):
            left += [(f"{key}[{index}]", depth + 1, entry) for index, entry in enumerate(value)]
