"""Words of the languages of tables: ``coppia``, ``ángulo`` or ``Grad`` in, quantity or degree out."""

from __future__ import annotations

import re
import unicodedata

QUANTITIES_ELSEWHERE: dict[str, str] = {
    "lage": "position", "winkel": "position", "drehwinkel": "position", "kraft": "force", "drehzahl": "velocity",
    "geschwindigkeit": "velocity", "drehmoment": "torque", "strom": "current", "spannung": "voltage", "zeit": "time",
    "posizione": "position", "angolo": "position", "velocita": "velocity", "coppia": "torque", "forza": "force",
    "corrente": "current", "tensione": "voltage", "tempo": "time",
    "posicion": "position", "angulo": "position", "velocidad": "velocity", "par": "torque", "fuerza": "force",
    "corriente": "current", "voltaje": "voltage", "tiempo": "time",
    "posicao": "position", "velocidade": "velocity", "forca": "force",
    "vitesse": "velocity", "couple": "torque", "courant": "current", "temps": "time",
    "positie": "position", "hoek": "position", "snelheid": "velocity", "koppel": "torque", "kracht": "force",
    "stroom": "current", "spanning": "voltage", "tijd": "time",
}  # fmt: skip
"""Quantity by word in German, Italian, Spanish, Portuguese, French and Dutch, without accents.

``tension`` is left out: it is a voltage in French and Spanish, and the pull of a cable in English.
"""
DEGREES = r"(?<![^\W\d_])(?:grad(?:e|i|en|os)?|degr[eé]s?)(?![^\W\d_])"
"""Pattern of degrees in German, Italian, Dutch, Spanish and French, without regard to large and small letters.

``grad`` alone is also what calculators call the gon, of which 400 make a turn: `is_bare_grad`. That has a word of its
own in German, ``Gon``, so that ``Grad`` is a degree.
"""
_BARE_GRAD = re.compile(r"(?<![^\W\d_])grad(?![^\W\d_])")


def plain_letters(text: str) -> str:
    """Take the accents off letters.

    Parameters
    ----------
    text
        Text as ``ángulo`` or ``velocità``.

    Returns
    -------
    str
        ``angulo`` or ``velocita``; the signs of degrees and of micro stay.
    """
    return "".join(c for c in unicodedata.normalize("NFD", text) if not unicodedata.combining(c))


def words_of(quantity: str) -> str:
    """Return the words of a quantity as alternatives of a pattern.

    Parameters
    ----------
    quantity
        Quantity as ``torque``.

    Returns
    -------
    str
        As ``drehmoment|coppia|par``.
    """
    return "|".join(word for word, means in QUANTITIES_ELSEWHERE.items() if means == quantity)


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
