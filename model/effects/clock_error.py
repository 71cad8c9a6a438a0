"""Positions stamped by a clock that runs too fast or too slow, against the torque's clock.

In the positions' time the whole machine runs at (1 + ε), and is driven by τ((1 + ε)·t) = e^(δs)·τ with δ = ε·t. With
g = 1 − 1/(1 + sT), three lags in a row, s = (g + g² + g³ + …)/T, and the exponential is taken to the third power of g.
All other effects live by the machine's time (1 + ε)·t.
"""

import sympy as sp

from model.effect import Effect, EffectState, parameter, t, w
from model.equations import State

LAG = sp.Rational(1, 50)
"""Time constant T of the lags that see the torque's rate of change [s]."""


def _clock() -> Effect:
    eps = sp.Symbol("clock_rate", real=True)
    lags = sp.symbols("clock_lag_1 clock_lag_2 clock_lag_3", real=True)
    g1 = w - lags[0]
    g2 = g1 - lags[1]
    g3 = g2 - lags[2]
    ahead = eps * t / LAG
    advanced = w + ahead * (g1 + g2 + g3) + ahead**2 / 2 * (g2 + 2 * g3) + ahead**3 / 6 * g3
    return Effect(
        id="clock_error",
        title="position clock that drifts against the torque clock",
        formula="y(t) = q((1 + ε)·t): the machine at the rate 1 + ε, under τ((1 + ε)·t)",
        lives_in="time",
        place=0,
        side="time",
        parameters=(parameter("clock_rate", "1", "relative clock error ε", 1e-4, -0.02, 0.02),),
        rivals=("time_delay", "amplifier_lag"),
        time_rate=1 + eps,
        input=advanced,
        states=tuple(
            EffectState(
                state=State(id=x.name, unit="N m", description=f"torque as {words} leaves it"),
                rhs=g / LAG,
                rate=1 / LAG,
            )
            for x, g, words in zip(lags, (g1, g2, g3), ("one lag", "the second lag", "the third lag"), strict=True)
        ),
    )


EFFECT = _clock()
