"""Bouc-Wen friction (Bouc 1967, Wen 1976, with exponent 1), and viscous friction beside it.

ż = v − σ0/Fc·(β·|v|·z + (1 − β)·v·|z|),  F = σ0·z + σ2·v

The bristle deflection z is scaled so that σ0·z is a torque and |σ0·z| tends to Fc in sliding. While |z| grows it moves
as in Dahl's law; while it falls, the slope of F over position is σ0·(1 + (2β − 1)·σ0·|z|/Fc). So β = 1 is Dahl's law,
and with β = ½ a reversal begins along a straight line. The law is passive where β ≥ ½, since z·ż ≤ z·v there.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import USE_OF_BRISTLE, Friction, FrictionLaw, Levels, Roles, Sliding, Symbols, Values
from haptid.model.friction.shared import BRISTLE, BRISTLE_SHARE, COULOMB, STIFFNESS, VISCOUS

UNLOADING = Row(
    id="beta",
    unit="1",
    prismatic_unit="1",
    description="share of the bristle's relaxation that does not change its sign when the joint turns",
    initial=0.75,
    lower=0.5,
    upper=1.0,
    structured="friction.beta",
    scale="linear",
)


def bouc_wen(v: sp.Expr, p: Symbols, levels: Levels) -> Friction:
    """Write Bouc-Wen friction.

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
        Torque σ0·z + σ2·v, ż, and the relaxation rate σ0·|v|/Fc, which is −∂ż/∂z while |z| grows and an estimate from
        above while it falls.
    """
    z, beta = BRISTLE.symbol, p["beta"]
    slope = p["sigma0"] / (levels.friction * levels.coulomb * p["Fc"])
    bristle = v - slope * (beta * sp.Abs(v) * z + (1 - beta) * v * sp.Abs(z))
    force = p["sigma0"] * z + p["sigma2"] * levels.viscous * v
    return Friction(force=force, rhs=(bristle,), rates=(slope * sp.Abs(v),))


def _guess(s: Sliding) -> dict[str, float]:
    return {
        "sigma0": s.coulomb / (BRISTLE_SHARE * s.travel),
        "beta": UNLOADING.initial,
        "sigma2": s.viscous,
        "Fc": s.coulomb,
    }


def _length(p: Values) -> float:
    return p["Fc"] / p["sigma0"]


LAW = FrictionLaw(
    id="bouc_wen",
    title="Bouc-Wen",
    formulas=("σ0·z + σ2·v", "ż = v − σ0/Fc·(β·|v|·z + (1 − β)·v·|z|)"),
    parameters=(STIFFNESS, UNLOADING, VISCOUS, COULOMB),
    states=(BRISTLE,),
    write=bouc_wen,
    damping=lambda p: p["sigma2"],
    roles=Roles(stiffness="sigma0", coulomb="Fc", stiction="Fc", viscous="sigma2"),
    slots=frozenset({"friction_level", "coulomb_level", "viscous_level", USE_OF_BRISTLE}),
    guess=_guess,
    nominal=lambda p: (_length(p),),
    presliding_length=_length,
    without_presliding=("sigma0", "beta"),
    without_sliding=("Fc", "sigma2"),
)
