"""Rotor and link joined by a spring with play: the common part of the effects of tendons and backlash.

ρ·M·v̇_m = w − T, (1 − ρ)·M·v̇ = T − load, ṡ = v_m − v, T = (d(s) + T_d·ṡ)/e with d(s) = s outside the
play ±b and 0 inside. The rotor turns freely, the link carries friction, spring and sensor.
"""

from __future__ import annotations

import sympy as sp

from haptid.model.effects.effect import EffectState, a, parameter, reference, v, w
from haptid.model.effects.scales import POSITION, TORQUE
from haptid.model.equations.equations import State
from haptid.model.equations.quantity import Quantity

CONTACTS = (0.05, 0.005)
"""Shares of the play over which the damper engages: a fit begins with a finite slope, the device has a step."""


def _names(prefix: str) -> tuple[sp.Symbol, ...]:
    ids = ("compliance", "rotor_share", "damping_time", "compliance_least", "stretch", "rotor_speed")
    return tuple(sp.Symbol(f"{prefix}_{id}", real=True) for id in ids)


def table(prefix: str, compliance: tuple[float, float, float]) -> tuple[Quantity, ...]:
    """Return the parameters of a spring between rotor and link.

    Parameters
    ----------
    prefix
        Start of each id.
    compliance
        Initial value, lower and upper bound of the compliance, as multiples of position over torque.

    Returns
    -------
    tuple of Quantity
        Compliance [rad/(N m)], share of the rotor's inertia, damping time [s], reference for fading.
    """
    return (
        parameter(f"{prefix}_compliance", "rad/(N m)", "compliance 1/k between rotor and link", *compliance),
        parameter(f"{prefix}_rotor_share", "1", "share of the inertia on the rotor's side", 0.3, 0.02, 0.9),
        parameter(f"{prefix}_damping_time", "s", "damping over stiffness", 5e-3, 1e-5, 0.3, scale="log"),
        reference(f"{prefix}_compliance_least", "rad/(N m)", "compliance below which the effect fades linearly"),
    )


def contact(prefix: str) -> Quantity:
    """Return the share of the play over which the damper engages, the ``edge`` of an `model.effects.effect.Effect`.

    Parameters
    ----------
    prefix
        Start of the id.

    Returns
    -------
    Quantity
        Parameter ``<prefix>_contact``, the first of `CONTACTS` at first.
    """
    row = reference(f"{prefix}_contact", "1", "share of the play over which the damper engages")
    return row.but(initial=CONTACTS[0])


def relative(prefix: str) -> dict[str, sp.Expr]:
    """Return the scales of the parameters of `table`, by id, as ``Effect.relative`` takes them.

    Parameters
    ----------
    prefix
        Start of each id.

    Returns
    -------
    dict of str to sympy.Expr
        Scale of the compliance, position over torque [rad/(N m)], and of its reference for fading.
    """
    return {
        f"{prefix}_compliance": POSITION / TORQUE,
        f"{prefix}_compliance_least": sp.Float(1e-3) * POSITION / TORQUE,
    }


def derive_stiffness(prefix: str) -> tuple[tuple[str, str, sp.Expr], ...]:
    """Return the stiffness 1/compliance [N m/rad], as ``Effect.derived`` takes it.

    Parameters
    ----------
    prefix
        Start of the id.

    Returns
    -------
    tuple of (str, str, sympy.Expr)
        One effect: id, unit and formula.
    """
    return ((f"{prefix}_stiffness", "N m/rad", 1 / _names(prefix)[0]),)


def two_masses(prefix: str, play: sp.Expr | None = None) -> tuple[sp.Expr, tuple[EffectState, ...]]:
    """Write the motion of rotor and link joined by a spring.

    Parameters
    ----------
    prefix
        Start of each id.
    play
        Half of the play [rad], which the spring has to cross before it transmits torque; None for no play.

    Returns
    -------
    acceleration : sympy.Expr
        Acceleration of the link in the standard symbols, faded in linearly by compliance (and play) from the rigid
        joint.
    states : tuple of EffectState
        Angle of the rotor ahead of the link [rad], and speed of the rotor [rad/s].
    """
    compliance, rho, damping, least, s, vm = _names(prefix)
    M = sp.Symbol("inertia", real=True)
    held = sp.Max(compliance, least)
    d, engaged = s, sp.S.One
    if play is not None:
        d = sp.Max(s - play, 0) + sp.Min(s + play, 0)
        # the damper engages over a share of the play: a step would leave the sensitivities without the contact's slope
        engaged = sp.Min(sp.Abs(d) / (sp.Symbol(f"{prefix}_contact", real=True) * play + sp.Float(1e-9)), 1)
    transmitted = (d + damping * (vm - v) * engaged) / held
    link = (a + (transmitted - w) / M) / (1 - rho)
    present = compliance / least
    if play is not None:
        present = present + play / sp.Symbol(f"{prefix}_play_least", real=True)
    share = sp.Min(present, 1)
    acceleration = a + share * (link - a)
    states = (
        EffectState(state=State(id=s.name, unit="rad", description="rotor ahead of link"), rhs=vm - v),
        EffectState(
            state=State(id=vm.name, unit="rad/s", description="speed of the rotor"),
            rhs=(w - transmitted) / (rho * M),
            rate=damping * engaged / (held * rho * M),
        ),
    )
    return acceleration, states
