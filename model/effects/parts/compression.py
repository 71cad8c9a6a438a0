"""A gain that changes with torque, half way between the two of the catalogue.

In powers of x² = (τ/τ₀)², the amplifier whose gain is 1 + a·x² has nothing beyond the first, one that saturates as tanh
does has 6/5·a²·x⁴; this one has half of that. It is no entry: it stands for every other gain of that kind, where the
catalogue holds one of the two only.
"""

from collections.abc import Sequence

import sympy as sp

from haptid.model.effects.effect import Effect, w
from haptid.model.equations.quantity import Quantity


def compression(
    change: sp.Expr, formula: str, parameters: Sequence[Quantity], relative: dict[str, sp.Expr], place: int
) -> Effect:
    """Return it as an effect; ``change`` is a·x² in terms of the parameters, which are those of the entry."""
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
