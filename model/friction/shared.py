"""Common parts of several friction laws: rows of their parameter tables, and the Stribeck curve."""

from __future__ import annotations

import sympy as sp

from haptid.model.equations.equations import State
from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import FALL, Levels, Sliding, Symbols
from haptid.model.thresholds import THRESHOLDS

STIFFNESS = Row(
    id="sigma0",
    unit="N m/rad",
    prismatic_unit="N/m",
    description="bristle stiffness",
    initial=1.0,
    lower=1e-4,
    upper=1e7,
    structured="friction.sigma0",
)
VISCOUS = Row(
    id="sigma2",
    unit="N m s/rad",
    prismatic_unit="N s/m",
    description="viscous friction",
    initial=1e-3,
    lower=1e-8,
    upper=1e3,
    structured="friction.sigma2",
)
STRIBECK_VELOCITY = Row(
    id="vs",
    unit="rad/s",
    prismatic_unit="m/s",
    description="Stribeck velocity",
    initial=5e-2,
    lower=1e-4,
    upper=1e1,
    structured="friction.vs",
)
STICTION = Row(
    id="Fs",
    unit="N m",
    prismatic_unit="N",
    description="stiction",
    initial=2e-3,
    lower=1e-7,
    upper=1e3,
    structured="friction.Fs",
)
COULOMB = Row(
    id="Fc",
    unit="N m",
    prismatic_unit="N",
    description="Coulomb friction",
    initial=1.5e-3,
    lower=1e-7,
    upper=1e3,
    structured="friction.Fc",
)
BRISTLE = State(id="z", unit="rad", description="bristle deflection", nominal=1e-3, structured="friction.bristle")


def stribeck(v: sp.Expr, p: Symbols, levels: Levels | None = None) -> sp.Expr:
    """Write the Stribeck curve g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²), or with another argument that an effect sets.

    Parameters
    ----------
    v
        Speed of the joint [rad/s].
    p
        Parameters ``Fc``, ``Fs`` and ``vs`` by id.
    levels
        Factors, speed and exponent that effects set; none where None.

    Returns
    -------
    sympy.Expr
        Level of dry friction [N m].
    """
    a = levels or Levels()
    coulomb, stiction = p["Fc"] * a.coulomb * a.kinetic, p["Fs"] * a.coulomb
    seen = v if a.stribeck_velocity is None else a.stribeck_velocity
    fall = (seen / p["vs"]) ** 2
    if a.stribeck_argument is not None:
        fall = a.stribeck_argument.xreplace({FALL: fall})
    return a.friction * (coulomb + (stiction - coulomb) * sp.exp(-fall))


def guess_presliding(s: Sliding) -> dict[str, float]:
    """Guess what every law with presliding has.

    Parameters
    ----------
    s
        Estimates from the data of a joint.

    Returns
    -------
    dict
        ``sigma0`` = Fc/(`THRESHOLDS.bristle_length_over_travel`·travel), ``sigma2`` and ``Fc`` of gross sliding, by id.
    """
    length = THRESHOLDS.bristle_length_over_travel * s.travel
    return {"sigma0": s.coulomb / length, "sigma2": s.viscous, "Fc": s.coulomb}


def guess_stribeck(s: Sliding) -> dict[str, float]:
    """Guess `guess_presliding` and a Stribeck curve: stiction 20 % above Fc, ``vs`` a tenth of the largest speed.

    Parameters
    ----------
    s
        Estimates from the data of a joint.

    Returns
    -------
    dict
        ``sigma0``, ``sigma2``, ``Fc``, ``vs`` and ``Fs`` by id.
    """
    return guess_presliding(s) | {"vs": 0.1 * s.speed, "Fs": 1.2 * s.coulomb}
