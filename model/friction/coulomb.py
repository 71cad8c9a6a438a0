"""Coulomb friction with a Stribeck curve, its jump at rest smoothed: friction that is a function of speed alone.

F = s(v)·tanh(v/vc) + σ2·v,  s(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)

The law has no state: the joint never sticks but creeps, at a speed of about vc·F/Fs. It suits lubricated contacts, data
that never show presliding, and machines that were simulated with a smoothed sign. It is passive at all its parameters.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import SLOTS, Friction, FrictionLaw, Levels, Roles, Sliding, Symbols
from haptid.model.friction.shared import COULOMB, STICTION, STRIBECK_VELOCITY, VISCOUS, guess_stribeck, stribeck

REVERSAL = Row(
    id="vc",
    unit="rad/s",
    prismatic_unit="m/s",
    description="speed over which dry friction turns its sign",
    initial=1e-2,
    lower=1e-5,
    upper=1e1,
    structured="friction.vc",
)


def coulomb(v: sp.Expr, p: Symbols, levels: Levels) -> Friction:
    """Write smoothed Coulomb friction.

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
        Torque s(v)·tanh(v/vc) + σ2·v; no states.
    """
    force = stribeck(v, p, levels) * sp.tanh(v / p["vc"]) + p["sigma2"] * levels.viscous * v
    return Friction(force=force, rhs=(), rates=())


def _damping(v: sp.Expr, p: Symbols) -> sp.Expr:
    """Write σ2 + s(v)/vc·(1 − tanh²(v/vc)): the slope of the torque without that of the Stribeck curve, which falls."""
    return p["sigma2"] + stribeck(v, p) / p["vc"] * (1 - sp.tanh(v / p["vc"]) ** 2)


def _guess(s: Sliding) -> dict[str, float]:
    """Guess Coulomb friction and Stribeck curve as every law does, and a reversal within a hundredth of the speed."""
    first = guess_stribeck(s)
    return {id: first[id] for id in ("sigma2", "vs", "Fs", "Fc")} | {"vc": 0.01 * s.speed}


LAW = FrictionLaw(
    id="coulomb",
    title="Smoothed Coulomb",
    formulas=("s(v)·tanh(v/vc) + σ2·v", "s(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)"),
    parameters=(REVERSAL, VISCOUS, STRIBECK_VELOCITY, STICTION, COULOMB),
    states=(),
    write=coulomb,
    damping=_damping,
    roles=Roles(stiffness="", coulomb="Fc", stiction="Fs", viscous="sigma2", stribeck_velocity="vs"),
    slots=frozenset(SLOTS),
    guess=_guess,
    nominal=lambda _: (),
    presliding_length=lambda _: 0.0,
    without_presliding=("vc",),
    without_sliding=("Fc", "sigma2", "vs"),
    orderings=(("Fs", "Fc"),),
    level=stribeck,
)
