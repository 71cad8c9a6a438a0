"""Torque of magnets that hold the rotor in its detents, steeper between them than cogging."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.waves import COARSE, wave_number
from haptid.model.effects.scales import POSITION, TORQUE

A, n, phase, sharpness = sp.symbols("detent_torque detent_number detent_phase detent_sharpness", real=True)

EFFECT = Effect(
    id="magnetic_detent",
    title="magnetic detents at fixed positions",
    formula="−A·tanh(s·sin(n·q + φ))",
    lives_in="position",
    side="torque",
    parameters=(
        parameter("detent_torque", "N m", "detent torque A", 0.01, -1.0, 1.0),
        wave_number("detent_number", COARSE),
        parameter("detent_phase", "rad", "phase φ", 0.0, -3.2, 3.2),
        parameter("detent_sharpness", "1", "sharpness s", 3.0, 1.0, 20.0, scale="log"),
    ),
    relative={"detent_torque": TORQUE, "detent_number": 1 / POSITION},
    shapes=(
        ("detent_number", COARSE),
        ("detent_phase", (-1.05, 0.0, 1.05)),
        ("detent_sharpness", (4.0,)),
    ),
    rivals=("cogging",),
    torque=-A * sp.tanh(sharpness * sp.sin(n * q + phase)),
)
