"""What the stranger's encoder and recorder make of a true motion: jitter, coloured noise, steps, smoothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.stranger.ranges import draw, read_ranges


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorder:
    """A position sensor and how it is recorded.

    Parameters
    ----------
    white, resolution
        Standard deviation of white noise, and encoder step [rad].
    coloured, correlation_time
        Standard deviation [rad] of an added noise behind two lags in a row, and time constant of each [s].
    jitter
        Standard deviation of the times at which readings are taken, about the times that are recorded [s].
    smoothing
        Number of rows over which readings are averaged, without delay; 1 for none.
    """

    white: float
    resolution: float
    coloured: float = 0.0
    correlation_time: float = 0.1
    jitter: float = 0.0
    smoothing: int = 1

    @property
    def std(self) -> float:
        """Standard deviation of the noise of a joint at rest [rad], smoothing of its white part included."""
        white = (self.white**2 + self.resolution**2 / 12.0) / self.smoothing
        return float(np.sqrt(white + self.coloured**2))

    def read(self, t: Array, y: Array, v: Array, rng: np.random.Generator) -> Array:
        """Return readings of positions.

        Parameters
        ----------
        t
            Times that are recorded [s], shape (n,).
        y, v
            Positions [rad] and velocities [rad/s] at these times, shape (n,).
        rng
            Source of random numbers.

        Returns
        -------
        Array
            Readings [rad], shape (n,).
        """
        read = y + v * self.jitter * rng.standard_normal(y.shape) + self.white * rng.standard_normal(y.shape)
        if self.coloured > 0:
            read += self.coloured * _lagged_twice(t, self.correlation_time, rng)
        read = self.resolution * np.round(read / self.resolution)
        return _smooth(read, self.smoothing)


def _lagged_twice(t: Array, time: float, rng: np.random.Generator) -> Array:
    """Return noise of standard deviation 1 behind two lags, long after it began."""
    keep = float(np.exp(-float(np.median(np.diff(t))) / time))
    before = int(np.ceil(20.0 / (1.0 - keep)))
    made = lfilter([1.0], [1.0, -2.0 * keep, keep**2], rng.standard_normal(before + t.size))[before:]
    return np.asarray(made * np.sqrt((1.0 - keep**2) ** 3 / (1.0 + keep**2)))


def _smooth(read: Array, rows: int) -> Array:
    """Average over ``rows`` rows about each, over fewer at the ends."""
    half = min(rows // 2, (read.size - 1) // 2)
    sums = np.concatenate([[0.0], np.cumsum(read - read[0])])
    k = np.arange(read.size)
    reach = np.minimum(np.minimum(half, k), read.size - 1 - k)
    return np.asarray(read[0] + (sums[k + reach + 1] - sums[k - reach]) / (2 * reach + 1))


def draw_recorder(rng: np.random.Generator) -> tuple[Recorder, float | None]:
    """Draw a recorder, and what its campaign says of the noise.

    Parameters
    ----------
    rng
        Random generator, which moves on.

    Returns
    -------
    recorder : Recorder
    stated : float or None
        Standard deviation that is stated [rad]; None where nothing is said.
    """
    ranges = read_ranges()["noise"]
    drawn = {name: draw(range_, rng) for name, range_ in ranges.items() if isinstance(range_, dict)}
    has = {name: bool(rng.random() < ranges[name]) for name in ("coloured", "jitter", "smoothed", "stated")}
    recorder = Recorder(
        white=drawn["white_rad"],
        resolution=drawn["resolution_rad"],
        coloured=drawn["coloured_over_white"] * drawn["white_rad"] if has["coloured"] else 0.0,
        correlation_time=drawn["correlation_time_s"],
        jitter=drawn["jitter_s"] if has["jitter"] else 0.0,
        smoothing=int(drawn["smoothing_rows"]) if has["smoothed"] else 1,
    )
    return recorder, drawn["stated_over_true"] * recorder.std if has["stated"] else None
