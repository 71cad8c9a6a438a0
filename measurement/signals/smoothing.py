"""Smooth position, speed, acceleration and torque of a measured joint by one Gaussian: `Run` in, `Motion` out.

With G a Gaussian, G′∗y and G″∗y are the exact derivatives of the smoothed position G∗y, and G∗τ is smoothed alike.
Hence an equation that is linear in the raw signals holds for the smoothed ones, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import gaussian_filter1d

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run

GAUSSIAN_CUT_IN_WIDTHS = 8.0
"""Distance from its middle at which a Gaussian is cut [standard deviations]."""
ROWS_OF_A_BLOCK = 32
"""Rows that are filtered together."""


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
    columns = np.asarray(signal, dtype=np.float64).reshape(len(signal), -1)
    n, width = columns.shape
    band = _gaussian_band(float(rows), order)
    block, seen = band.shape
    blocks, reach = -(-n // block), (seen - block) // 2
    padded = np.empty((blocks * block + 2 * reach, width))
    padded[:reach], padded[reach : reach + n], padded[reach + n :] = columns[0], columns, columns[-1]
    # Many columns at once: a banded matrix times overlapping blocks of rows is several times as fast as row by row.
    overlapping = sliding_window_view(padded.ravel(), seen * width)[:: block * width].reshape(blocks, seen, width)
    filtered = (band @ overlapping).reshape(blocks * block, width)[:n]
    return np.ascontiguousarray(filtered).reshape(np.shape(signal))


@lru_cache(maxsize=64)
def _gaussian_band(rows: float, order: int) -> Array:
    """Return the matrix from a block of rows and its neighbours to the filtered block, shape (n_block, n_seen)."""
    weights = _gaussian_weights(rows, order)
    around = np.pad(weights, ROWS_OF_A_BLOCK - 1)
    band = sliding_window_view(around, ROWS_OF_A_BLOCK + len(weights) - 1)[::-1][:ROWS_OF_A_BLOCK]
    return np.ascontiguousarray(band)


def _gaussian_weights(rows: float, order: int) -> Array:
    """Return the weights of a Gaussian or its derivative, shape (2·reach + 1,)."""
    # Cut at 4σ, as by default, G″ would not have the sum 0.
    reach = int(GAUSSIAN_CUT_IN_WIDTHS * rows + 0.5)
    impulse = np.zeros(4 * reach + 1)
    impulse[2 * reach] = 1.0
    response = gaussian_filter1d(impulse, rows, order=order, mode="constant", truncate=GAUSSIAN_CUT_IN_WIDTHS)
    # Filtering is a convolution, its matrix a correlation: the weights run backwards.
    return np.ascontiguousarray(response[reach : 3 * reach + 1][::-1])
