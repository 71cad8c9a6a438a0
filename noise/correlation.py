"""Noise of runs as values: ARMA correlation (`Arma`), amplitude scatter (`Scatter`), and their `Whitener`.

The residual of one run, over the sensor's standard deviation, has the covariance C = A + s²·M·Mᵀ. A is the covariance
of the sensor noise (an ARMA(1,1) process: white noise plus a first-order autoregressive process). Column c of M is the
change of the readings with the relative amplitude of cycle c. Where several joints move together, each joint has cycles
and a scatter of its own, and a cycle of one joint moves the readings of all joints. `Whitener` applies C^−½.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from scipy.signal import lfilter

from haptid.measurement.values.run import Array

Path = Literal["reading", "torque"]
LEAST_SINGULAR_VALUE_RATIO = 1e-6
"""Ratio to the largest singular value below which a singular direction is dropped."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Arma:
    """ARMA(1,1) model of the sensor noise: (1 − φB)·r = (1 − θB)·σ·ε with white ε of variance 1.

    B shifts by one row; r is the noise over the sensor's stated standard deviation.

    Parameters
    ----------
    phi, theta
        Coefficients φ and θ of the autoregressive and the moving-average part.
    sigma
        Standard deviation σ of the innovations over that of the stated noise.
    freedom
        Degrees of freedom of the estimated power at low frequency: 2 over its squared relative standard error;
        infinite where the model is not estimated.
    """

    phi: float = 0.0
    theta: float = 0.0
    sigma: float = 1.0
    freedom: float = field(default=np.inf, compare=False)

    @property
    def white(self) -> bool:
        """Whether rows are uncorrelated: with φ = θ both filters cancel."""
        return self.phi == self.theta

    def whiten(self, x: Array) -> Array:
        """Apply the inverse filter ε = (1 − φB)/(1 − θB)·r/σ from rest.

        Parameters
        ----------
        x
            Values over the sensor's standard deviation, rows along axis 0.

        Returns
        -------
        ndarray, shape of ``x``
        """
        if self.white:
            return np.asarray(x / self.sigma)
        return np.asarray(lfilter([1.0, -self.phi], [1.0, -self.theta], x, axis=0) / self.sigma)

    def gain(self, angle: Array) -> Array:
        """Return the noise's amplitude over that of the stated white noise.

        Parameters
        ----------
        angle
            Frequency ω [rad per row], any shape.

        Returns
        -------
        ndarray, shape of ``angle``
            σ·|1 − θ·e^(−iω)|/|1 − φ·e^(−iω)|.
        """
        turn = np.exp(-1j * angle)
        return np.asarray(self.sigma * np.abs((1.0 - self.theta * turn) / (1.0 - self.phi * turn)))

    @property
    def low_frequency_gain(self) -> float:
        """Return `gain` at frequency 0."""
        return float(self.gain(np.zeros(1))[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """Amplitudes of one joint that scatter from cycle to cycle of its torque.

    Parameters
    ----------
    size
        Standard deviation s of the relative amplitude of a cycle.
    path
        Whether the scatter acts on the torque or on the reading.
    centre
        Position about which the reading's amplitude is taken [rad].
    column
        Which of the run's joints it is.
    """

    size: float = 0.0
    path: Path = "reading"
    centre: float = 0.0
    column: int = 0

    def but(self, **changes: Any) -> Scatter:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Scatter
            The copy.
        """
        return replace(self, **changes)


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Noise of all runs.

    Parameters
    ----------
    arma
        ARMA model of the sensor noise.
    scatters
        Amplitude scatter from cycle to cycle, at most one of each joint.
    """

    arma: Arma = field(default_factory=Arma)
    scatters: tuple[Scatter, ...] = ()

    @property
    def terms(self) -> int:
        """Number of noise terms beside white noise: correlation, and the scatter of each joint."""
        return len(self.scatters) + (not self.arma.white)

    @property
    def on_torque(self) -> bool:
        """Whether the scatter of any joint acts on its torque."""
        return any(scatter.path == "torque" for scatter in self.scatters)

    def but(self, **changes: Any) -> Noise:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Noise
            The copy.
        """
        return replace(self, **changes)


def directions(M: Array) -> tuple[Array, Array]:
    """Return the left singular vectors and singular values of M above rounding, from its Gram matrix.

    Parameters
    ----------
    M
        Matrix, shape (n, k).

    Returns
    -------
    vectors : ndarray, shape (n, K)
        Left singular vectors.
    values : ndarray, shape (K,)
        Singular values above `LEAST_SINGULAR_VALUE_RATIO` times the largest, K ≤ k.

    Notes
    -----
    LAPACK's divide and conquer (gesdd) does not converge on some matrices with equal columns; an eigenproblem does.
    """
    values, vectors = np.linalg.eigh(M.T @ M)
    # Eigenvalues are squared singular values.
    keep = values > LEAST_SINGULAR_VALUE_RATIO**2 * max(float(values.max(initial=0.0)), 1e-300)
    d = np.sqrt(values[keep])
    return np.asarray(M @ (vectors[:, keep] / d)), d


@dataclass(frozen=True, slots=True, kw_only=True)
class Whitener:
    """Square root of the inverse covariance of one run: C^−½ = (I − Q·diag(1 − 1/√(1 + λ))·Qᵀ)·filter.

    Parameters
    ----------
    arma
        Inverse filter that is applied first.
    Q, growth
        Orthonormal directions (n_t·n_joints, K) in which the variance is 1 + λ, and λ (K,).
    """

    arma: Arma = field(default_factory=Arma)
    Q: Array | None = None
    growth: Array | None = None

    @classmethod
    def of(cls, arma: Arma, S: Array | None = None) -> Whitener:
        """Build the whitener of sensor noise and amplitude scatter.

        Parameters
        ----------
        arma
            ARMA model of the sensor noise.
        S
            s·M over the sensor's standard deviation, shape (n_t, n_joints, n_cycles); no scatter where None or where
            an entry is not finite: the simulation behind S diverged, and its residual is infinite anyway.

        Returns
        -------
        Whitener
            C^−½ for the covariance C of sensor noise and scatter, in units of the sensor's variance.
        """
        if S is None or not np.isfinite(S).all():
            return cls(arma=arma)
        Q, d = directions(arma.whiten(S).reshape(-1, S.shape[-1]))
        return cls(arma=arma, Q=Q, growth=d**2)

    def __call__(self, x: Array) -> Array:
        """Whiten residuals or Jacobians.

        Parameters
        ----------
        x
            Values over the sensor's standard deviation, shape (n_t, n_joints) or (n_t, n_joints, k).

        Returns
        -------
        ndarray, shape of ``x``
            C^−½·x.
        """
        flat = self.arma.whiten(x)
        if self.Q is None or self.growth is None:
            return flat
        rows = flat.reshape(len(self.Q), -1)
        shrink = 1.0 - 1.0 / np.sqrt(1.0 + self.growth)
        return np.asarray(rows - self.Q @ (shrink[:, None] * (self.Q.T @ rows))).reshape(x.shape)

    def log_determinant(self, rows: int) -> float:
        """Return ln det C = 2·n·ln σ + Σ ln(1 + λ) for n = ``rows`` readings of all joints.

        The ARMA filter adds no more: it is triangular with 1/σ on its diagonal.

        Parameters
        ----------
        rows
            Number of readings n of all joints.

        Returns
        -------
        float
            ln det C of the covariance C of readings over the sensor's standard deviation.
        """
        scattered = 0.0 if self.growth is None else float(np.log1p(self.growth).sum())
        return 2.0 * rows * float(np.log(self.arma.sigma)) + scattered
