"""Positions stamped by a clock that runs too fast or too slow, against the torque's clock."""

import sympy as sp

from model.effect import Effect, a, parameter, t, v, y

eps = sp.Symbol("clock_rate", real=True)
_late = eps * t

EFFECT = Effect(
    id="clock_error",
    title="position clock that drifts against the torque clock",
    formula="y(t) = q((1 + ε)·t) ≈ q + ε·t·q̇ + ½·(ε·t)²·q̈",
    lives_in="time",
    side="time",
    parameters=(parameter("clock_rate", "1", "relative clock error ε", 1e-4, -0.02, 0.02),),
    rivals=("time_delay", "amplifier_lag"),
    output=y + _late * v + _late**2 * a / 2,
)
