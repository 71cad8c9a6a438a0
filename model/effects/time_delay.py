"""Torque that arrives late: the Padé approximation of e^(−sT) with two zeros and three poles, mode by mode.

e^(−x) ≈ N(x)/D(x) = (60 − 24x + 3x²)/(60 + 36x + 9x² + x³) (Baker and Graves-Morris 1996, table of the exponential
function) = Σ r_k/(x − p_k) with x = sT, r_k = N(p_k)/D'(p_k): one real pole and a pair −a ± ib. Only b
leads from a state to another.
"""

import numpy as np
import sympy as sp

from model.effect import Effect, EffectState, faded, parameter, w
from model.equations import State

LEAST = sp.Float(1e-3)
N, D = np.polynomial.Polynomial([60.0, -24.0, 3.0]), np.polynomial.Polynomial([60.0, 36.0, 9.0, 1.0])


def _delay() -> Effect:
    T = sp.Symbol("delay_time", real=True)
    x, c, s = sp.symbols("delay_mode delay_pair_1 delay_pair_2", real=True)
    held = sp.Max(T, LEAST)
    real, pair = sorted(map(complex, D.roots()), key=lambda p: p.imag)[1:]
    r, q = (complex(N(p) / D.deriv()(p)) for p in (real, pair))
    fast, a, b = (sp.Float(v) for v in (-real.real, -pair.real, pair.imag))
    late = sp.Float(r.real) * x + 2 * (sp.Float(q.real) * c - sp.Float(q.imag) * s)
    modes = (
        (x, (w - fast * x) / held, fast / held, "part of the delayed torque that decays without turning"),
        (c, (w - a * c - b * s) / held, a / held, "part of the delayed torque that turns, in phase"),
        (s, (b * c - a * s) / held, a / held, "part of the delayed torque that turns, out of phase"),
    )
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
        input=faded(T, LEAST, late, w),
        states=tuple(
            EffectState(state=State(id=z.name, unit="N m", description=name), rhs=rhs, rate=rate)
            for z, rhs, rate, name in modes
        ),
    )


EFFECT = _delay()
