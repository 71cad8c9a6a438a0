"""A tendon that goes slack around zero stretch."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, reference
from haptid.model.effects.parts import tendons
from haptid.model.effects.scales import POSITION

NAME = "slack"
_acceleration, _states = tendons.two_masses(NAME, play=sp.Symbol("slack_half_width", real=True))

EFFECT = Effect(
    id="tendon_slack",
    title="tendon that goes slack when the torque turns",
    formula="no torque passes while |q_m − q| < b; a tendon of compliance e beyond",
    lives_in="torque",
    side="input",
    parameters=(
        parameter("slack_half_width", "rad", "stretch below which no torque passes", 0.02, 0.0, 1.0),
        *tendons.table(NAME, (0.02, 0.0, 2.0)),
        reference("slack_play_least", "rad", "slack below which the effect fades linearly"),
        tendons.contact(NAME),
    ),
    amplitudes=2,
    relative={
        **tendons.relative(NAME),
        "slack_half_width": POSITION,
        "slack_play_least": sp.Float(1e-4) * POSITION,
    },
    shapes=(
        ("slack_half_width", (0.003, 0.02, 0.08)),
        ("slack_compliance", (0.01, 0.1)),
        ("slack_rotor_share", (0.3,)),
        ("slack_damping_time", (0.005,)),
    ),
    derived=tendons.derive_stiffness(NAME),
    rivals=("backlash", "amplifier_dead_band"),
    acceleration=_acceleration,
    states=_states,
    edge=f"{NAME}_contact",
    edges=tendons.CONTACTS[1:],
)
