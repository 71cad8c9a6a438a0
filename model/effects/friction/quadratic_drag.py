"""Drag that grows with the square of the speed."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, v
from haptid.model.effects.scales import SPEED, TORQUE

d = sp.Symbol("drag", real=True)

EFFECT = Effect(
    id="quadratic_drag",
    title="drag that grows with the square of the speed",
    formula="−d·q̇·|q̇|",
    lives_in="velocity",
    side="torque",
    parameters=(parameter("drag", "N m s^2/rad^2", "drag", 0.02, 0.0, 5.0),),
    relative={"drag": TORQUE / SPEED**2},
    rivals=("position_dependent_viscous",),
    torque=-d * v * sp.Abs(v),
)
