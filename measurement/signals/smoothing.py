"""Smooth position, speed, acceleration and torque of a measured joint by one Gaussian: `Run` in, `Motion` out.

With G a Gaussian, G′∗y and G″∗y are the exact derivatives of the smoothed position G∗y, and G∗τ is smoothed alike.
Hence an equation that is linear in the raw signals holds for the smoothed ones, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Hold the smoothed signals of one joint on an even grid.

    Parameters
    ----------
    t
        Time [s], shape (n,), evenly spaced from 0.
    q, v, a
        Position [rad], speed [rad/s] and acceleration [rad/s²] ([m], [m/s], [m/s²]), each of shape (n,).
    torque
        Commanded torque [N m] ([N]), shape (n,).
    """

    t: Array
    q: Array
    v: Array
    a: Array
    torque: Array


def dominant_period(t: Array, y: Array) -> float:
    """Return the period of the strongest line in the spectrum of a position.

    Parameters
    ----------
    t, y
        Time [s] from 0 and position in any unit, shape (n_t,); the rows may be unevenly spaced.

    Returns
    -------
    float
        Period [s], a whole fraction of the length of the run.
    """
    even = np.linspace(0.0, t[-1], t.size)
    centred = np.interp(even, t, y) - np.mean(y)
    spectrum = np.abs(np.fft.rfft(centred * np.hanning(t.size)))
    return float(t[-1] / max(1 + int(np.argmax(spectrum[1:])), 1))


def smooth(run: Run, column: int = 0, *, width: float | None = None) -> Motion:
    """Smooth one joint of a run by a Gaussian, and differentiate by that Gaussian's derivatives.

    Parameters
    ----------
    run
        Run of any use.
    column
        Column of the joint among ``run.free_joints``.
    width
        Standard deviation of the Gaussian [s]; None for 1/60 of the motion's dominant period, at least 2 rows.

    Returns
    -------
    Motion
        On an even grid of as many points as the run has rows.
    """
    n = run.t.size
    t = np.linspace(0.0, run.t[-1], n)
    y, u = (np.interp(t, run.t, signal[:, column]) for signal in (run.y, run.u))
    dt = float(t[1])
    if width is None:
        width = THRESHOLDS.smoothing_width_over_period * dominant_period(run.t, y)
    sigma = max(width / dt, THRESHOLDS.least_smoothing_width_rows)
    return Motion(
        t=t,
        q=convolve_gaussian(y, sigma),
        v=convolve_gaussian(y, sigma, 1) / dt,
        a=convolve_gaussian(y, sigma, 2) / dt**2,
        torque=convolve_gaussian(u, sigma),
    )


def convolve_gaussian(signal: Array, rows: float, order: int = 0) -> Array:
    """Convolve a signal with a Gaussian or one of its derivatives.

    Parameters
    ----------
    signal
        Shape (n, …), filtered along its first axis.
    rows
        Standard deviation of the Gaussian [rows].
    order
        Order of the derivative by the row.

    Returns
    -------
    ndarray
        The same shape.
    """
    # Cut at 4σ, as by default, G″ would not have the sum 0.
    return np.asarray(gaussian_filter1d(signal, rows, order=order, axis=0, mode="nearest", truncate=8.0))
