"""Play between motor and link, or between link and encoder."""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, parameter, reference, v, y
from haptid.model.effects.parts import tendons
from haptid.model.effects.scales import POSITION
from haptid.model.equations.equations import State
from haptid.model.thresholds import THRESHOLDS

NAME = "gear"
_acceleration, _states = tendons.two_masses(NAME, play=sp.Symbol("gear_play", real=True))
b, d = sp.symbols("encoder_play play_position", real=True)
_beyond = sp.Max(d - b / 2, 0) + sp.Min(d + b / 2, 0)

EFFECTS = (
    Effect(
        id="backlash",
        variant="encoder",
        title="play between joint and encoder",
        formula="y = q − d, ḋ = q̇ while |d| < b/2, then d stays at ±b/2",
        lives_in="reversal",
        side="output",
        parameters=(parameter("encoder_play", "rad", "play b", 0.01, 0.0, 1.0),),
        relative={"encoder_play": POSITION},
        shapes=(("encoder_play", (0.0005, 0.003, 0.02, 0.1)),),
        rivals=("cable_hysteresis", "tendon_slack"),
        output=y - sp.Max(sp.Min(d, b / 2), -b / 2),
        states=(
            EffectState(
                state=State(id="play_position", unit="rad", description="position within the play"),
                rhs=v - THRESHOLDS.wall_rate_of_play_per_s * _beyond,
                rate=THRESHOLDS.wall_rate_of_play_per_s * sp.Heaviside(sp.Abs(d) - b / 2),
            ),
        ),
    ),
    Effect(
        id="backlash",
        variant="motor",
        title="play between motor and joint",
        formula="no torque passes while |q_m − q| < b; a stiff contact of compliance e beyond",
        lives_in="reversal",
        side="input",
        parameters=(
            parameter("gear_play", "rad", "half of the play", 0.02, 0.0, 1.0),
            *tendons.table(NAME, (0.004, 0.0, 0.02)),
            reference("gear_play_least", "rad", "play below which the effect fades linearly"),
            tendons.contact(NAME),
        ),
        amplitudes=2,
        relative={**tendons.relative(NAME), "gear_play": POSITION, "gear_play_least": sp.Float(1e-4) * POSITION},
        shapes=(
            ("gear_play", (0.003, 0.02, 0.08)),
            ("gear_compliance", (0.005,)),
            ("gear_rotor_share", (0.3,)),
            ("gear_damping_time", (0.005,)),
        ),
        derived=tendons.derive_stiffness(NAME),
        rivals=("tendon_slack",),
        acceleration=_acceleration,
        states=_states,
        edge=f"{NAME}_contact",
        edges=tendons.CONTACTS[1:],
    ),
)
