"""Words of quantities in the languages of tables: ``coppia``, ``ángulo`` or ``vitesse`` in, the quantity out."""

from __future__ import annotations

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
