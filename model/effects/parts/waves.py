"""Waves over position, a_s·sin(n·q) + a_c·cos(n·q), which the effects periodic in position share."""

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
