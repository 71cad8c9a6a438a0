"""LuGre friction (Canudas de Wit, Olsson, Åström, Lischinsky 1995, eqs. 1-3).

ż = v − σ0·|v|/g(v)·z,  F = σ0·z + σ1·ż + σ2·v,  g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)

The bristle deflection z is scaled so that σ0·z is a torque and |σ0·z| tends to g(v) in sliding. The law is passive
where σ2 ≥ σ1·(Fs − Fc)/Fc (Barabanov and Ortega 2000).
"""

from __future__ import annotations

import math

import sympy as sp

from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import (
    SLOTS,
    USE_OF_BRISTLE,
    Friction,
    FrictionLaw,
    Levels,
    Roles,
    Sliding,
    Symbols,
    Values,
)
from haptid.model.friction.shared import (
    BRISTLE,
    COULOMB,
    STICTION,
    STIFFNESS,
    STRIBECK_VELOCITY,
    VISCOUS,
    guess_stribeck,
    stribeck,
)

BRISTLE_DAMPING = Row(
    id="sigma1",
    unit="N m s/rad",
    prismatic_unit="N s/m",
    description="bristle damping",
    initial=1e-2,
    lower=1e-7,
    upper=1e4,
    structured="friction.sigma1",
)


def lugre(v: sp.Expr, p: Symbols, levels: Levels) -> Friction:
    """Write LuGre friction.

    Parameters
    ----------
    v
        Speed of the joint [rad/s].
    p
        Parameters by id.
    levels
        Factors and Stribeck speed that effects set.

    Returns
    -------
    Friction
        Torque σ0·z + σ1·ż + σ2·v, ż, and the relaxation rate σ0·|v|/g(v), which is −∂ż/∂z exactly.
    """
    z = BRISTLE.symbol
    rate = p["sigma0"] * sp.Abs(v) / stribeck(v, p, levels)
    bristle = v - rate * z
    force = p["sigma0"] * z + p["sigma1"] * bristle + p["sigma2"] * levels.viscous * v
    return Friction(force=force, rhs=(bristle,), rates=(rate,))


def _guess(s: Sliding) -> dict[str, float]:
    """Guess bristle and Stribeck curve in proportion to friction in gross sliding, with a bristle damping ratio of 1/8.

    σ1 = 2·ζ·√(σ0·M) with ζ = 1/8.
    """
    first = guess_stribeck(s)
    return first | {"sigma1": 0.25 * math.sqrt(first["sigma0"] * s.inertia)}


def _nominal(p: Values) -> tuple[float, ...]:
    return (p["Fc"] / p["sigma0"],)


def _presliding_length(p: Values) -> float:
    return p["Fs"] / p["sigma0"]


def _passivity() -> sp.Expr:
    """Return ln σ2 + ln Fc − ln(σ1·(Fs − Fc) + ε), with ε a thousandth of σ2·Fc, so that Fs = Fc has a logarithm."""
    s1, s2, Fs, Fc = sp.symbols("sigma1 sigma2 Fs Fc", real=True)
    return sp.log(s2 * Fc / (s1 * (Fs - Fc) + sp.Float(1e-3) * s2 * Fc))


LAW = FrictionLaw(
    id="lugre",
    title="LuGre",
    formulas=("σ0·z + σ1·ż + σ2·v", "ż = v − σ0·|v|/g(v)·z,  g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)"),
    parameters=(STIFFNESS, BRISTLE_DAMPING, VISCOUS, STRIBECK_VELOCITY, STICTION, COULOMB),
    states=(BRISTLE,),
    write=lugre,
    damping=lambda _, p: p["sigma1"] + p["sigma2"],
    roles=Roles(stiffness="sigma0", coulomb="Fc", stiction="Fs", viscous="sigma2", stribeck_velocity="vs"),
    slots=frozenset({*SLOTS, USE_OF_BRISTLE}),
    guess=_guess,
    nominal=_nominal,
    presliding_length=_presliding_length,
    without_presliding=("sigma0", "sigma1"),
    without_sliding=("Fc", "sigma2", "vs"),
    orderings=(("Fs", "Fc"),),
    passivity=_passivity(),
    level=stribeck,
)
