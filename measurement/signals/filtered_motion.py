"""Motion and torque of a run through one zero-phase filter: `Run` in, `FilteredMotion` out.

The inverse dynamic model is linear in its parameters, so that it holds for filtered signals where torque and regressor
pass through the same filter (Gautier 1997). The filter is a Gaussian G of standard deviation w; G′∗y and G″∗y are the
derivatives of the filtered position. White noise of standard deviation σ at rows Δt apart leaves in the acceleration

    var(G″∗e) = 3·σ²·Δt/(8·√π·w⁵).

Noise in a regressor biases least squares towards 0 by its share of the regressor's variance. Hence `state_width` is the
smallest width at which the noise is a small enough share of the variance of the acceleration, as
`THRESHOLDS.largest_noise_share_of_acceleration` says.

Beside other regressors only the part of the acceleration counts that they do not explain. A pendulum that swings near
its resonance has q̈ ≈ −k·sin q: a small part of its acceleration tells inertia from weight, and noise that is nothing
beside the whole is much of that part. Columns and torque pass through the filter twice, hence `common_width` also keeps

    3·Σσ²·Δt/(8·√π·(√2·w)⁵)  below the same share of  Σ(G∗(G″∗y − what 1, q̇, sgn q̇, cos q and sin q explain of it))².
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from haptid.measurement.signals.averaging import average_rows
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

    @property
    def acceleration_noise_gain(self) -> float:
        """Standard deviation of the acceleration after the filter, twice, over that of white noise of the position.

        √(3·Δt/(8·√π·(√2·w)⁵)) [1/s²], with the noise's spectral density σ²·Δt and the width √2·w of both passes.
        """
        return math.sqrt(3.0 * float(self.t[1]) / (8.0 * math.sqrt(math.pi) * (math.sqrt(2.0) * self.width) ** 5))

    def with_delay(self, delay: float) -> FilteredMotion:
        """Let the torque act later than it was recorded.

        Parameters
        ----------
        delay
            Delay T [s] of either sign.

        Returns
        -------
        FilteredMotion
            With τ(t − T) for the torque; the first and the last torque go on beyond the ends.
        """
        if delay == 0.0:
            return self
        # The filtered torque is smooth over rows: a cubic spline between them takes nothing away, a line would.
        at = np.clip(self.t - delay, self.t[0], self.t[-1])
        return replace(self, torque=np.asarray(CubicSpline(self.t, self.torque)(at)))

    def through_filter(self, signal: Array) -> Array:
        """Filter a signal of the unfiltered motion, such as sgn q̇, as motion and torque were filtered.

        Parameters
        ----------
        signal
            Values at ``t``, shape (n, …).

        Returns
        -------
        ndarray
            The same shape; the signal itself for a motion of one row.
        """
        return convolve_gaussian(signal, self.width_in_rows) if self.t.size > 1 else signal

    @property
    def width_in_rows(self) -> float:
        """Standard deviation of the filter [rows]."""
        return self.width / float(self.t[1])


def state_width(runs: Sequence[Run]) -> float:
    """Choose the filter that positions, speeds and accelerations of a machine are read with.

    Parameters
    ----------
    runs
        Runs of one configuration.

    Returns
    -------
    float
        Standard deviation of the filter [s]: the largest width that one of the runs asks for.
    """
    return max(_width_of(run) for run in runs)


def common_width(runs: Sequence[Run]) -> float:
    """Choose the filter of the torques of a machine.

    Parameters
    ----------
    runs
        Runs of one configuration.

    Returns
    -------
    float
        Standard deviation of the filter [s]: at least `state_width`, and so wide that noise is a small enough share of
        what tells a joint's inertia from the rest of its torque, in all fitted runs together.
    """
    width = state_width(runs)
    fitted = [run for run in runs if run.use == "fit"] or list(runs)
    signals = [_Positions.of(run) for run in fitted]
    most = min(one.largest_width for one in signals)
    while width < most and _noise_share_of_inertia(signals, width) > THRESHOLDS.largest_noise_share_of_acceleration:
        width *= THRESHOLDS.growth_of_filter_width
    return width


@dataclass(frozen=True, slots=True)
class _Positions:
    """Positions of a run on an even grid, with the standard deviation of their noise."""

    t: Array
    y: Array
    noise: Array
    prismatic: tuple[bool, ...]

    @classmethod
    def of(cls, run: Run) -> _Positions:
        t = np.linspace(0.0, float(run.t[-1]), run.t.size)
        return cls(t, _columns(t, run.t, run.y), _noise(run), tuple(run.prismatic))

    @property
    def largest_width(self) -> float:
        """Largest width [s] that leaves the motion of every joint."""
        shortest = min(dominant_period(self.t, y) for y in self.y.T)
        return THRESHOLDS.largest_filter_width_over_period * shortest


def _noise_share_of_inertia(runs: Sequence[_Positions], width: float) -> float:
    """Return the share of noise in what the other columns leave of the acceleration, largest over the joints."""
    return max(_noise_share(runs, k, width) for k in range(runs[0].y.shape[1]))


def _noise_share(runs: Sequence[_Positions], k: int, width: float) -> float:
    columns, accelerations, noise = [], [], 0.0
    for run in runs:
        dt = float(run.t[1])
        rows = max(width / dt, THRESHOLDS.least_smoothing_width_rows)
        q, v, a = (convolve_gaussian(run.y[:, k], rows, order) / dt**order for order in range(3))
        others = [np.ones_like(q), v, np.sign(v)]
        if not run.prismatic[k]:
            others += [np.cos(q), np.sin(q)]
        # At its ends a run seems to stop at once, which is an acceleration of the filter alone.
        edge = _edge_rows(q.size, rows)
        inside = slice(edge, q.size - edge)
        columns.append(convolve_gaussian(np.column_stack(others), rows)[inside])
        accelerations.append(convolve_gaussian(a, rows)[inside])
        variance = 3.0 * run.noise[k] ** 2 * dt / (8.0 * math.sqrt(math.pi) * (math.sqrt(2.0) * rows * dt) ** 5)
        noise += variance * accelerations[-1].size
    W, a = np.concatenate(columns), np.concatenate(accelerations)
    own = a - W @ np.linalg.lstsq(W, a, rcond=None)[0]
    return noise / max(float(own @ own), np.finfo(float).tiny)


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
    edge = _edge_rows(n, rows)
    first = int(np.searchsorted(t, run.t[run.score_from]))
    # Where the recorder averaged the positions over rows, the torque is averaged alike.
    return FilteredMotion(
        t=t,
        q=convolve_gaussian(y, rows),
        v=convolve_gaussian(y, rows, 1) / dt,
        a=convolve_gaussian(y, rows, 2) / dt**2,
        torque=convolve_gaussian(average_rows(_torque(run, t), run.averaged_rows), rows),
        width=width,
        edge=edge,
        interior=slice(max(first, edge), n - edge),
    )


def _edge_rows(n: int, rows: float) -> int:
    """Return the rows at either end that the filter has no full surroundings for.

    What is computed along the filtered motion passes through the filter once more, so that its reach counts twice.
    """
    return min(math.ceil(2.0 * THRESHOLDS.filter_reach_in_widths * rows), (n - 1) // 4)


def _width_of(run: Run) -> float:
    t = np.linspace(0.0, float(run.t[-1]), run.t.size)
    y = _columns(t, run.t, run.y)
    return max(_width(t, y[:, k], float(std)) for k, std in enumerate(_noise(run)))


def _noise(run: Run) -> Array:
    """Return the standard deviation of the readings: the stated one, or that of neighbouring rows where it is larger.

    A reading that was filtered or re-sampled before it was stored has less noise between neighbouring rows than it has.
    """
    seen = [estimate_noise(run.t, y, averaged_rows=run.averaged_rows) for y in run.y.T]
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
