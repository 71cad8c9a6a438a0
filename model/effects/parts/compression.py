"""A gain that changes with torque, half way between the two of the catalogue: their contender.

In powers of x² = (τ/τ₀)², the gain 1 + a·x² has no second power, the gain of a tanh saturation has 6/5·a²·x⁴, and the
gain of this module has 3/5·a²·x⁴. The effect is not in the catalogue: it stands for every other gain of this kind,
where the catalogue holds one of the two only.
"""

from collections.abc import Sequence

import sympy as sp

from haptid.model.effects.effect import Effect, w
from haptid.model.equations.quantity import Quantity


def compression(
    change: sp.Expr, formula: str, parameters: Sequence[Quantity], relative: dict[str, sp.Expr], place: int
) -> Effect:
    """Make the compression of the gain as an effect.

    Parameters
    ----------
    change
        Relative change of the gain a·x² in ``w`` and the symbols of ``parameters``.
    formula
        ``change`` as a reader writes it.
    parameters, relative, place
        Parameters, their scales and the place in the torque path of the catalogue effect whose contender this is.

    Returns
    -------
    Effect
        The effect w = τ·(1 + c + 3/5·c²) with c = ``change``.
    """
    return Effect(
        id="gain_compression",
        title="gain that changes with torque in another way",
        formula=f"w = τ·(1 + c + 3/5·c²), c = {formula}",
        lives_in="torque",
        place=place,
        side="input",
        parameters=tuple(parameters),
        relative=relative,
        input=w * (1 + change + sp.Rational(3, 5) * change**2),
    )
