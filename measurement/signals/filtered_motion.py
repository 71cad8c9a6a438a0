"""Motion and torque of a run through one zero-phase filter: `Run` in, `FilteredMotion` out.

The inverse dynamic model is linear in its parameters, so that it holds for filtered signals where torque and regressor
pass through the same filter (Gautier 1997). The filter is a Gaussian G of standard deviation w; G′∗y and G″∗y are the
derivatives of the filtered position. White noise of standard deviation σ at rows Δt apart leaves in the acceleration

    var(G″∗e) = 3·σ²·Δt/(8·√π·w⁵).

Noise in a regressor biases least squares towards 0 by its share of the regressor's variance. Hence w is the smallest
width at which the noise is a small enough share of the variance of the acceleration, as
`THRESHOLDS.largest_noise_share_of_acceleration` says.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.smoothing import convolve_gaussian, dominant_period
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class FilteredMotion:
    """Filtered signals of one run on an even grid of its length.

    Parameters
    ----------
    t
        Time [s], shape (n,), evenly spaced from 0.
    q, v, a
        Position [rad], speed [rad/s] and acceleration [rad/s²] of the free joints, shape (n, n_joints) each.
    torque
        Torque [N m], shape (n, n_joints), at the same times.
    width
        Standard deviation of the filter [s].
    edge
        Rows at either end that the filter has no full surroundings for.
    interior
        Rows whose surroundings the filter saw whole, and that are scored.
    """

    t: Array
    q: Array
    v: Array
    a: Array
    torque: Array
    width: float
    edge: int
    interior: slice

    @property
    def white_noise_gain(self) -> float:
        """Standard deviation of white noise after the filter, twice, over that before it, √(Δt/(2·√π·√2·w))."""
        return math.sqrt(float(self.t[1]) / (2.0 * math.sqrt(2.0 * math.pi) * self.width))

    def through_filter(self, signal: Array) -> Array:
        """Filter a signal of the unfiltered motion, such as sgn q̇, as motion and torque were filtered.

        Parameters
        ----------
        signal
            Values at ``t``, shape (n, …).

        Returns
        -------
        ndarray
            The same shape.
        """
        return convolve_gaussian(signal, self.width_in_rows)

    @property
    def width_in_rows(self) -> float:
        """Standard deviation of the filter [rows]."""
        return self.width / float(self.t[1])


def common_width(runs: Sequence[Run]) -> float:
    """Choose the filter of a machine: the largest width that one of its runs asks for.

    Parameters
    ----------
    runs
        Runs of one configuration.

    Returns
    -------
    float
        Standard deviation of the filter [s].
    """
    return max(_width_of(run) for run in runs)


def filter_run(run: Run, width: float | None = None) -> FilteredMotion:
    """Filter position and torque of a run by one Gaussian.

    Parameters
    ----------
    run
        Run with the standard deviation of its readings.
    width
        Standard deviation of the filter [s]; the one that this run asks for where None.

    Returns
    -------
    FilteredMotion
        On as many even points as the run has rows.
    """
    n = run.t.size
    t = np.linspace(0.0, float(run.t[-1]), n)
    dt = float(t[1])
    y = _columns(t, run.t, run.y)
    width = max(_width_of(run) if width is None else width, THRESHOLDS.least_smoothing_width_rows * dt)
    rows = width / dt
    # What is computed along the filtered motion passes through the filter once more, so that its reach counts twice.
    edge = min(math.ceil(2.0 * THRESHOLDS.filter_reach_in_widths * rows), (n - 1) // 4)
    first = int(np.searchsorted(t, run.t[run.score_from]))
    return FilteredMotion(
        t=t,
        q=convolve_gaussian(y, rows),
        v=convolve_gaussian(y, rows, 1) / dt,
        a=convolve_gaussian(y, rows, 2) / dt**2,
        torque=convolve_gaussian(_torque(run, t), rows),
        width=width,
        edge=edge,
        interior=slice(max(first, edge), n - edge),
    )


def _width_of(run: Run) -> float:
    t = np.linspace(0.0, float(run.t[-1]), run.t.size)
    y = _columns(t, run.t, run.y)
    return max(_width(t, y[:, k], float(std)) for k, std in enumerate(_noise(run)))


def _noise(run: Run) -> Array:
    """Return the standard deviation of the readings: the stated one, or that of neighbouring rows where it is larger.

    A reading that was filtered or re-sampled before it was stored has less noise between neighbouring rows than it has.
    """
    seen = [estimate_noise(run.t, y) for y in run.y.T]
    return np.maximum(np.nan_to_num(run.sensor_std), seen)


def _torque(run: Run, t: Array) -> Array:
    """Return the torque at the times t, each value in the middle of the time for which it was held."""
    if run.hold == "linear":
        return _columns(t, run.t, run.u)
    middle = run.t + 0.5 * np.diff(run.t, append=2.0 * run.t[-1] - run.t[-2])
    return _columns(t, middle, run.u)


def _columns(t: Array, rows: Array, values: Array) -> Array:
    return np.column_stack([np.interp(t, rows, column) for column in values.T])


def _width(t: Array, y: Array, noise: float) -> float:
    """Return the smallest width [s] at which noise is a small enough share of the acceleration's variance."""
    dt = float(t[1])
    least = THRESHOLDS.least_smoothing_width_rows * dt
    most = max(THRESHOLDS.largest_filter_width_over_period * dominant_period(t, y), least)
    width = least
    while width < most:
        acceleration = convolve_gaussian(y, width / dt, 2) / dt**2
        variance = 3.0 * noise**2 * dt / (8.0 * math.sqrt(math.pi) * width**5)
        if variance <= THRESHOLDS.largest_noise_share_of_acceleration * float(np.var(acceleration)):
            return width
        width *= THRESHOLDS.growth_of_filter_width
    return most
