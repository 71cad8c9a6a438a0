"""Two equal lags, one behind the other: late by as much as one lag or a delay of the same time, and neither of them.

Its response 1/(1 + sT/2)² lies half way between theirs in the second power of sT, where a lag and a delay part. It is
no entry of the catalogue: it stands for every other element that is late, where the catalogue holds one kind only.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, fade_in, parameter, w
from haptid.model.equations.equations import State


def cascade(least: sp.Expr, extra: sp.Expr = sp.S.Zero) -> Effect:
    """Return the cascade, its time T [s] faded in below ``least``; ``extra`` [1/s] takes the first command faster."""
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
