"""A spring that stiffens or softens with the cube of its stretch."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.bend import OF_CUBIC
from haptid.model.effects.scales import POSITION, TORQUE

k3, epos = sp.symbols("k3 epos", real=True)

EFFECT = Effect(
    id="cubic_spring",
    title="spring that stiffens away from its centre",
    formula="−k3·(q − epos)³",
    lives_in="position",
    side="torque",
    parameters=(parameter("k3", "N m/rad^3", "cubic stiffness", 0.02, -5.0, 5.0),),
    relative={"k3": TORQUE / POSITION**3},
    rivals=("amplifier_nonlinear_gain", "end_stop", "amplifier_saturation"),
    contenders=(OF_CUBIC,),
    torque=-k3 * (q - epos) ** 3,
)
