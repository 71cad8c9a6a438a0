"""Two equal lags in series, as late as one lag or a delay of the same time: the contender of lags and delays.

A lag 1/(1 + sT) and a delay e^(−sT) differ first in the second power of sT; the response 1/(1 + sT/2)² lies half way
between them there. The effect is not in the catalogue: it stands for every other element that is late, where the
catalogue holds one kind only.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, fade_in, parameter, w
from haptid.model.equations.equations import State


def cascade(least: sp.Expr, extra: sp.Expr = sp.S.Zero) -> Effect:
    """Make the cascade of two lags as an effect.

    Parameters
    ----------
    least
        Time [s] below which the effect fades linearly to none.
    extra
        Additional rate [1/s] of both lags, as one that is large at the start of a run.

    Returns
    -------
    Effect
        The effect with the time T [s] of both lags together.
    """
    T, first, second = sp.symbols("cascade_time cascade_first cascade_second", real=True)
    rate = 2 / sp.Max(T, least) + extra
    return Effect(
        id="lag_cascade",
        title="torque that arrives late by two lags in a row",
        formula="(T/2)·ẇ₁ = τ − w₁, (T/2)·ẇ = w₁ − w",
        lives_in="frequency",
        place=5,
        side="input",
        parameters=(parameter("cascade_time", "s", "time T of both lags together", 0.005, 0.0, 1.0),),
        input=fade_in(T, least, second, w),
        states=tuple(
            EffectState(state=State(id=x.name, unit="N m", description=name), rhs=(before - x) * rate, rate=rate)
            for x, before, name in ((first, w, "torque behind the first lag"), (second, first, "torque behind both"))
        ),
    )
