"""Torque that arrives late: a rational approximation of e^(−sT), mode by mode.

e^(−x) ≈ (60 − 24x + 3x²)/(60 + 36x + 9x² + x³), x = sT, the Padé approximation of degrees 2 and 3 (Baker and
Graves-Morris 1996, table of the exponential function). Below T = `LEAST` the poles stay where they are, D(y) with
y = s·LEAST, and the numerator N(y) holds the powers up to three of e^(−ρy)·D(y), ρ = T/`LEAST`: the Padé one at ρ = 1,
D itself at ρ = 0. N/D = n₃ + Σ r_k/(y − p_k), r_k = N(p_k)/D'(p_k): one real pole and a pair −a ± ib. Only b leads from
state to state.
"""

import numpy as np
import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, parameter, w
from haptid.model.effects.parts.cascade import cascade
from haptid.model.equations.equations import State

LEAST = sp.Float(4e-3)
DENOMINATOR = np.polynomial.Polynomial([60.0, 36.0, 9.0, 1.0])


def _delay() -> Effect:
    T = sp.Symbol("delay_time", real=True)
    x, c, s = sp.symbols("delay_mode delay_pair_1 delay_pair_2", real=True)
    held = sp.Max(T, LEAST)
    rho = T / held
    through = 1 - 9 * rho + 18 * rho**2 - 10 * rho**3
    numerator = (60, 36 - 60 * rho, 9 - 36 * rho + 30 * rho**2, through)
    real, pair = sorted(map(complex, DENOMINATOR.roots()), key=lambda p: p.imag)[1:]

    def share(p: complex, part: str) -> sp.Expr:
        terms = [getattr(p**k / complex(DENOMINATOR.deriv()(p)), part) for k in range(4)]
        return sp.Add(*(sp.Float(term) * n for term, n in zip(terms, numerator, strict=True)))

    fast, a, b = (sp.Float(number) for number in (-real.real, -pair.real, pair.imag))
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
        contenders=(cascade(sp.Float(1e-4)),),
        input=through * w + share(real, "real") * x + 2 * (share(pair, "real") * c - share(pair, "imag") * s),
        states=tuple(
            EffectState(state=State(id=z.name, unit="N m", description=name), rhs=rhs, rate=rate)
            for z, rhs, rate, name in modes
        ),
    )


EFFECT = _delay()
