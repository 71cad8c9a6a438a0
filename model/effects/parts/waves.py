"""Waves over position, a_s·sin(n·q) + a_c·cos(n·q), alone or as a series, which the effects periodic in position share.

A series is a family of effects under one name: h harmonics of one fundamental, one block of 2·h amplitudes.
"""

from __future__ import annotations

import numpy as np
import sympy as sp

from haptid.model.effects.effect import parameter
from haptid.model.equations.quantity import Quantity

_q = sp.Symbol("q", real=True)
COARSE = tuple(float(x) for x in np.arange(1.0, 14.6, 0.5))
"""Grid of n times half the span of positions; two neighbours differ by half a radian of phase at the ends.

A wave much longer than the travel is a polynomial of low order there: a spring or gravity, with names of their own. So
the grid's first value, a third of a wave over the travel, is the lower bound of the wave number.
"""
WHOLE = tuple(x for x in COARSE if x >= np.pi)
"""The part of `COARSE` with a whole wave over the travel: harmonics of a longer one are a polynomial of high order."""
FINE = tuple(float(x) for x in np.arange(2.0, 60.1, 0.6))
"""The same for an encoder's lines: from two thirds of a wave over the travel, where an encoder off centre ends."""


def wave(name: str, over: sp.Expr = _q) -> sp.Expr:
    """Write a wave in the parameters of an effect.

    Parameters
    ----------
    name
        Start of the ids ``<name>_sin``, ``<name>_cos`` (amplitudes) and ``<name>_number`` (wave number n [1/rad]).
    over
        Position x; the joint's q by default.

    Returns
    -------
    sympy.Expr
        ``<name>_sin``·sin(n·x) + ``<name>_cos``·cos(n·x).
    """
    s, c, n = sp.symbols(f"{name}_sin {name}_cos {name}_number", real=True)
    return s * sp.sin(n * over) + c * sp.cos(n * over)


def series(name: str, harmonics: int) -> sp.Expr:
    """Write a series of harmonics in the parameters of an effect.

    Parameters
    ----------
    name
        Start of the ids ``<name>_sin_<h>``, ``<name>_cos_<h>`` (amplitudes) and ``<name>_number`` (fundamental n).
    harmonics
        Number of harmonics.

    Returns
    -------
    sympy.Expr
        Σ_h ``<name>_sin_<h>``·sin(h·n·q) + ``<name>_cos_<h>``·cos(h·n·q).
    """
    n = sp.Symbol(f"{name}_number", real=True)
    terms = []
    for h in range(1, harmonics + 1):
        s, c = sp.symbols(f"{name}_sin_{h} {name}_cos_{h}", real=True)
        terms.append(s * sp.sin(h * n * _q) + c * sp.cos(h * n * _q))
    return sp.Add(*terms)


def series_amplitudes(
    name: str, unit: str, words: str, size: float, largest: float, harmonics: int
) -> tuple[Quantity, ...]:
    """Make the amplitudes of a series.

    Parameters
    ----------
    name
        Start of the ids, as for `series`.
    unit
        Unit of the amplitudes.
    words
        What makes waves, for the descriptions.
    size, largest
        Typical size of an amplitude, and its bound on either side.
    harmonics
        Number of harmonics.

    Returns
    -------
    tuple of Quantity
        Sine and cosine part of the first harmonic, then those of the second, and so on.
    """
    return tuple(
        parameter(f"{name}_{part}_{h}", unit, f"{words}, {word} part of harmonic {h}", size, -largest, largest)
        for h in range(1, harmonics + 1)
        for part, word in (("sin", "sine"), ("cos", "cosine"))
    )


def wave_number(id: str, grid: tuple[float, ...]) -> Quantity:
    """Make the parameter of the wave number n.

    Parameters
    ----------
    id
        Id of the parameter.
    grid
        Ascending grid of wave numbers, in units of one over half the span of positions.

    Returns
    -------
    Quantity
        Wave number with bounds that contain the grid, on a logarithmic scale.
    """
    return parameter(id, "1/rad", "wave number", grid[len(grid) // 3], grid[0], 1.2 * grid[-1], scale="log")


def size(name: str, unit: str) -> tuple[tuple[str, str, sp.Expr], ...]:
    """Return the amplitude √(a_s² + a_c²) of a wave, as ``Effect.derived`` takes it.

    Parameters
    ----------
    name
        Start of the ids of the wave's amplitudes.
    unit
        Unit of the amplitude.

    Returns
    -------
    tuple of (str, str, sympy.Expr)
        One entry (id, unit, formula).
    """
    s, c = sp.symbols(f"{name}_sin {name}_cos", real=True)
    return ((f"{name}_amplitude", unit, sp.sqrt(s**2 + c**2)),)
