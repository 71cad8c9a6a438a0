"""What is known of the inertial parameters: a Gaussian over π that measured coefficients narrow, test by test.

Coefficients are linear in π, so the update is exact: with rows A, values y and covariance R,
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
    """Coefficients of one configuration as fitted: values (n,) and covariance (n, n)."""

    coefficients: tuple[Coefficient, ...]
    values: Array
    covariance: Array

    def __post_init__(self) -> None:
        """Check shapes."""
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
    """Return the coefficients' linear maps from π, shape (n, n_pi)."""
    return np.array([coefficient.linear_map for coefficient in coefficients])


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkBelief:
    """Mean (n_pi,) and covariance (n_pi, n_pi) of π."""

    mean: Array
    covariance: Array

    @classmethod
    def from_device(cls, device: Device) -> LinkBelief:
        """Return the device's first guesses with their stated uncertainty."""
        mean, covariance = pi_prior(device)
        return cls(mean=mean, covariance=covariance)

    def predict(self, coefficients: Sequence[Coefficient]) -> tuple[Array, Array]:
        """Return mean (n,) and covariance (n, n) of coefficients: the next configuration's first guess and prior."""
        A = rows_of(coefficients)
        return A @ self.mean, A @ self.covariance @ A.T

    def update(self, coefficients: Sequence[Coefficient], values: Array, covariance: Array) -> LinkBelief:
        """Return the belief after coefficients were measured: values (n,), covariance (n, n)."""
        measured = Measurement(
            coefficients=tuple(coefficients), values=np.asarray(values), covariance=np.asarray(covariance)
        )
        A, P = measured.rows, self.covariance
        innovation = A @ P @ A.T + measured.covariance
        K = np.linalg.lstsq(innovation, A @ P, rcond=1e-14)[0].T
        keep = np.eye(self.mean.size) - K @ A
        updated = keep @ P @ keep.T + K @ measured.covariance @ K.T
        return LinkBelief(mean=self.mean + K @ (measured.values - A @ self.mean), covariance=(updated + updated.T) / 2)
