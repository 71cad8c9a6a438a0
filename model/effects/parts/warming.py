"""Dry and viscous friction that settle together while the joint warms up: the contender of either drift.

The effect is not in the catalogue, which holds a drift of dry and one of viscous friction. The effect stands for all
mixtures of the two, where one of them is missing.
"""

from collections.abc import Sequence

import sympy as sp

from haptid.model.effects.effect import Effect, t
from haptid.model.equations.quantity import Quantity


def settling(parameters: Sequence[Quantity]) -> sp.Expr:
    """Return the factor 1 + a·exp(−t/T) by which friction exceeds its level of a warm joint.

    Parameters
    ----------
    parameters
        a, the relative excess at the start, and T, the time constant [s].

    Returns
    -------
    sympy.Expr
        The factor, an expression of the time t [s].
    """
    excess, time = (x.symbol for x in parameters)
    return 1 + excess * sp.exp(-t / time)


def warming(parameters: Sequence[Quantity], relative: dict[str, sp.Expr]) -> Effect:
    """Make the common settling of dry and viscous friction as an effect.

    Parameters
    ----------
    parameters, relative
        Parameters (relative excess a, time constant T [s]) and their scales, of the catalogue effect whose contender
        this is.

    Returns
    -------
    Effect
        Fc, Fs and σ2 times 1 + a·exp(−t/T).
    """
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
