"""Numbers within a sentence."""

from __future__ import annotations

import math


def plain(value: float, digits: int = 2) -> str:
    """Return ``value`` to ``digits`` significant digits, without an exponent below a million.

    >>> plain(129.4), plain(3.14159), plain(0.0456), plain(2.5e7)
    ('130', '3.1', '0.046', '2.5e+07')
    """
    if not math.isfinite(value) or not 1.0 <= abs(value) < 999_999.5:
        return f"{value:.{digits}g}"
    return f"{float(f'{value:.{digits - 1}e}'):.{max(digits - 1 - math.floor(math.log10(abs(value))), 0)}f}"
