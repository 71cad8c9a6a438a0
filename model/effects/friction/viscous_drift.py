"""Viscous friction that settles while the joint warms up."""

from haptid.model.effects.effect import Effect, parameter
from haptid.model.effects.parts.warming import settling, warming
from haptid.model.effects.scales import DURATION

_parameters = (
    parameter("viscous_excess", "1", "relative excess of viscous friction at the start", 0.02, -0.9, 5.0),
    parameter("viscous_warm_up", "s", "time constant of the drift", 0.4, 0.02, 10.0, scale="log"),
)
_relative = {"viscous_warm_up": DURATION}

EFFECT = Effect(
    id="viscous_drift",
    title="viscous friction that settles during a run",
    formula="σ2 times (1 + a·exp(−t/T))",
    lives_in="time",
    side="friction",
    parameters=_parameters,
    relative=_relative,
    shapes=(("viscous_warm_up", (0.08, 0.2, 0.5, 1.5)),),
    rivals=("coulomb_drift", "gain_drift"),
    contenders=(warming(_parameters, _relative),),
    viscous_level=settling(_parameters),
)
