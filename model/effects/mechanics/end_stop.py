"""An elastic stop at one end of the travel, or at both."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q, reference, v
from haptid.model.effects.scales import CENTRE, POSITION, SPEED, TORQUE
from haptid.model.equations.quantity import Quantity
from haptid.model.thresholds import THRESHOLDS

ONSET = f"d₀ = {1e2 * THRESHOLDS.onset_of_stop_damper_over_travel:g} % of half the travel"
"""A damper that begins at its full size would make the torque jump where the stop is touched."""
PLACES = (0.35, 0.55, 0.7, 0.82, 0.92)


def _names(prefix: str) -> tuple[sp.Symbol, ...]:
    ids = ("stiffness", "damping", "position", "travel")
    return tuple(sp.Symbol(f"{prefix}_{id}", real=True) for id in ids)


def _push(prefix: str, sign: int, place: sp.Expr | None = None) -> sp.Expr:
    """Torque of a stop that is touched where sign·(q − place) > 0; its damper engages over the first depth d₀."""
    k, c, at, travel = _names(prefix)
    depth = sp.Max(sign * (q - (at if place is None else place)), 0)
    return -sign * k * depth - c * v * sp.Min(depth / (THRESHOLDS.onset_of_stop_damper_over_travel * travel), 1)


def _table(prefix: str, place: float, low: float, high: float) -> tuple[Quantity, ...]:
    return (
        parameter(f"{prefix}_stiffness", "N m/rad", "stiffness of the stop", 0.2, 0.0, 1000.0),
        parameter(f"{prefix}_damping", "N m s/rad", "damping of the stop", 0.02, 0.0, 20.0),
        parameter(f"{prefix}_position", "rad", "where the stop begins", place, low, high),
        reference(f"{prefix}_travel", "rad", "half of the travel"),
    )


def _scales(prefix: str) -> dict[str, sp.Expr]:
    return {
        f"{prefix}_stiffness": TORQUE / POSITION,
        f"{prefix}_damping": TORQUE / SPEED,
        f"{prefix}_position": POSITION,
        f"{prefix}_travel": POSITION,
    }


def _one_sided(variant: str, sign: int) -> Effect:
    prefix = f"{variant}_stop"
    low, high = (-0.2, 1.0) if sign > 0 else (-1.0, 0.2)
    return Effect(
        id="end_stop",
        variant=variant,
        title=f"elastic stop at the {variant} end of the travel",
        formula=f"−k·d − c·q̇·min(d/d₀, 1) at the depth d beyond q_stop, {ONSET}",
        lives_in="position",
        side="torque",
        parameters=_table(prefix, sign * 0.8, low, high),
        amplitudes=2,
        relative=_scales(prefix),
        origin={f"{prefix}_position": CENTRE},
        shapes=((f"{prefix}_position", tuple(sign * x for x in PLACES)),),
        rivals=("cubic_spring", "asymmetric_spring", "amplifier_saturation"),
        torque=_push(prefix, sign),
    )


def _both() -> Effect:
    lower = sp.Symbol("stops_lower", real=True)
    return Effect(
        id="end_stop",
        variant="both",
        title="elastic stops at both ends of the travel",
        formula=f"−k·d − c·q̇·min(d/d₀, 1) at the depth d beyond either stop, {ONSET}",
        lives_in="position",
        side="torque",
        parameters=(
            *_table("stops", 0.8, -0.2, 1.0),
            parameter("stops_lower", "rad", "where the lower stop begins", -0.8, -1.0, 0.2),
        ),
        amplitudes=2,
        relative={**_scales("stops"), "stops_lower": POSITION},
        origin={"stops_position": CENTRE, "stops_lower": CENTRE},
        shapes=(("stops_position", (0.45, 0.65, 0.85)), ("stops_lower", (-0.85, -0.65, -0.45))),
        rivals=("cubic_spring", "amplifier_saturation"),
        torque=_push("stops", 1) + _push("stops", -1, lower),
    )


EFFECTS = (_one_sided("upper", 1), _one_sided("lower", -1), _both())
