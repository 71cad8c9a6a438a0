"""Generalised Maxwell-slip friction (Lampaert, Al-Bender, Swevers 2003; Al-Bender, Lampaert, Swevers 2005, eqs. 8-10).

N springs in parallel, each dragged by the joint, each either sticking or slipping:

    F = Σ Fᵢ + σ2·v,   sticks: Ḟᵢ = kᵢ·v until |Fᵢ| = αᵢ·s(v),   slips: Ḟᵢ = sgn(v)·C·(αᵢ − |Fᵢ|/s(v)) until v turns,

with the Stribeck curve s(v) = Fc + (Fs − Fc)·exp(−(v/vs)²). In presliding it has the memory of every reversal
(nonlocal hysteresis), in sliding its torque follows s(v) within s/C. The springs get two shape numbers: from one to the
next kᵢ falls by the factor ``spread``, with Σ kᵢ = σ0, and the share αᵢ of the limit by the factor ``unevenness``, with
Σ αᵢ = 1. Below 1 the softer springs have the greater limits.

The transition from stick to slip is continuous, so that sensitivities contain it. With rᵢ = Fᵢ·sgn(v)/(αᵢ·s(v)), the
share that slips is βᵢ = clip((rᵢ − 1 + ε)/ε, 0, 1), or while Fᵢ·v > 0 the memory mᵢ of having slipped:

    Ḟᵢ = (1 − gᵢ)·kᵢ·v + gᵢ·C·(αᵢ·sgn(v) − Fᵢ/s(v)),   gᵢ = βᵢ + (1 − βᵢ)·mᵢ·[Fᵢ·v > 0],
    ṁᵢ = R·(βᵢ·(1 − mᵢ) − [Fᵢ·v < 0]·mᵢ).

For given v all are linear in Fᵢ where βᵢ stands still. The relaxation rate takes the steepest slope that βᵢ can have,
so that no stiffness makes a step unstable.

With Fs > Fc the law is not passive, whatever σ2: an element that slipped fast and creeps on gains force from αᵢ·Fc to
αᵢ·Fs at no displacement, and gives its energy back when it is unloaded.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.equations.equations import State
from haptid.model.equations.joint_parameters import Row
from haptid.model.friction.law import SLOTS, Friction, FrictionLaw, Levels, Roles, Sliding, Symbols, Values
from haptid.model.friction.shared import (
    COULOMB,
    STICTION,
    STIFFNESS,
    STRIBECK_VELOCITY,
    VISCOUS,
    guess_stribeck,
    stribeck,
)
from haptid.model.thresholds import THRESHOLDS

ELEMENTS = 6
"""N. Four are the fewest with which the literature identifies presliding hysteresis; each costs two states."""
EDGE = sp.Float(0.02)
"""ε: share of its limit over which an element goes from stick to slip."""
MEMORY = sp.Float(1000.0)
"""R [1/s]: how fast an element remembers that it slips, and forgets it once the joint has turned."""
SPREAD = Row(
    id="spread",
    unit="1",
    prismatic_unit="1",
    description="ratio of the stiffnesses of neighbouring elements",
    initial=2.0,
    lower=1.0,
    upper=10.0,
    structured="friction.spread",
)
ATTRACTION = Row(
    id="C",
    unit="N m/s",
    prismatic_unit="N/s",
    description="attraction of a slipping element to the Stribeck curve",
    initial=5e-2,
    lower=1e-6,
    upper=1e6,
    structured="friction.C",
)
UNEVENNESS = Row(
    id="unevenness",
    unit="1",
    prismatic_unit="1",
    description="ratio of the limits of neighbouring elements, the stiffer over the softer",
    initial=1.0,
    lower=0.1,
    upper=10.0,
    structured="friction.unevenness",
)
FORCES = tuple(
    State(id=f"element{i}", unit="N m", description=f"friction of element {i}", nominal=1e-3,
          structured=f"friction.element{i}")
    for i in range(1, ELEMENTS + 1)
)  # fmt: skip
SLIPS = tuple(
    State(id=f"slip{i}", unit="1", description=f"slip of element {i}", structured=f"friction.slip{i}")
    for i in range(1, ELEMENTS + 1)
)


def falling_shares(ratio: sp.Expr) -> list[sp.Expr]:
    """Write the shares of the elements in a sum that falls geometrically.

    Parameters
    ----------
    ratio
        Ratio of each share to the next [1].

    Returns
    -------
    list of sympy.Expr
        ratio^(N−i)/Σⱼ ratio^(N−j) for i = 1 … N, the stiffest element first.
    """
    powers = [ratio ** (ELEMENTS - 1 - i) for i in range(ELEMENTS)]
    return [power / sp.Add(*powers) for power in powers]


def maxwell_slip(v: sp.Expr, p: Symbols, levels: Levels) -> Friction:
    """Write generalised Maxwell-slip friction.

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
        Torque Σ Fᵢ + σ2·v; states are the N forces Fᵢ [N m], then the N memories mᵢ.
    """
    s, way, one = stribeck(v, p, levels), sp.sign(v), sp.S.One
    elements = zip(falling_shares(p["spread"]), falling_shares(p["unevenness"]), FORCES, SLIPS, strict=True)
    rhs, rates, remembered, recalls = [], [], [], []
    for stiff, strong, force, slip in elements:
        F, m, stiffness, limit = force.symbol, slip.symbol, p["sigma0"] * stiff, strong * s
        beyond = (F * way / limit - (1 - EDGE)) / EDGE
        share = sp.Min(sp.Max(beyond, sp.S.Zero), one)
        before, turned = m * sp.Heaviside(F * v), sp.Heaviside(-F * v)
        slips = share + (1 - share) * before
        rhs.append((1 - slips) * stiffness * v + slips * p["C"] * (strong * way - F / s))
        # the slope of βᵢ over Fᵢ is at most 1/(ε·limit), reached within the transition from stick to slip
        rates.append(p["C"] / s + (1 - before) * stiffness * sp.Abs(v) / (EDGE * limit))
        remembered.append(MEMORY * (share * (1 - m) - turned * m))
        recalls.append(MEMORY * (share + turned))
    total = sp.Add(*(force.symbol for force in FORCES)) + p["sigma2"] * levels.viscous * v
    return Friction(force=total, rhs=(*rhs, *remembered), rates=(*rates, *recalls))


def _guess(s: Sliding) -> dict[str, float]:
    shape = {"spread": SPREAD.initial, "unevenness": UNEVENNESS.initial}
    return guess_stribeck(s) | shape | {"C": THRESHOLDS.following_rate_per_s * s.coulomb}


def _nominal(p: Values) -> tuple[float, ...]:
    return (p["Fc"] / ELEMENTS,) * ELEMENTS + (1e-3,) * ELEMENTS


def _presliding_length(p: Values) -> float:
    """Return where the last element begins to slip: the greatest αᵢ·Fs/kᵢ."""
    stiff, strong = (falling_shares(sp.Float(p[id])) for id in ("spread", "unevenness"))
    softest = max(float(limit / stiffness) for limit, stiffness in zip(strong, stiff, strict=True))
    return p["Fs"] / p["sigma0"] * softest


LAW = FrictionLaw(
    id="maxwell_slip",
    title="Generalised Maxwell-slip",
    formulas=(
        "Σ Fᵢ + σ2·v",
        "Ḟᵢ = kᵢ·v while it sticks,  Ḟᵢ = sgn(v)·C·(αᵢ − |Fᵢ|/s(v)) while it slips",
        "kᵢ = σ0·spread^(N−i)/Σ spread^(N−j),  αᵢ = unevenness^(N−i)/Σ unevenness^(N−j)",
        f"s(v) = Fc + (Fs − Fc)·exp(−(v/vs)²),  N = {ELEMENTS}",
    ),
    parameters=(STIFFNESS, SPREAD, UNEVENNESS, ATTRACTION, VISCOUS, STRIBECK_VELOCITY, STICTION, COULOMB),
    states=(*FORCES, *SLIPS),
    write=maxwell_slip,
    damping=lambda _, p: p["sigma2"],
    roles=Roles(stiffness="sigma0", coulomb="Fc", stiction="Fs", viscous="sigma2", stribeck_velocity="vs"),
    slots=frozenset(SLOTS),
    guess=_guess,
    nominal=_nominal,
    presliding_length=_presliding_length,
    without_presliding=("sigma0", "spread", "unevenness"),
    without_sliding=("Fc", "sigma2", "vs", "C"),
    orderings=(("Fs", "Fc"),),
    level=stribeck,
)
