"""LuGre friction (Canudas de Wit, Olsson, Åström, Lischinsky 1995, eqs. 1-3).

ż = v − σ0·|v|/g(v)·z,  F = σ0·z + σ1·ż + σ2·v,  g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)

The bristle deflection z is scaled so that σ0·z is a torque and |σ0·z| tends to g(v) in sliding.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True, slots=True, kw_only=True)
class LuGre:
    """Bristle rate of change, its relaxation rate, and the friction torque, as SymPy expressions."""

    bristle: sp.Expr
    rate: sp.Expr
    force: sp.Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class LuGreParameters:
    """Symbols or expressions for the six parameters."""

    sigma0: sp.Expr
    sigma1: sp.Expr
    sigma2: sp.Expr
    vs: sp.Expr
    Fs: sp.Expr
    Fc: sp.Expr


def lugre(
    v: sp.Expr, z: sp.Expr, p: LuGreParameters, *, level: sp.Expr = sp.S.One, lagged: sp.Expr | None = None
) -> LuGre:
    """Write LuGre friction at joint speed ``v`` and bristle deflection ``z``.

    Parameters
    ----------
    level
        Factor on g(v), hence on both Fc and Fs.
    lagged
        Speed seen by the Stribeck curve, where it differs from ``v``.
    """
    g = level * (p.Fc + (p.Fs - p.Fc) * sp.exp(-(((v if lagged is None else lagged) / p.vs) ** 2)))
    rate = p.sigma0 * sp.Abs(v) / g
    bristle = v - rate * z
    return LuGre(bristle=bristle, rate=rate, force=p.sigma0 * z + p.sigma1 * bristle + p.sigma2 * v)
