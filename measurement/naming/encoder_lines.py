"""Counts of an encoder's turn in a logger's line: ``encoder: 1024 lines, quadrature x4`` in, 4096 by 1024 × 4 out.

1. Counts of a turn are the number itself, as in ``counts per turn: 4096``.
2. Lines, pulses or cycles of a turn (``lines``, ``PPR``, ``CPR``) make counts by a stated factor, ``x4`` where each
   edge of both tracks counts (quadrature).
3. Without a factor one of them may make four counts, two or one. ``CPR`` stands for cycles as for counts, too.
4. An absolute encoder of n bits has 2^n counts.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

FACTORS = (4, 2, 1)
"""Counts that a line of an encoder may make, likeliest first."""
_NUMBER = r"(?<![\w.,])(?P<number>\d{1,3}(?:,\d{3})+|\d+)(?:[.,]0+)?(?!\d|[.,]\d)"
"""A number, also with commas between thousands."""
_PER_TURN = r"[\s_-]*(?:per|/|a)[\s_-]*(?:turn|rev(?:olution)?|rotation)\w*"
_COUNTS = rf"(?:counts?|cnts?|ticks?){_PER_TURN}"
_CYCLES = rf"(?:(?P<short>[pc]pr)|(?P<long>lines?|pulses?|cycles?)(?P<per>{_PER_TURN})?)"
_FACTOR = r"(?:[x×*]\s*(?P<factor>[124])|(?P<times>[124])(?:\s*[x×]|[\s-]?fold))(?!\w|[.,]\d)"
_OFF = r"(?P<off>(?:quad(?:rature)?|decod\w*)[\s:=-]*(?:off|none|disabled)|no\s+quad(?:rature)?)(?!\w)"
_BETWEEN = r"(?:[\s,;:()\[\]/=-]|quad(?:rature)?|(?:de|en)cod\w*|counting|mode|with|by|in|at)*"
PRODUCT = re.compile(rf"{_NUMBER}\s*[x×*]\s*(?P<factor>[124])[\s_-]*(?:{_COUNTS}|{_CYCLES})(?!\w)", re.IGNORECASE)
"""``1024 x 4 counts/rev``: the counts are worked out in the line."""
COUNTS_OF_A_TURN = tuple(
    re.compile(form, re.IGNORECASE)
    for form in (rf"(?<![a-z]){_COUNTS}\W{{0,4}}{_NUMBER}", rf"{_NUMBER}[\s_-]*{_COUNTS}")
)
CYCLES_OF_A_TURN = tuple(
    re.compile(form, re.IGNORECASE)
    for form in (rf"{_NUMBER}[\s_-]*{_CYCLES}(?!\w)", rf"(?<![a-z]){_CYCLES}\W{{0,4}}{_NUMBER}")
)
FACTOR_ALONE = re.compile(rf"(?:quad(?:rature)?|decod\w*|counting){_BETWEEN}{_FACTOR}|{_OFF}", re.IGNORECASE)
"""The factor in a line of its own, as ``quadrature: x4``; without quadrature it is 1."""
FACTOR_BEHIND = re.compile(rf"{_BETWEEN}(?:{_FACTOR}|{_OFF})", re.IGNORECASE)
"""The factor behind a number and its unit, as ``, quadrature x4``."""
BITS = re.compile(r"(?<![\w.,])(?P<bits>\d{1,2})[\s-]*bits?(?!\w)", re.IGNORECASE)
"""``12 bit``: 2 to that power."""
FEWEST_BITS, MOST_BITS = 6, 32
"""Bits that an encoder's turn may have."""
ENCODER = re.compile(r"encod|quadratur|decod|resolution", re.IGNORECASE)
"""Words without which lines and cycles may be those of anything."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LineCounts:
    """Counts of a turn by a logger's line.

    Parameters
    ----------
    counts
        The number; several where the line leaves open which of them it is, likeliest first.
    how
        How it was computed, as ``1024 × 4``; empty where the line says the number itself.
    """

    counts: tuple[int, ...]
    how: str = ""


def factor_in_line(line: str) -> int | None:
    """Read how many counts a line of the encoder makes from a line that says nothing else of it.

    Parameters
    ----------
    line
        Line of a logger on itself, as ``quadrature: x4``.

    Returns
    -------
    int or None
        None where the line says nothing of it, or says the counts as well.
    """
    found = None if counts_in_line(line) else FACTOR_ALONE.search(line)
    return None if found is None else _factor_of(found)


def times(read: LineCounts, factor: int) -> LineCounts:
    """Multiply the lines of an encoder, of which another line says how many counts each makes.

    Parameters
    ----------
    read
        Counts that a line leaves open, the number of lines the last of them.
    factor
        Counts that a line makes.

    Returns
    -------
    LineCounts
        The product; ``read`` as it is where it leaves open something else.
    """
    lines = read.counts[-1]
    return _multiply(lines, factor) or read if read.counts == tuple(each * lines for each in FACTORS) else read


def counts_in_line(line: str) -> LineCounts | None:
    """Read how many counts make a turn from a line.

    Parameters
    ----------
    line
        Line of a logger on itself.

    Returns
    -------
    LineCounts or None
        None where the line says nothing of it.
    """
    product = PRODUCT.search(line)
    if product is not None:
        return _multiply(_whole(product), int(product["factor"]))
    counts = next(filter(None, (form.search(line) for form in COUNTS_OF_A_TURN)), None)
    if counts is not None:
        number, factor = _whole(counts), _factor_behind(counts)
        # Whether the factor is in the number already, the line does not say.
        return _found(number) if factor in (None, 1) else _found(number, factor * number)
    cycles = next(filter(None, (form.search(line) for form in CYCLES_OF_A_TURN)), None)
    if cycles is None:
        return _bits_of_a_turn(line)
    if not (cycles["short"] or cycles["per"] or ENCODER.search(line)):
        return None
    number, factor = _whole(cycles), _factor_behind(cycles)
    return _found(*(each * number for each in FACTORS)) if factor is None else _multiply(number, factor)


def _factor_behind(found: re.Match[str]) -> int | None:
    behind = FACTOR_BEHIND.match(found.string, found.end())
    return None if behind is None else _factor_of(behind)


def _factor_of(found: re.Match[str]) -> int:
    return 1 if found["off"] else int(found["factor"] or found["times"])


def _whole(found: re.Match[str]) -> int:
    return int(found["number"].replace(",", ""))


def _bits_of_a_turn(line: str) -> LineCounts | None:
    """Return the counts of an encoder whose line says how many bits a turn has; a converter's bits are none of it."""
    found = {int(one["bits"]) for one in BITS.finditer(line)} if re.search("encod", line, re.IGNORECASE) else set()
    if len(found) != 1 or not FEWEST_BITS <= (bits := found.pop()) <= MOST_BITS:
        return None
    return _found(2**bits, how=f"2^{bits}")


def _multiply(number: int, factor: int) -> LineCounts | None:
    return _found(number * factor, how=f"{number} × {factor}")


def _found(*counts: int, how: str = "") -> LineCounts | None:
    """Return the counts; none where they are none that an encoder has."""
    return LineCounts(counts=counts, how=how) if min(counts) > 1 else None
