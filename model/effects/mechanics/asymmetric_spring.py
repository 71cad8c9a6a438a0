"""A spring that is stiffer on one side of its centre."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.bend import OF_QUADRATIC
from haptid.model.effects.scales import POSITION, TORQUE

k2, epos = sp.symbols("k2 epos", real=True)

EFFECT = Effect(
    id="asymmetric_spring",
    title="spring that is stiffer on one side",
    formula="−k2·(q − epos)²",
    lives_in="position",
    side="torque",
    parameters=(parameter("k2", "N m/rad^2", "quadratic stiffness", 0.02, -5.0, 5.0),),
    relative={"k2": TORQUE / POSITION**2},
    rivals=("encoder_eccentricity", "end_stop"),
    contenders=(OF_QUADRATIC,),
    torque=-k2 * (q - epos) ** 2,
)
