"""Positions stamped by a clock that runs too fast or too slow, against the torque's clock.

In the positions' time t the whole machine runs at the rate 1 + ε, and is driven by τ((1 + ε)·t) = e^(δs)·τ with
δ = ε·t. With g = 1 − 1/(1 + sT), one lag, s = g/((1 − g)·T); and with a = δ/T the generating function of the Laguerre
polynomials gives e^(δs) = e^(a·g/(1 − g)) = 1 + Σₖ gᵏ·Σⱼ C(k − 1, j − 1)·aʲ/j!, taken to the power `ORDER` of g by as
many lags in a row, which see the torque in the positions' time. All other effects live by the machine's time
(1 + ε)·t.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, parameter, t, w
from haptid.model.equations.equations import State

LAG = sp.Rational(1, 25)
"""Time constant T of the lags that see the torque's rate of change [s]; a shorter one shows a held torque's steps."""
ORDER = 5
"""Number of lags in a row; the truncation error is of the order (δω)⁶/720 and (ωT)⁵ at the frequency ω."""


def _clock() -> Effect:
    eps = sp.Symbol("clock_rate", real=True)
    a, rate = eps * t / LAG, 1 / LAG / (1 + eps)
    advanced, seen = w, w
    states = []
    for k in range(1, ORDER + 1):
        lag = sp.Symbol(f"clock_lag_{k}", real=True)
        description = f"torque behind {k} lag{'s' * (k > 1)} in a row"
        states.append(
            EffectState(
                state=State(id=lag.name, unit="N m", description=description), rhs=rate * (seen - lag), rate=rate
            )
        )
        seen = seen - lag
        advanced += seen * sum(sp.binomial(k - 1, j - 1) * a**j / sp.factorial(j) for j in range(1, k + 1))
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
        states=tuple(states),
    )


EFFECT = _clock()
