"""Numbers within a sentence."""

from __future__ import annotations

import math
import re

PREFIXES = ("", "m", "µ", "n")
"""Prefixes of units for each thousandth, from one down."""
MOST_DIGITS = 12
"""Most significant digits of the ends of a narrow interval."""
LARGEST_STD_OVER_RANGE = 10.0
"""Largest standard deviation over a quantity's range [1] that is told by its number."""


def plain(value: float, digits: int = 2) -> str:
    """Write a number without an exponent below a million.

    Parameters
    ----------
    value
        The number.
    digits
        Significant digits; a number of more digits before the point is rounded and written out.

    Returns
    -------
    str
        The number, rounded.

    Examples
    --------
    >>> plain(129.4), plain(9.96), plain(0.0456), plain(2.5e7)
    ('130', '10', '0.046', '2.5e+07')
    """
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text and 1.0 <= abs(value) < 999_999.5 else text


def write_interval(low: float, high: float, digits: int) -> str:
    """Write the ends of an interval, with further digits where they would read the same.

    Parameters
    ----------
    low, high
        Ends.
    digits
        Significant digits that are enough for most intervals.

    Returns
    -------
    str
        As ``0.1 to 0.2``.

    Examples
    --------
    >>> write_interval(0.1, 0.23456, 4), write_interval(0.359998, 0.360002, 4)
    ('0.1 to 0.2346', '0.359998 to 0.360002')
    """
    for enough in range(digits, MOST_DIGITS + 1):
        ends = f"{low:.{enough}g}", f"{high:.{enough}g}"
        if ends[0] != ends[1]:
            break
    return " to ".join(ends)


def with_unit(number: str, unit: str) -> str:
    """Write the unit behind a number, an interval or a sum; none behind a quantity without one.

    Parameters
    ----------
    number
        Number in words.
    unit
        Its unit; ``1`` where it has none.

    Returns
    -------
    str
        As ``0.1 N m``.

    Examples
    --------
    >>> with_unit("0.1 to 0.2", "N m"), with_unit("3", "1")
    ('0.1 to 0.2 N m', '3')
    """
    return number if unit == "1" else f"{number} {unit}"


def read_number(text: str) -> float:
    """Read a number, or a product of numbers, as users write the angle of an encoder count.

    Parameters
    ----------
    text
        Numbers and ``pi`` (``π``), joined by ``*`` and ``/``.

    Returns
    -------
    float
        Its value.

    Raises
    ------
    ValueError
        Where it is anything else, or divides by zero.

    Examples
    --------
    >>> read_number("2e-4"), read_number("2*pi/4096") == 2 * math.pi / 4096
    (0.0002, True)
    """
    spelled = re.sub(r"(?<=[\d.])\s*pi", "*pi", text.lower().replace("π", "pi"))  # 2π is 2*pi
    value, operator = 1.0, "*"
    for part in re.split(r"([*/])", spelled):
        if part in ("*", "/"):
            operator = part
            continue
        number = math.pi if part.strip() == "pi" else float(part)
        if operator == "/" and number == 0.0:
            message = f"division by zero in {text!r}"
            raise ValueError(message)
        value = value * number if operator == "*" else value / number
    return value


def says_nothing(std: float, lower: float, upper: float) -> bool:
    """Say whether a standard deviation is so far beyond the range of a quantity that its number means nothing.

    Parameters
    ----------
    std
        Standard deviation.
    lower, upper
        Range of the quantity, in the same unit; infinite where it has no end.

    Returns
    -------
    bool
        True beyond `LARGEST_STD_OVER_RANGE` times the range, as of a spring's equilibrium without a spring.

    Examples
    --------
    >>> says_nothing(3.7e12, -3.0, 4.8), says_nothing(3.7, -3.0, 4.8), says_nothing(3.7e12, 0.0, math.inf)
    (True, False, False)
    """
    return std > LARGEST_STD_OVER_RANGE * (upper - lower)


def times(ratio: float) -> str:
    """Write how many times something is as much as something else.

    Parameters
    ----------
    ratio
        The quotient.

    Returns
    -------
    str
        Two digits and ``times``; ``as much as`` where they are the same to two digits.

    Examples
    --------
    >>> times(17.47), times(0.997), times(1.06)
    ('17 times', 'as much as', '1.1 times')
    """
    text = plain(ratio)
    return "as much as" if text == "1" else f"{text} times"


def count_of(number: int, noun: str) -> str:
    """Write a number of things.

    Parameters
    ----------
    number
        How many.
    noun
        What one of them is; its plural ends in s.

    Returns
    -------
    str

    Examples
    --------
    >>> count_of(1, "run"), count_of(5, "run")
    ('1 run', '5 runs')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def choose_unit(largest: float, unit: str) -> tuple[str, float]:
    """Choose the unit in which numbers that stand beside each other are read: thousandths only below 1.

    Parameters
    ----------
    largest
        Largest magnitude among the numbers, in ``unit``; thousandths, too, where it is not finite.
    unit
        SI unit without prefix; two units joined by ``or`` both take the prefix.

    Returns
    -------
    unit : str
        Unit with its prefix.
    factor : float
        Number in that unit over the number in ``unit``.

    Examples
    --------
    >>> choose_unit(0.0021, "rad or m"), choose_unit(40.0, "N m")
    (('mrad or mm', 1000.0), ('N m', 1.0))
    """
    if math.isfinite(largest) and abs(largest) >= 1.0:
        return unit, 1.0
    return " or ".join(f"m{one}" for one in unit.split(" or ")), 1000.0


def with_prefix(value: float, unit: str, digits: int = 3) -> str:
    """Write a quantity with the prefix that suits its size, from nano to none.

    Parameters
    ----------
    value
        Quantity in ``unit``.
    unit
        SI unit without prefix; two units joined by ``or`` both take the prefix.
    digits
        Significant digits.

    Returns
    -------
    str
        Number and unit with its prefix.

    Examples
    --------
    >>> with_prefix(0.249, "m"), with_prefix(0.0061, "rad or m"), with_prefix(13.2, "N m"), with_prefix(1.2e-8, "m")
    ('249 mm', '6.1 mrad or mm', '13.2 N m', '12 nm')
    """
    exponent = math.floor(math.log10(abs(value)) / 3) if value else 0
    prefix = PREFIXES[min(max(-exponent, 0), len(PREFIXES) - 1)]
    scaled = value * 1000.0 ** PREFIXES.index(prefix)
    return f"{plain(scaled, digits)} " + " or ".join(f"{prefix}{one}" for one in unit.split(" or "))
