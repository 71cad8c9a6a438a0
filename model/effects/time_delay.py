"""Torque that arrives late: the Padé approximation of e^(−sT) with two zeros and three poles.

e^(−x) ≈ (60 − 24x + 3x²)/(60 + 36x + 9x² + x³) (Baker and Graves-Morris 1996, table of the exponential function), as a
chain of three states that carry torque times the powers 0, 1, 2 of T.
"""

import sympy as sp

from model.effect import Effect, EffectState, faded, parameter, w
from model.equations import State

LEAST = sp.Float(4e-3)


def _delay() -> Effect:
    T = sp.Symbol("delay_time", real=True)
    x1, x2, x3 = sp.symbols("delay_chain_1 delay_chain_2 delay_chain_3", real=True)
    held = sp.Max(T, LEAST)
    # x1''' T³ + 9 x1'' T² + 36 x1' T + 60 x1 = 60 w, output x1 − 0.4 T x1' + 0.05 T² x1''; x2 = T x1', x3 = T² x1''.
    rates = (x2 / held, x3 / held, (60 * (w - x1) - 36 * x2 - 9 * x3) / held)
    names = ("delayed torque", "its first derivative times T", "its second derivative times T²")
    return Effect(
        id="time_delay",
        title="torque that arrives late",
        formula="w(t) = τ(t − T), by a Padé approximation of degrees 2 and 3",
        lives_in="frequency",
        place=0,
        side="input",
        parameters=(parameter("delay_time", "s", "delay T", 0.005, 0.0, 0.5),),
        shapes=(("delay_time", (0.004, 0.01, 0.03, 0.1)),),
        rivals=("amplifier_lag", "friction_lag"),
        input=faded(T, LEAST, x1 - sp.Rational(2, 5) * x2 + x3 / 20, w),
        states=tuple(
            EffectState(
                state=State(id=x.name, unit="N m", description=name),
                rhs=rhs,
                rate=sp.S.Zero if i < 2 else 9 / held,
            )
            for i, (x, name, rhs) in enumerate(zip((x1, x2, x3), names, rates, strict=True))
        ),
    )


EFFECT = _delay()
