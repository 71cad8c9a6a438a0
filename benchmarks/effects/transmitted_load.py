"""Dry friction that grows with the motor's torque and with the load that the transmission bears.

The load is the gravity torque of the model. It differs from the motor's torque wherever the joint accelerates, brakes
or is held by friction, so that the two have a factor each. For a joint with both gravity parameters.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q, reference, w
from haptid.model.effects.scales import TORQUE

motor, borne, w0 = sp.symbols("motor_load_friction borne_load_friction load_reference", real=True)
load = sp.Symbol("gravity_cos", real=True) * sp.cos(q) + sp.Symbol("gravity_sin", real=True) * sp.sin(q)

EFFECT = Effect(
    id="transmitted_load_friction",
    title="dry friction that grows with the motor's torque and the borne load",
    formula="Fc, Fs times (1 + (a·|w| + b·|g_c·cos q + g_s·sin q|)/w₀)",
    lives_in="torque",
    side="friction",
    parameters=(
        parameter("motor_load_friction", "1", "relative growth of dry friction at the torque w₀", 10.0, 0.0, 500.0),
        parameter("borne_load_friction", "1", "relative growth of dry friction at the load w₀", 10.0, 0.0, 500.0),
        reference("load_reference", "N m", "largest torque w₀"),
    ),
    relative={"load_reference": TORQUE},
    rivals=("load_dependent_friction",),
    coulomb_level=1 + (motor * sp.Abs(w) + borne * sp.Abs(load)) / w0,
)
