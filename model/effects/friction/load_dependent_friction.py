"""Dry friction that grows with the load: with the torque of the motor, or with the torque that the transmission passes.

The motor's torque holds friction itself; what the transmission passes is that torque less friction, the torque that
inertia, gravity and spring take. The two differ wherever friction is large, and where a load drives the motor back. The
second is the load of teeth and bearings, and can be read from a measured motion.

Friction that differs between driving and being driven back, μ_d·|L| and μ_b·|L| of the load L, needs no parameter of
its own: it is ½·(μ_d + μ_b)·|L|·sgn q̇ + ½·(μ_d − μ_b)·L, whose second part adds to inertia, gravity and spring alike.
"""

from functools import partial

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, coulomb, load, parameter, reference, w
from haptid.model.effects.scales import POSITION, SPEED, TORQUE
from haptid.model.equations.equations import State

LAG_OF_TRAVEL_TIME = sp.Float(0.02)
"""Lag of the passed torque over the time in which the joint crosses half of its travel at top speed [1].

Friction that hung on the torque of the same instant would stand on both sides of its own equation.
"""
growth, w0 = sp.symbols("load_friction load_reference", real=True)
passed, friction_of_load, lag = sp.symbols("passed_load friction_of_load passed_load_lag", real=True)
_effect = partial(
    Effect,
    id="load_dependent_friction",
    title="dry friction that grows with the load",
    lives_in="torque",
    side="friction",
    rivals=("position_dependent_friction",),
)

EFFECTS = (
    _effect(
        variant="motor",
        formula="Fc, Fs times (1 + a·|w|/w₀)",
        parameters=(
            parameter("load_friction", "1", "relative growth of dry friction at the largest torque", 0.02, -0.7, 5.0),
            reference("load_reference", "N m", "largest torque w₀"),
        ),
        relative={"load_reference": TORQUE},
        coulomb_level=1 + growth * sp.Abs(w) / w0,
    ),
    _effect(
        variant="transmitted",
        formula="Fc + μ·|L|, Fs alike, with the load L: T·L̇ = w − F − L",
        parameters=(
            # a joint whose friction is more than the load never moves by the load alone
            parameter("friction_of_load", "1", "dry friction μ over the load", 0.01, 0.0, 1.0),
            reference("passed_load_lag", "s", "lag T of the load"),
        ),
        relative={"passed_load_lag": LAG_OF_TRAVEL_TIME * POSITION / SPEED},
        coulomb_level=1 + friction_of_load * sp.Abs(passed) / coulomb,
        states=(
            EffectState(
                state=State(id="passed_load", unit="N m", description="torque that the transmission passes"),
                rhs=(load - passed) / lag,
                rate=1 / lag,
            ),
        ),
    ),
)
