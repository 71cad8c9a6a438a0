"""Which effects leave the rigid body no sense: two `TorqueFit`s in, keys of effects out.

A torque that arrives late by a lag T, at a joint with inertia I and viscous friction c, gives the speed

    v = τ / ((1 + T·s)·(c + I·s)),

in which T and the joint's own time constant I/c may change places. A lag as long as I/c, beside an inertia of next to
nothing, fits as well as no lag: it follows whatever the friction of the nominal model lacks. The nominal model without
a lag has the inertia I + c·T, which is more than twice I where T is longer than I/c. So an inertia far from the nominal
model's tells a name that only stands in for something else, however well it fits and predicts the torque.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.support.errors import NumericalError

INERTIA = "inertia"


def moves_inertia(base: TorqueFit, model: TorqueFit) -> bool:
    """Say whether the inertia of a model is far from that of the nominal model.

    Parameters
    ----------
    base
        Nominal model.
    model
        Model with effects.

    Returns
    -------
    bool
        As `is_far`, with the standard errors of both fits. False where the runs do not tell the inertia of ``base``.
    """
    known = base.std[INERTIA]
    if known == 0.0:  # stated, or without influence on the torque
        return False
    return is_far(base.values[INERTIA], model.values[INERTIA], math.hypot(known, model.std[INERTIA]))


def tells_inertia(base: TorqueFit) -> bool:
    """Say whether the runs tell the inertia of the nominal model, or it is stated.

    Parameters
    ----------
    base
        Nominal model.

    Returns
    -------
    bool
        False for slow sweeps, in which friction and gravity alone make the torque.
    """
    return base.values[INERTIA] > THRESHOLDS.torque.least_inertia_in_standard_errors * base.std[INERTIA]


def is_far(before: float, after: float, error: float) -> bool:
    """Say whether two inertias differ by a clear factor, and by more than their errors.

    Parameters
    ----------
    before, after
        Inertias in one unit.
    error
        Standard error of their difference in that unit.

    Returns
    -------
    bool
        True where both hold.
    """
    limits = THRESHOLDS.torque
    if abs(after - before) <= limits.least_change_of_inertia_in_standard_errors * error:
        return False
    return not 1.0 / limits.largest_change_of_inertia <= after / before <= limits.largest_change_of_inertia


def find_movers(base: TorqueFit, model: TorqueFit) -> frozenset[str]:
    """Find the effects that move the inertia far from that of the nominal model.

    Parameters
    ----------
    base
        Nominal model.
    model
        Model with its effects.

    Returns
    -------
    frozenset of str
        Keys of the effects without any one of which the inertia is near again; of all effects where there is none of
        them. Empty where the inertia of ``model`` is near.
    """
    if not model.effects or not moves_inertia(base, model):
        return frozenset()
    start = {INERTIA: base.values[INERTIA]}
    return find_blamed(model, lambda without: not moves_inertia(base, without), start)


def find_blamed(
    model: TorqueFit, is_sound: Callable[[TorqueFit], bool], start: Mapping[str, float] | None = None
) -> frozenset[str]:
    """Find the effects without which a model is sound.

    Parameters
    ----------
    model
        Model with its effects, which is not sound.
    is_sound
        Whether a model is.
    start
        Start values by id of the fits without an effect, those of ``model`` for all others.

    Returns
    -------
    frozenset of str
        Keys of the effects without any one of which the refitted model is sound; of all effects where there is none of
        them.
    """
    blamed = set()
    for effect in model.effects:
        rest = tuple(e for e in model.effects if e is not effect)
        with suppress(NumericalError):
            if is_sound(fit_model(model.study, rest, {**model.values, **(start or {})})):
                blamed.add(effect.key)
    return frozenset(blamed or (effect.key for effect in model.effects))
