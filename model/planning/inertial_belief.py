"""A Gaussian belief over the inertial parameters π, updated by measured coefficients test by test.

`LinkBelief` and a fit's coefficients come in, the updated `LinkBelief` goes out. Coefficients are linear in π, so that
the Kalman update is exact: with rows A, values y and covariance R,
K = P Aᵀ (A P Aᵀ + R)⁻¹,  π ← π + K (y − A π),  P ← (1 − K A) P (1 − K A)ᵀ + K R Kᵀ (Joseph's form).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.model.device.device import Device
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.locked_dynamics import Coefficient

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """Fitted coefficients of one configuration.

    Parameters
    ----------
    coefficients
        The n coefficients.
    values
        Fitted values in the units of the coefficients, shape (n,).
    covariance
        Covariance of the fitted values, shape (n, n).
    """

    coefficients: tuple[Coefficient, ...]
    values: Array
    covariance: Array

    def __post_init__(self) -> None:
        """Check that the shapes of values and covariance agree with the coefficients; ValueError where not."""
        n = len(self.coefficients)
        if self.values.shape != (n,) or self.covariance.shape != (n, n):
            got = f"{self.values.shape}, {self.covariance.shape}"
            msg = f"{n} coefficients need values ({n},) and covariance ({n}, {n}), got {got}"
            raise ValueError(msg)

    @property
    def rows(self) -> Array:
        """A, shape (n, n_pi)."""
        return rows_of(self.coefficients)


def rows_of(coefficients: Sequence[Coefficient]) -> Array:
    """Return the rows A of coefficients, which are linear maps of π.

    Parameters
    ----------
    coefficients
        The n coefficients of a configuration.

    Returns
    -------
    Array
        A, shape (n, n_pi).
    """
    return np.array([coefficient.linear_map for coefficient in coefficients])


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkBelief:
    """Gaussian belief over the inertial parameters π.

    Parameters
    ----------
    mean
        Mean in the order of `pi_ids`, shape (n_pi,).
    covariance
        Covariance, shape (n_pi, n_pi).
    """

    mean: Array
    covariance: Array

    @classmethod
    def from_device(cls, device: Device) -> LinkBelief:
        """Return the belief of a device's first guesses with their stated uncertainty (`pi_prior`).

        Parameters
        ----------
        device
            Device with first guesses and standard deviations of its links and motors.

        Returns
        -------
        LinkBelief
            Prior of π at the first guesses.
        """
        mean, covariance = pi_prior(device)
        return cls(mean=mean, covariance=covariance)

    def predict(self, coefficients: Sequence[Coefficient]) -> tuple[Array, Array]:
        """Predict coefficients: first guess and prior of the next configuration.

        Parameters
        ----------
        coefficients
            The n coefficients of a configuration, with rows A.

        Returns
        -------
        mean : Array
            A·mean, in the units of the coefficients, shape (n,).
        covariance : Array
            A·P·Aᵀ, shape (n, n).
        """
        A = rows_of(coefficients)
        return A @ self.mean, A @ self.covariance @ A.T

    def update(self, coefficients: Sequence[Coefficient], values: Array, covariance: Array) -> LinkBelief:
        """Update the belief by measured coefficients.

        Parameters
        ----------
        coefficients
            The n measured coefficients.
        values
            Measured values in the units of the coefficients, shape (n,).
        covariance
            Covariance R of the values, shape (n, n).

        Returns
        -------
        LinkBelief
            Belief after the update.

        Raises
        ------
        ValueError
            Where the shapes do not agree.
        """
        measured = Measurement(
            coefficients=tuple(coefficients), values=np.asarray(values), covariance=np.asarray(covariance)
        )
        A, P = measured.rows, self.covariance
        innovation = A @ P @ A.T + measured.covariance
        # least squares instead of an inverse: A P Aᵀ + R is singular where a coefficient has no uncertainty at all
        K = np.linalg.lstsq(innovation, A @ P, rcond=1e-14)[0].T
        # Joseph's form stays positive semidefinite in spite of rounding in K
        keep = np.eye(self.mean.size) - K @ A
        updated = keep @ P @ keep.T + K @ measured.covariance @ K.T
        return LinkBelief(mean=self.mean + K @ (measured.values - A @ self.mean), covariance=(updated + updated.T) / 2)
