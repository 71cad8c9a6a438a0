"""Dahl friction (Dahl 1968, A Solid Friction Model, with exponent 1), and viscous friction beside it.

ż = v − σ0·|v|/Fc·z,  F = σ0·z + σ2·v

The bristle deflection z is scaled so that σ0·z is a torque and |σ0·z| tends to Fc in sliding, whatever the speed:
there is neither stiction nor a Stribeck curve, and no damping of the bristle. The law is passive at all its
parameters: z·ż is never more than z·v.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.friction.law import USE_OF_BRISTLE, Friction, FrictionLaw, Levels, Roles, Symbols, Values
from haptid.model.friction.shared import BRISTLE, COULOMB, STIFFNESS, VISCOUS, guess_presliding


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
        Torque σ0·z + σ2·v, ż, and the relaxation rate σ0·|v|/Fc, which is −∂ż/∂z exactly.
    """
    z = BRISTLE.symbol
    rate = p["sigma0"] * sp.Abs(v) / (levels.friction * levels.coulomb * p["Fc"])
    force = p["sigma0"] * z + p["sigma2"] * levels.viscous * v
    return Friction(force=force, rhs=(v - rate * z,), rates=(rate,))


def _length(p: Values) -> float:
    return p["Fc"] / p["sigma0"]


LAW = FrictionLaw(
    id="dahl",
    title="Dahl",
    formulas=("σ0·z + σ2·v", "ż = v − σ0·|v|/Fc·z"),
    parameters=(STIFFNESS, VISCOUS, COULOMB),
    states=(BRISTLE,),
    write=dahl,
    damping=lambda _, p: p["sigma2"],
    roles=Roles(stiffness="sigma0", coulomb="Fc", stiction="Fc", viscous="sigma2"),
    slots=frozenset({"friction_level", "coulomb_level", "viscous_level", USE_OF_BRISTLE}),
    guess=guess_presliding,
    nominal=lambda p: (_length(p),),
    presliding_length=_length,
    without_presliding=("sigma0",),
    without_sliding=("Fc", "sigma2"),
)
