"""A torque offset that grows through a run."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, t, w
from haptid.model.effects.scales import DURATION, TORQUE

r = sp.Symbol("bias_drift_rate", real=True)

EFFECT = Effect(
    id="torque_bias_drift",
    title="torque offset that drifts during a run",
    formula="w = τ + r·t",
    lives_in="time",
    place=1,
    side="input",
    parameters=(parameter("bias_drift_rate", "N m/s", "drift of the torque offset", 0.02, -2.0, 2.0),),
    relative={"bias_drift_rate": TORQUE / DURATION},
    rivals=("gain_drift",),
    input=w + r * t,
)
