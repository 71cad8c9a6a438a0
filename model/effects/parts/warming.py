"""Friction that settles while the joint warms up, dry and viscous alike.

It is no entry of the catalogue, which holds a drift of either. It stands for all that lies between, where one of them
is missing.
"""

from collections.abc import Sequence

import sympy as sp

from haptid.model.effects.effect import Effect, t
from haptid.model.equations.quantity import Quantity


def settling(parameters: Sequence[Quantity]) -> sp.Expr:
    """Return 1 + a·exp(−t/T); ``parameters`` are a, the relative excess at the start, and T, the time constant [s]."""
    excess, time = (x.symbol for x in parameters)
    return 1 + excess * sp.exp(-t / time)


def warming(parameters: Sequence[Quantity], relative: dict[str, sp.Expr]) -> Effect:
    """Return it as an effect; ``parameters`` are those of the entry that has to be told from it."""
    level = settling(parameters)
    return Effect(
        id="friction_warming",
        title="friction that settles during a run, dry and viscous alike",
        formula="Fc, Fs, σ2 times (1 + a·exp(−t/T))",
        lives_in="time",
        side="friction",
        parameters=tuple(parameters),
        relative=relative,
        coulomb_level=level,
        viscous_level=level,
    )
