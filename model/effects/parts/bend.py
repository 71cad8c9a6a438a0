"""Torques that are nonlinear in position, as those of springs and weights: contenders of catalogue effects.

Torques constant or linear in the position belong to the nominal model. A quadratic spring and a weight at its highest
or lowest point differ first in the fourth power of the angle, a cubic spring and a weight at the side in the fifth. The
effects of this module are not in the catalogue: they stand for every other torque of this kind, where the catalogue
holds one effect of the kind only.
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
    """Make an effect with a torque that is nonlinear in position.

    Parameters
    ----------
    id, formula
        Id of the effect, and its formula as a reader writes it.
    torque
        Torque [N m] in q, ``epos`` and the symbols of ``parameters``.
    parameters
        Coefficients of powers of the angle, of `SECOND` and `THIRD`; all of them are amplitudes.

    Returns
    -------
    Effect
        The effect.
    """
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
"""Contenders of a weight: where the catalogue holds no quadratic spring, and where it holds no cubic one."""
OF_QUADRATIC = bend("even_bend", "−2·b2·(1 − cos(q − epos))", -2 * SECOND.symbol * (1 - sp.cos(x)), (SECOND,))
"""Contender of a quadratic spring."""
OF_CUBIC = bend("odd_bend", "−6·b3·(q − epos − sin(q − epos))", -6 * THIRD.symbol * (x - sp.sin(x)), (THIRD,))
"""Contender of a cubic spring."""
