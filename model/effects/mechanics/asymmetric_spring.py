"""A spring that is stiffer on one side of its centre: more and more with its stretch, or beyond a rounded knee."""

from functools import partial

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.bend import OF_QUADRATIC
from haptid.model.effects.scales import POSITION, TORQUE

k2, k, width, epos = sp.symbols("k2 knee_stiffness knee_width epos", real=True)
_stretch = sp.Abs(q - epos) / width
_effect = partial(
    Effect,
    id="asymmetric_spring",
    title="spring that is stiffer on one side",
    lives_in="position",
    side="torque",
    rivals=("encoder_eccentricity", "end_stop"),
)

EFFECTS = (
    _effect(
        formula="−k2·(q − epos)²",
        parameters=(parameter("k2", "N m/rad^2", "quadratic stiffness", 0.02, -5.0, 5.0),),
        relative={"k2": TORQUE / POSITION**2},
        contenders=(OF_QUADRATIC,),
        torque=-k2 * (q - epos) ** 2,
    ),
    _effect(
        variant="knee",
        formula="−k·w·ln cosh((q − epos)/w)",
        parameters=(
            parameter("knee_stiffness", "N m/rad", "half the difference of stiffness between the sides k", 0.05, -5, 5),
            parameter("knee_width", "rad", "width of the knee w", 0.2, 0.02, 1.0),
        ),
        relative={"knee_stiffness": TORQUE / POSITION, "knee_width": POSITION},
        shapes=(("knee_width", (0.05, 0.2, 0.6)),),
        # ln cosh u = |u| + ln(1 + e^(−2|u|)) − ln 2, without overflow
        torque=-k * width * (_stretch + sp.log(1 + sp.exp(-2 * _stretch)) - sp.log(2)),
    ),
)
