"""An amplifier without torque below a threshold: at once, continuous from zero, or more and more about it."""

from functools import partial

import sympy as sp

from haptid.model.effects.effect import Effect, fade_in, parameter, reference, w
from haptid.model.effects.scales import TORQUE

d, least, e, edge = sp.symbols("dead_band dead_band_least dead_zone dead_band_edge", real=True)
soft, soft_least, n = sp.symbols("dead_torque dead_torque_least dead_steepness", real=True)
SMALLEST = sp.Float(1e-6)
"""Torque over the threshold at which its logarithm is cut off."""
EDGES = (0.3, 0.1, 0.03, 0.01, 0.002, 5e-4, 1e-4)
"""Widths of the rounded discontinuity, as a share of the threshold: a fit begins with a wide one, which has a slope."""
_effect = partial(
    Effect,
    id="amplifier_dead_band",
    title="amplifier that ignores small torques",
    lives_in="torque",
    place=2,
    side="input",
    rivals=("tendon_slack", "asymmetric_coulomb"),
)

EFFECTS = (
    _effect(
        variant="jump",
        formula="w = 0 for |τ| < d, else τ",
        parameters=(
            parameter("dead_band", "N m", "threshold d", 0.03, 0.0, 0.8),
            reference("dead_band_least", "N m", "threshold below which the effect fades linearly"),
            reference("dead_band_edge", "1", "width of the jump over the threshold").but(initial=EDGES[0]),
        ),
        relative={"dead_band": TORQUE, "dead_band_least": sp.Float(5e-3) * TORQUE},
        shapes=(("dead_band", (0.02, 0.06, 0.15, 0.3)),),
        input=fade_in(d, least, w * (1 + sp.tanh((sp.Abs(w) - d) / (edge * d))) / 2, w),
        edge="dead_band_edge",
        edges=EDGES[1:],
    ),
    _effect(
        variant="offset",
        formula="w = 0 for |τ| < d, else τ − d·sgn τ",
        parameters=(parameter("dead_zone", "N m", "threshold d", 0.03, 0.0, 0.8),),
        relative={"dead_zone": TORQUE},
        shapes=(("dead_zone", (0.005, 0.03, 0.1, 0.25)),),
        input=sp.Max(w - e, 0) + sp.Min(w + e, 0),
    ),
    _effect(
        variant="gradual",
        formula="w = τ·(1 − exp(−(|τ|/d)ⁿ))",
        parameters=(
            parameter("dead_torque", "N m", "threshold d", 0.03, 0.0, 0.8),
            parameter("dead_steepness", "1", "steepness n about the threshold", 2.0, 1.0, 12.0),
            reference("dead_torque_least", "N m", "threshold below which the effect fades linearly"),
        ),
        relative={"dead_torque": TORQUE, "dead_torque_least": sp.Float(5e-3) * TORQUE},
        shapes=(("dead_torque", (0.02, 0.06, 0.15, 0.3)), ("dead_steepness", (1.5, 4.0))),
        # xⁿ as exp(n·ln x), since a kernel has no other powers
        input=fade_in(soft, soft_least, w * (1 - sp.exp(-sp.exp(n * sp.log(sp.Abs(w) / soft + SMALLEST)))), w),
    ),
)
