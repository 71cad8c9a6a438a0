"""Dry friction that settles while the joint warms up: stiction and Coulomb friction, or Coulomb friction alone."""

from haptid.model.effects.effect import Effect, parameter
from haptid.model.effects.parts.warming import settling, warming
from haptid.model.effects.scales import DURATION

_parameters = (
    parameter("coulomb_excess", "1", "relative excess of dry friction at the start", 0.02, -0.9, 5.0),
    parameter("coulomb_warm_up", "s", "time constant of the drift", 0.4, 0.02, 10.0, scale="log"),
)
_relative = {"coulomb_warm_up": DURATION}
_level = settling(_parameters)

_BOTH = Effect(
    id="coulomb_drift",
    title="dry friction that settles during a run",
    formula="Fc, Fs times (1 + a·exp(−t/T))",
    lives_in="time",
    side="friction",
    parameters=_parameters,
    relative=_relative,
    shapes=(("coulomb_warm_up", (0.08, 0.2, 0.5, 1.5)),),
    rivals=("viscous_drift", "gain_drift"),
    contenders=(warming(_parameters, _relative),),
    coulomb_level=_level,
)

EFFECTS = (
    _BOTH,
    _BOTH.but(
        variant="kinetic",
        title="dry friction of a moving joint that settles during a run",
        formula="Fc times (1 + a·exp(−t/T))",
        coulomb_level=None,
        kinetic_level=_level,
    ),
)
