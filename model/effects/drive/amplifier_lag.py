"""An amplifier that follows its command with a lag, from rest or settled on the first command."""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, fade_in, parameter, t, w
from haptid.model.effects.parts.cascade import cascade
from haptid.model.equations.equations import State
from haptid.model.thresholds import THRESHOLDS

RATE = THRESHOLDS.settling_rate_per_s
LEAST = sp.Float(1e-4)


def _lag(variant: str, prefix: str, extra: sp.Expr) -> Effect:
    T, reached = sp.symbols(f"{prefix}_time {prefix}_torque", real=True)
    rate = 1 / sp.Max(T, LEAST) + extra
    return Effect(
        id="amplifier_lag",
        variant=variant,
        title="amplifier that lags behind its command",
        formula="T·ẇ = τ − w, w(0) = " + ("0" if variant == "rest" else "τ(0)"),
        lives_in="frequency",
        place=5,
        side="input",
        parameters=(parameter(f"{prefix}_time", "s", "time constant T", 0.005, 0.0, 1.0),),
        shapes=((f"{prefix}_time", (0.002, 0.01, 0.04, 0.15)),),
        rivals=("time_delay", "friction_lag"),
        contenders=(cascade(LEAST, extra),),
        input=fade_in(T, LEAST, reached, w),
        states=(
            EffectState(
                state=State(id=f"{prefix}_torque", unit="N m", description="torque that the amplifier has reached"),
                rhs=(w - reached) * rate,
                rate=rate,
            ),
        ),
    )


EFFECTS = (
    _lag("rest", "lag", sp.S.Zero),
    _lag("settled", "settled_lag", RATE * sp.exp(-t * RATE / 5)),
)
