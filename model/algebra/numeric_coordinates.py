"""Joint positions as floating-point numbers: the `Coordinates` of one posture, or of many postures at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from haptid.model.algebra.vectors import Scalar

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Numbers:
    """Coordinates at given joint positions.

    Parameters
    ----------
    q
        Positions [rad] or [m], shape (n_q,), or (n_q, n) for n postures at once.
    """

    q: Array

    def constant(self, value: Fraction | int) -> Scalar:
        """Return a float.

        Parameters
        ----------
        value
            Rational number.

        Returns
        -------
        float
            Nearest floating-point number.
        """
        return float(value)

    def cos_sin(self, moved_by: Mapping[int, Fraction]) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of Σ moved_by[j]·q_j.

        Parameters
        ----------
        moved_by
            Joint → coefficient.

        Returns
        -------
        cos, sin : float or ndarray
            Of shape () or (n,), as one entry of ``q``.
        """
        angle = self.travel(moved_by)
        return np.cos(angle), np.sin(angle)

    def travel(self, moved_by: Mapping[int, Fraction]) -> Scalar:
        """Return Σ moved_by[j]·q_j.

        Parameters
        ----------
        moved_by
            Joint → coefficient.

        Returns
        -------
        float or ndarray
            The sum [rad] or [m], of shape () or (n,), as one entry of ``q``.
        """
        return sum((float(ratio) * self.q[j] for j, ratio in moved_by.items()), np.zeros_like(self.q[0]))

    def tidy(self, value: Scalar) -> Scalar:
        """Return `value`: numbers need no canonical form.

        Parameters
        ----------
        value
            A number or an array.

        Returns
        -------
        Scalar
            The same.
        """
        return value
