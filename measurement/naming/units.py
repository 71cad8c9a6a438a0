"""Units as names of real tables spell them, and how many of the campaign format's unit each is."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from haptid.measurement.format.columns import NUMBERED
from haptid.measurement.naming.languages import DEGREES

DEG = math.pi / 180
INCH = 0.0254
KILOPOND = 9.80665
"""Weight of a kilogram [N]."""
POUND = 0.45359237 * KILOPOND
"""Weight of a pound [N]."""
COUNTS = "counts"
UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0), "sec": ("s", 1.0), "seconds": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9),
    "min": ("s", 60.0), "mins": ("s", 60.0), "minutes": ("s", 60.0),
    "rad": ("rad", 1.0), "mrad": ("rad", 1e-3), "deg": ("rad", DEG), "degree": ("rad", DEG), "degrees": ("rad", DEG),
    "urad": ("rad", 1e-6), "mdeg": ("rad", 1e-3 * DEG), "arcmin": ("rad", DEG / 60), "arcsec": ("rad", DEG / 3600),
    "gon": ("rad", math.pi / 200), "rev": ("rad", 2 * math.pi), "turns": ("rad", 2 * math.pi),
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6),
    "counts": (COUNTS, 1.0), "count": (COUNTS, 1.0), "cnt": (COUNTS, 1.0), "ticks": (COUNTS, 1.0),
    "rad/s": ("rad_s", 1.0), "mrad/s": ("rad_s", 1e-3), "deg/s": ("rad_s", DEG), "dps": ("rad_s", DEG),
    "rpm": ("rad_s", 2 * math.pi / 60),
    "m/s": ("m_s", 1.0), "mm/s": ("m_s", 1e-3),
    "Nm": ("Nm", 1.0), "mNm": ("Nm", 1e-3), "Nmm": ("Nm", 1e-3), "Ncm": ("Nm", 1e-2), "kNm": ("Nm", 1e3),
    "uNm": ("Nm", 1e-6), "mNmm": ("Nm", 1e-6), "mNcm": ("Nm", 1e-5),
    "lbfin": ("Nm", POUND * INCH), "lbfft": ("Nm", POUND * 12 * INCH), "ozfin": ("Nm", POUND / 16 * INCH),
    "kgfcm": ("Nm", KILOPOND * 1e-2), "kgfm": ("Nm", KILOPOND), "gfcm": ("Nm", KILOPOND * 1e-5),
    "N": ("N", 1.0), "mN": ("N", 1e-3), "kN": ("N", 1e3), "daN": ("N", 10.0),
    "lbf": ("N", POUND), "kgf": ("N", KILOPOND),
    "A": ("A", 1.0), "mA": ("A", 1e-3), "V": ("V", 1.0), "mV": ("V", 1e-3), "C": ("C", 1.0),
    "%": ("", 1e-2), "percent": ("", 1e-2), "pct": ("", 1e-2),
}  # fmt: skip
"""Unit of the campaign format, and how many of it one of the user's unit is, by the user's unit."""
IN_BRACKETS = re.compile(r"[\[(]([^\[\]()]+)[\])]\s*$")
"""A unit in brackets at the end of a name."""


def _pounds(found: re.Match[str]) -> str:
    """Spell inch-pounds, foot-pounds and inch-ounces as `UNITS` does."""
    weight, length = (found[1], found[2]) if found[1] else (found[4], found[3])
    return f"{weight}f{length}".lower()


SPELLINGS: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (r"(?<=[a-z]{3})(?=[A-Z][a-z])", " "),  # PositionActualValue
    (r"(?i)(?<![a-z])dc[\s_-]*(?:link|bus)(?:[\s_-]*circuit)?(?![a-z])", " dclink "),
    (r"(?i)(?<![a-z])i[\s_]?q(?![a-z])", " iq "),  # the current that makes the torque
    (r"(?i)(soll|ist)[\s_-]?wert", r" \1wert "),  # Lageistwert
    (r"(?i)(?<![a-z])(motor|antriebs|achs|gelenk)(?=dreh|moment|winkel|lage|kraft|strom|spannung)", " motor "),
    (r"(?i)(?<![a-z])soll[\s_-]?(?=pos|lage|winkel|dreh|strom|geschw)", " sollwert "),
    (r"(?i)(?<![a-z])ist[\s_-]?(?=pos|lage|winkel|dreh|strom|geschw)", " istwert "),
    (r"(?i)(?<![a-z])millis(?:econds?)?(?![a-z])", " time ms "),  # as Arduino's clocks are called
    (r"(?i)(?<![a-z])micros(?:econds?)?(?![a-z])", " time us "),
    (r"[µμ]", "u"),
    (r"°\s*C\b", " C "),
    (rf"°|(?i:{DEGREES})", " deg "),
    (r"(?:(?<=\b[mku]N)|(?<=\bN))[\s*·.]+(?=[cm]?m\b)", ""),  # N·m, N mm, mN*m
    (r"(?i)(?<![a-z])(?:(lb|oz)f?[\s*·._-]*(in|ft)|(in|ft)[\s*·._-]*(lb|oz)f?)s?(?![a-z])", _pounds),
    (r"(?i)(?<![a-z])(k?g)f?[\s*·.]*(c?m)(?![a-z])", r"\1f\2"),  # kgf cm, kg·cm
    (r"(?<![A-Za-z])(rad|mrad|deg|degrees|m|mm)(?:\s*/\s*|\s*_per_| per |\s*_)(?:s|sec)(?![A-Za-z])", r"\1/s"),
)
"""Patterns of other spellings of units, and the spelling in `UNITS`."""


def unit_of_column(name: str) -> str:
    """Return the unit of a column of the campaign format.

    Parameters
    ----------
    name
        Name as ``torque_0_Nm`` or ``time_s``.

    Returns
    -------
    str
        Unit as the name has it; empty for a pure number, as a duty.
    """
    parts = NUMBERED.split(name)
    return parts[-1].lstrip("_") if len(parts) > 1 else name.rpartition("_")[2]


def unit_in_brackets(name: str) -> tuple[str, str, float] | None:
    """Read the unit that stands in brackets behind a name.

    Parameters
    ----------
    name
        Name of a column, as ``u (V)``.

    Returns
    -------
    tuple or None
        The unit as it is written, that of the campaign format, and how many of it one is; None without a known unit.
    """
    found = IN_BRACKETS.search(name)
    if found is None:
        return None
    unit = unit_of(respell(found[1]).strip())
    return None if unit is None else (found[1].strip(), *UNITS[unit])


def respell(text: str) -> str:
    """Write units as this module spells them.

    Parameters
    ----------
    text
        Name of a column, or its unit.

    Returns
    -------
    str
    """
    for pattern, spelling in SPELLINGS:
        text = re.sub(pattern, spelling, text)
    return text


def unit_of(word: str) -> str | None:
    """Return a unit as `UNITS` spells it; large and small letters count only where they tell units apart.

    Parameters
    ----------
    word
        As it is written.

    Returns
    -------
    str or None
        None where it is no unit.
    """
    if word in UNITS:
        return word
    near = [unit for unit in UNITS if unit.lower() == word.lower()]
    return near[0] if len(near) == 1 else None
