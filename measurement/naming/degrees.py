"""Degrees as the languages of tables spell them: ``Winkel (Grad)`` or ``degrés`` in, whether they are meant out."""

from __future__ import annotations

import re

DEGREES = r"(?<![^\W\d_])(?:grad(?:e|i|en|os)?|degr[eé]s?)(?![^\W\d_])"
"""Pattern of degrees in German, Italian, Dutch, Spanish and French, without regard to large and small letters.

``grad`` alone is also what calculators call the gon, of which 400 make a turn: `is_bare_grad`. That has a word of its
own in German, ``Gon``, so that ``Grad`` is a degree.
"""
_BARE_GRAD = re.compile(r"(?<![^\W\d_])grad(?![^\W\d_])")


def is_bare_grad(name: str) -> bool:
    """Whether a name has the unit ``grad`` in small letters, which is a degree in a joint's table and else the gon.

    Parameters
    ----------
    name
        Name of a column.

    Returns
    -------
    bool
    """
    return _BARE_GRAD.search(name) is not None
