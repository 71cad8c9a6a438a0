"""Estimate how a joint's speed follows its torque at each frequency: `Run`s in, `FrequencyResponse` out.

H(ω) = S_uv(ω)/S_uu(ω), averaged over segments of all runs (Welch 1967; the H₁ estimate of Bendat and Piersol, Random
Data, ch. 6). It needs no model, and so shows a resonance to anyone who has no first guess of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrequencyResponse:
    """Response of the speed to the torque at the frequencies that the runs excite.

    Parameters
    ----------
    omega
        Angular frequencies [rad/s], shape (n,), ascending, above 0.
    mobility
        Speed over torque [rad/(s N m)] ([m/(s N)]), shape (n,).
    relative_error
        Standard deviation of the real and of the imaginary part of log H [1], shape (n,).
    """

    omega: Array
    mobility: ComplexArray
    relative_error: Array


def measure_response(runs: Sequence[Run]) -> FrequencyResponse | None:
    """Estimate the response of one joint's speed to its torque.

    Parameters
    ----------
    runs
        Runs of this joint alone.

    Returns
    -------
    FrequencyResponse or None
        At the frequencies where torque was given and the speed follows it; None where the runs are too short for any.

    Notes
    -----
    The speed is (y_{k+1} − y_k)/T. Of a joint with response G from torque to position and torque held over T, it has
    the response jω·G·sin²(ωT/2)/(ωT/2)² to the torque at row k, and exp(jωT/2) times it where the torque runs linearly;
    both factors are taken out. The error of log H is √((1 − γ²)/(2γ²·n)) with coherence γ² over n segments, and at
    least `least_error_of_response`: friction makes the response depend on the torque's size, whatever the coherence.
    """
    limits = THRESHOLDS.resonance
    period = min(float(np.median(np.diff(run.t))) for run in runs)
    rows = int(min(run.t[-1] for run in runs) / period) // limits.segments_of_run
    if rows < limits.least_rows_of_segment:
        return None
    omega = np.asarray(2 * np.pi * np.fft.rfftfreq(rows, period), dtype=np.float64)
    torque, speed = np.zeros(omega.size), np.zeros(omega.size)
    both = np.zeros(omega.size, dtype=np.complex128)
    segments = 0
    for run in runs:
        u, v = _on_even_rows(run, period)
        spectra = {"fs": 1.0 / period, "nperseg": rows}
        torque += signal.csd(u, u, **spectra)[1].real
        speed += signal.csd(v, v, **spectra)[1].real
        both += signal.csd(u, v, **spectra)[1] / _sampling(omega * period, run)
        segments += 2 * (u.size // rows) - 1
    power = torque * speed
    coherence = np.divide(np.abs(both) ** 2, power, out=np.zeros(omega.size), where=power > 0.0)
    # The mean is taken from every segment, and the window spreads what is left of it over the first frequencies.
    shown = np.arange(omega.size) >= limits.first_frequency
    shown &= omega * period < limits.largest_phase_of_row
    shown &= (coherence > limits.least_coherence) & (torque > limits.least_share_of_power * torque.max(initial=0.0))
    if not shown.any():
        return None
    seen = np.minimum(coherence[shown], 1.0)
    error = np.hypot(np.sqrt((1.0 - seen) / (2.0 * seen * segments)), limits.least_error_of_response)
    return FrequencyResponse(omega=omega[shown], mobility=both[shown] / torque[shown], relative_error=error)


def _on_even_rows(run: Run, period: float) -> tuple[Array, Array]:
    """Return torque and mean speed between rows at even times, shape (n,) each."""
    t = np.arange(0.0, run.t[-1], period)
    y = np.interp(t, run.t, run.y[:, 0])
    if run.hold == "linear":
        u = np.interp(t, run.t, run.u[:, 0])
    else:
        u = run.u[np.searchsorted(run.t, t, side="right") - 1, 0]
    return u[:-1], np.diff(y) / period


def _sampling(phase: Array, run: Run) -> ComplexArray:
    """Return what rows at even times multiply the response of the speed by, shape (n,)."""
    half = np.sinc(phase / (2 * np.pi))
    whole = half**2 if run.hold == "zero" else half * np.exp(0.5j * phase)
    return np.asarray(whole, dtype=np.complex128)
