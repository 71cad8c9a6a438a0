"""Dahl friction (Dahl 1968, A Solid Friction Model), and viscous friction beside it.

ż = v·sgn(r)·|r|^n,  r = 1 − σ0·z·sgn(v)/Fc,  F = σ0·z + σ2·v

The bristle deflection z is scaled so that σ0·z is a torque and |σ0·z| tends to Fc in sliding, whatever the speed:
there is neither stiction nor a Stribeck curve, and no damping of the bristle. Dahl finds n near 1 for ductile and near
0 for brittle materials; a greater n approaches Fc more slowly. The law is passive at all its parameters: z·ż is never
more than z·v.

|r|^n has an infinite slope at r = 0 where n < 1, so the rate is v·r·(r² + ε²)^((n−1)/2) with ε = 10⁻³: within a
thousandth of Fc it is linear in r.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import USE_OF_BRISTLE, Friction, FrictionLaw, Levels, Roles, Sliding, Symbols, Values
from haptid.model.friction.shared import BRISTLE, COULOMB, STIFFNESS, VISCOUS, guess_presliding

EDGE = sp.Float(1e-3)
"""ε: distance from Fc, as a share of it, within which the rate is linear."""
EXPONENT = Row(
    id="n",
    unit="1",
    prismatic_unit="1",
    description="exponent of the approach to Coulomb friction",
    initial=1.0,
    lower=0.2,
    upper=5.0,
    structured="friction.n",
)


def dahl(v: sp.Expr, p: Symbols, levels: Levels) -> Friction:
    """Write Dahl friction.

    Parameters
    ----------
    v
        Speed of the joint [rad/s].
    p
        Parameters by id.
    levels
        Factors that effects set.

    Returns
    -------
    Friction
        Torque σ0·z + σ2·v, ż, and the relaxation rate max(1, n)·σ0·|v|/Fc·(r² + ε²)^((n−1)/2), which is −∂ż/∂z or more.
    """
    z = BRISTLE.symbol
    limit = levels.friction * levels.coulomb * p["Fc"]
    left = 1 - p["sigma0"] * z * sp.sign(v) / limit
    steepness = sp.exp((p["n"] - 1) / 2 * sp.log(left**2 + EDGE**2))
    rate = sp.Max(1, p["n"]) * p["sigma0"] * sp.Abs(v) / limit * steepness
    force = p["sigma0"] * z + p["sigma2"] * levels.viscous * v
    return Friction(force=force, rhs=(v * left * steepness,), rates=(rate,))


def _guess(s: Sliding) -> dict[str, float]:
    return guess_presliding(s) | {"n": EXPONENT.initial}


def _length(p: Values) -> float:
    return p["Fc"] / p["sigma0"]


LAW = FrictionLaw(
    id="dahl",
    title="Dahl",
    formulas=("σ0·z + σ2·v", "ż = v·sgn(r)·|r|^n,  r = 1 − σ0·z·sgn(v)/Fc"),
    parameters=(STIFFNESS, EXPONENT, VISCOUS, COULOMB),
    states=(BRISTLE,),
    write=dahl,
    damping=lambda _, p: p["sigma2"],
    roles=Roles(stiffness="sigma0", coulomb="Fc", stiction="Fc", viscous="sigma2"),
    slots=frozenset({"friction_level", "coulomb_level", "viscous_level", USE_OF_BRISTLE}),
    guess=_guess,
    nominal=lambda p: (_length(p),),
    presliding_length=_length,
    without_presliding=("sigma0", "n"),
    without_sliding=("Fc", "sigma2"),
)
