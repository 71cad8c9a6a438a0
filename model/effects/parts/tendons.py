"""Rotor and link joined by a spring with play: shared by the entries for tendons and backlash.

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
"""Share of the play over which the damper engages: a fit needs a slope to begin with, the device has a jump."""


def _names(prefix: str) -> tuple[sp.Symbol, ...]:
    ids = ("compliance", "rotor_share", "damping_time", "compliance_least", "stretch", "rotor_speed")
    return tuple(sp.Symbol(f"{prefix}_{id}", real=True) for id in ids)


def table(prefix: str, compliance: tuple[float, float, float]) -> tuple[Quantity, ...]:
    """Table rows: compliance first (initial, lower, upper as multiples of position over torque)."""
    return (
        parameter(f"{prefix}_compliance", "rad/(N m)", "compliance 1/k between rotor and link", *compliance),
        parameter(f"{prefix}_rotor_share", "1", "share of the inertia on the rotor's side", 0.3, 0.02, 0.9),
        parameter(f"{prefix}_damping_time", "s", "damping over stiffness", 5e-3, 1e-5, 0.3, scale="log"),
        reference(f"{prefix}_compliance_least", "rad/(N m)", "compliance below which the effect fades linearly"),
    )


def contact(prefix: str) -> Quantity:
    """Table row of the share of the play over which the damper engages: an `model.effects.effect.Effect.edge`."""
    row = reference(f"{prefix}_contact", "1", "share of the play over which the damper engages")
    return row.but(initial=CONTACTS[0])


def relative(prefix: str) -> dict[str, sp.Expr]:
    """Scales of the table's rows."""
    return {
        f"{prefix}_compliance": POSITION / TORQUE,
        f"{prefix}_compliance_least": sp.Float(1e-3) * POSITION / TORQUE,
    }


def derived(prefix: str) -> tuple[tuple[str, str, sp.Expr], ...]:
    """Stiffness, for readers."""
    return ((f"{prefix}_stiffness", "N m/rad", 1 / _names(prefix)[0]),)


def two_masses(prefix: str, play: sp.Expr | None = None) -> tuple[sp.Expr, tuple[EffectState, ...]]:
    """Return the link's acceleration and the two states; without ``play``, the effect fades out at compliance 0."""
    compliance, rho, damping, least, s, vm = _names(prefix)
    M = sp.Symbol("inertia", real=True)
    held = sp.Max(compliance, least)
    d, engaged = s, sp.S.One
    if play is not None:
        d = sp.Max(s - play, 0) + sp.Min(s + play, 0)
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
