"""How large a disturbance of the stranger is: from the threshold of notice to a share of the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.stranger.campaign import positions
from haptid.virtual_device.stranger.ranges import read_ranges
from studies.hidden.sizing import LARGEST, Reach, solve_size

STEP = 3e-4
"""Longest integration step of the sizing [s]."""
TOLERANCE = 1.25
"""Factor by which a size may miss the threshold or the largest share, which are found to a tenth."""
Joint = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """The joint on which disturbances are sized.

    Parameters
    ----------
    base
        LuGre joint of the same numbers, and what a refit of it can follow.
    joint
        The stranger's joint.
    still
        Its undisturbed motion on the runs of ``base``, shape (n,).
    std
        Standard deviation of the noise [rad].
    """

    base: Reach
    joint: Joint
    still: Array
    std: float

    def change(self, values: dict[str, float]) -> Array:
        """Return how a disturbance changes the positions.

        Parameters
        ----------
        values
            Parameters of ``stranger.c`` by name, SI units.

        Returns
        -------
        ndarray, shape (n,)
            Disturbed minus undisturbed positions [rad].

        Raises
        ------
        NumericalError
            Where the disturbed joint runs away.
        """
        return positions({**self.joint, **values}, self.base.runs, STEP) - self.still

    def share(self, values: dict[str, float]) -> float:
        """Return the RMS of a change over that of the motion about its mean [1].

        Parameters
        ----------
        values
            Parameters of ``stranger.c`` by name, SI units.

        Returns
        -------
        float
        """
        return self.base.share(self.change(values))

    def left(self, values: dict[str, float]) -> float:
        """Return what a refit leaves of a change to first order, over the noise.

        Parameters
        ----------
        values
            Parameters of ``stranger.c`` by name, SI units.

        Returns
        -------
        float
            RMS over the standard deviation of the noise [1].
        """
        return self.base.left_at_first(self.change(values)) / self.std


def draw_size(
    bench: Bench, effect: Callable[[float], dict[str, float]], largest: float, rng: np.random.Generator
) -> float:
    """Draw a size, uniform in its logarithm between the threshold of notice and a share of the motion.

    Parameters
    ----------
    bench
        Joint on which the disturbance is sized.
    effect
        Parameters of the disturbance as a function of its size.
    largest
        Largest share of the motion [1].
    rng
        Random generator, which moves on.

    Returns
    -------
    float
        Size [1].

    Raises
    ------
    NumericalError
        Where the threshold lies above the largest share (the joint's own parameters take up all of it), or the size
        that was drawn is outside of both by more than `TOLERANCE`: what is left need not grow evenly with the size.
    """
    least = read_ranges()["case"]["smallest_left"]
    low = solve_size(lambda k: bench.left(effect(k)), least)
    high = solve_size(lambda k: bench.share(effect(k)), largest)
    if high <= low:
        msg = f"no size between {low:g} and {high:g}: the joint's own parameters take up all of it"
        raise NumericalError(msg)
    size = float(np.exp(rng.uniform(np.log(low), np.log(min(high, LARGEST)))))
    change = bench.change(effect(size))
    left, share = bench.base.left_at_first(change) / bench.std, bench.base.share(change)
    if left < least / TOLERANCE or share > largest * TOLERANCE:
        msg = f"the size {size:g} leaves {left:g} of the noise and is {share:g} of the motion"
        raise NumericalError(msg)
    return size
