"""Torques that bend with position as springs and weights do: these part in the next but one power of the angle only.

What is constant or linear in the position belongs to the base. A quadratic spring and a weight at its highest or lowest
point differ in the fourth power, a cubic one and a weight at the side in the fifth. The bends are no entries of the
catalogue: they stand for every other torque that bends so, where the catalogue holds one kind of entry only.
"""

from collections.abc import Sequence

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.scales import POSITION, TORQUE
from haptid.model.equations.quantity import Quantity

x = q - sp.Symbol("epos", real=True)


def _coefficient(power: int) -> Quantity:
    return parameter(f"bend_{power}", f"N m/rad^{power}", f"coefficient of power {power}", 0.02, -5.0, 5.0)


SECOND, THIRD = _coefficient(2), _coefficient(3)
POWERS = {SECOND.id: TORQUE / POSITION**2, THIRD.id: TORQUE / POSITION**3}


def bend(id: str, formula: str, torque: sp.Expr, parameters: Sequence[Quantity]) -> Effect:
    """Return a bend as an effect; its parameters are coefficients of powers of the angle."""
    return Effect(
        id=id,
        title="torque that bends with position",
        formula=formula,
        lives_in="position",
        side="torque",
        parameters=tuple(parameters),
        amplitudes=len(parameters),
        relative={c.id: POWERS[c.id] for c in parameters},
        torque=torque,
    )


_polynomial = -SECOND.symbol * x**2 - THIRD.symbol * x**3
OF_WEIGHT = tuple(
    bend(id, "−b2·(q − epos)² − b3·(q − epos)³", _polynomial, (SECOND, THIRD)) for id in ("even_bend", "odd_bend")
)
"""What a weight has to be told from: where a quadratic spring is missing in the catalogue, and where a cubic one is."""
OF_QUADRATIC = bend("even_bend", "−2·b2·(1 − cos(q − epos))", -2 * SECOND.symbol * (1 - sp.cos(x)), (SECOND,))
"""What a quadratic spring has to be told from."""
OF_CUBIC = bend("odd_bend", "−6·b3·(q − epos − sin(q − epos))", -6 * THIRD.symbol * (x - sp.sin(x)), (THIRD,))
"""What a cubic spring has to be told from."""
