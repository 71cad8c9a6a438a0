"""Numbers with their standard errors as text."""

from __future__ import annotations

import math

from haptid.support.numbers import choose_unit, plain

HALF_WIDTH_95 = 1.96
"""Half width of a normal 95 % interval, in standard deviations."""


def with_error(value: float, std: float) -> str:
    """Write ``value ± std``, the error to two digits and the value to the same decimal place.

    Parameters
    ----------
    value
        Estimate.
    std
        Its standard error. Where it is not positive and finite, the value stands alone.

    Returns
    -------
    str
        Both numbers before one power of ten where the larger is below 1e-3 or at least 1e6.

    Examples
    --------
    >>> with_error(0.0151423, 0.000066)
    '0.015142 ± 0.000066'
    >>> with_error(1.5e-6, 2.1e-8)
    '(1.500 ± 0.021)e-06'
    >>> with_error(2.0, 0.0)
    '2'
    """
    if not (math.isfinite(std) and std > 0 and math.isfinite(value)):
        return f"{value:.6g}"
    power = math.floor(math.log10(max(abs(value), std)))
    scale = 10.0**power if power < -3 or power > 5 else 1.0
    digits = max(1 - math.floor(math.log10(std / scale)), 0)
    text = f"{value / scale:.{digits}f} ± {std / scale:.{digits}f}"
    return text if scale == 1.0 else f"({text})e{power:+03d}"


def round_to_error(value: float, std: float) -> str:
    """Write a value to a tenth of its standard deviation's first digit, with at least two and at most nine digits.

    Parameters
    ----------
    value
        Number in any unit.
    std
        Its standard deviation, in the same unit.

    Returns
    -------
    str
        Four digits where the standard deviation is not positive and finite, or the value is 0.

    Examples
    --------
    >>> round_to_error(0.0151423, 0.000066)
    '0.015142'
    """
    if not (std > 0 and math.isfinite(std)) or value == 0:
        return f"{value:.4g}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(std)) + 2
    return f"{value:.{min(max(digits, 2), 9)}g}"


def write_gain(gain: float) -> str:
    """Write a difference of log-likelihoods or of criteria in whole numbers, of those from a million on three digits.

    Parameters
    ----------
    gain
        Difference [1].

    Returns
    -------
    str

    Examples
    --------
    >>> write_gain(1234.56), write_gain(16184308724.967)
    ('1235', '1.62e+10')
    """
    return f"{gain:.0f}" if abs(gain) < 999_999.5 else f"{gain:.3g}"


def in_thousandths(value: float, unit: str, beside: float = 0.0) -> str:
    """Write a residual in mrad, mm or mN m, so that a column can be read down; from 1 on in the unit itself.

    Parameters
    ----------
    value
        Residual in ``unit``.
    unit
        SI unit without prefix; two units joined by ``or`` both take the prefix.
    beside
        Size of what the residual is read beside, as the drive's torque, in ``unit``.

    Returns
    -------
    str
        Three digits, or ``diverged`` where the value is not finite.

    Examples
    --------
    >>> in_thousandths(2.1e-4, "rad"), in_thousandths(0.249, "m"), in_thousandths(2.592, "N")
    ('0.21 mrad', '249 mm', '2.59 N')
    """
    if not math.isfinite(value):
        return "diverged"
    unit, factor = choose_unit(max(abs(value), beside), unit)
    return f"{plain(factor * value, 3)} {unit}"
