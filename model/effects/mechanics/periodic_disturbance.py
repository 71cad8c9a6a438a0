"""A torque with a rhythm of its own.

A rhythm repeats: its period is at most two thirds of a run. A slower wave is a drift, whatever its shape.
"""

import numpy as np
import sympy as sp

from haptid.model.effects.effect import Effect, parameter, t
from haptid.model.effects.scales import DURATION, TORQUE

s, c, omega = sp.symbols("disturbance_sin disturbance_cos disturbance_frequency", real=True)
SLOWEST = 3.0 * np.pi
"""Least angular frequency, over that of a radian in a run: one and a half periods."""
LINES = tuple(float(x) for x in np.arange(SLOWEST, 230.0 * np.pi, np.pi))
"""Angular frequencies, half a resolution of the run apart, over that of a radian in a run."""

EFFECT = Effect(
    id="periodic_disturbance",
    title="torque with a rhythm of its own",
    formula="+a_s·sin(ω_d·t) + a_c·cos(ω_d·t)",
    lives_in="time",
    side="torque",
    parameters=(
        parameter("disturbance_sin", "N m", "sine part", 0.01, -2.0, 2.0),
        parameter("disturbance_cos", "N m", "cosine part", 0.01, -2.0, 2.0),
        parameter("disturbance_frequency", "1/s", "angular frequency", 80.0, SLOWEST, 960.0),
    ),
    amplitudes=2,
    relative={"disturbance_sin": TORQUE, "disturbance_cos": TORQUE, "disturbance_frequency": 1 / DURATION},
    shapes=(("disturbance_frequency", LINES),),
    derived=(("disturbance_amplitude", "N m", sp.sqrt(s**2 + c**2)),),
    rivals=("torque_ripple",),
    torque=s * sp.sin(omega * t) + c * sp.cos(omega * t),
)
