"""What the encoder makes of a true motion: scatter from cycle to cycle, noise, steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from haptid.virtual_device.machine.compiled import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A position sensor.

    Parameters
    ----------
    noise
        Standard deviation of white noise [rad].
    resolution
        Encoder step [rad]; 0 for none.
    coloured, correlation_time
        Standard deviation [rad] and time constant [s] of an added first-order autoregressive noise.
    """

    noise: float = 2e-4
    resolution: float = 1.5e-4
    coloured: float = 0.0
    correlation_time: float = 0.1

    @property
    def std(self) -> float:
        """√(noise² + resolution²/12) [rad]."""
        return float(np.sqrt(self.noise**2 + self.resolution**2 / 12.0))

    def read(self, t: Array, y: Array, rng: np.random.Generator) -> Array:
        """Return readings of positions: noise added, then rounded to the encoder step.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n,).
        y
            Positions [rad], shape (n,).
        rng
            Source of random numbers.

        Returns
        -------
        Array
            Readings [rad], shape (n,).
        """
        read = y + self.noise * rng.standard_normal(y.shape)
        if self.coloured > 0:
            keep = np.exp(-float(np.median(np.diff(t))) / self.correlation_time)
            shocks = rng.standard_normal(y.shape)
            shocks[1:] *= np.sqrt(1.0 - keep**2)
            read += self.coloured * lfilter([1.0], [1.0, -keep], shocks)
        return np.asarray(self.resolution * np.round(read / self.resolution) if self.resolution > 0 else read)


def cycle_factors(t: Array, period: float, scatter: float, rng: np.random.Generator) -> Array:
    """Return the factor 1 + s ξ_c of the cycle c = ⌊t / period⌋ of every time, with ξ standard normal.

    Parameters
    ----------
    t
        Times of the rows [s], shape (n,), counted from the first.
    period
        Length of a cycle [s].
    scatter
        Relative standard deviation s of the amplitude.
    rng
        Source of random numbers.

    Returns
    -------
    Array
        Factors, shape (n,).
    """
    cycle = np.floor((t - t[0]) / period + 1e-9).astype(int)
    return np.asarray(1.0 + scatter * rng.standard_normal(cycle[-1] + 1)[cycle])
