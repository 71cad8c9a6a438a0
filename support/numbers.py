"""Numbers within a sentence."""

from __future__ import annotations


def plain(value: float, digits: int = 2) -> str:
    """Write a number without an exponent below a million.

    Parameters
    ----------
    value
        The number.
    digits
        Significant digits; a number of more digits before the point is rounded and written out.

    Examples
    --------
    >>> plain(129.4), plain(9.96), plain(0.0456), plain(2.5e7)
    ('130', '10', '0.046', '2.5e+07')
    """
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text and 1.0 <= abs(value) < 999_999.5 else text
