"""Gravity of a load that the model does not carry."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.bend import OF_WEIGHT
from haptid.model.effects.scales import TORQUE

g1, g2 = sp.symbols("payload_cos payload_sin", real=True)

EFFECT = Effect(
    id="payload_gravity",
    title="gravity of a load that the model leaves out",
    formula="−g1·cos(q) − g2·sin(q)",
    lives_in="position",
    side="torque",
    parameters=(
        parameter("payload_cos", "N m", "gravity torque at q = 0", 0.02, -5.0, 5.0),
        parameter("payload_sin", "N m", "gravity torque at q = pi/2", 0.02, -5.0, 5.0),
    ),
    amplitudes=2,
    relative={"payload_cos": TORQUE, "payload_sin": TORQUE},
    rivals=("asymmetric_coulomb", "asymmetric_spring", "cubic_spring"),
    contenders=OF_WEIGHT,
    torque=-g1 * sp.cos(q) - g2 * sp.sin(q),
)
