"""Pictures of what a fit leaves: `Trace`s in; autocorrelation and spectrum out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import periodogram

from haptid.identification.output.traces import Trace
from haptid.identification.statistics.covariance import autocovariance
from haptid.measurement.values.run import Array
from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import HALF_WIDTH_95
from haptid.report.common.page import Picture
from haptid.report.common.style import ACCENT, MEASURED, SIMULATED, figure, style

LONGEST_LAG = 0.1
"""Longest lag of the autocorrelation over the length of a run [1]."""
BANDS_OF_SPECTRUM = 160
"""Bands over which the spectrum is averaged, evenly spaced in the logarithm of the frequency."""
LEAST_POWER = 1e-3
"""Least power over that of the noise that is drawn [1]: a filtered residual has next to none at high frequencies."""
LOOKS = ((SIMULATED, "-"), (ACCENT, "--"), (MEASURED, ":"))
"""Colour and line of the first curves; more runs take them again."""


def correlation_picture(traces: Sequence[Trace], title: str) -> Picture:
    """Draw autocorrelation and spectrum of the residuals, those of white noise beside them.

    Parameters
    ----------
    traces
        Signals of runs of the same joints; the first joint counts.
    title
        Name of the configuration.

    Returns
    -------
    Picture
    """
    caption = (
        f"{title}: autocorrelation of the residual over its variance, white within the dashed lines (95 %), and "
        "spectrum over that of white noise with the sensor's standard deviation. What stands above 1 is more than the "
        "sensor's noise."
    )
    return picture_of(correlation_figure(traces), caption=caption, alt=f"{title}, correlation of the residuals")


def correlation_figure(traces: Sequence[Trace]) -> Figure:
    """Draw autocorrelation and spectrum of the residuals.

    Parameters
    ----------
    traces
        As `correlation_picture` takes them.

    Returns
    -------
    Figure
        Autocorrelation over lag at the left, spectrum over frequency at the right, one curve a run.
    """
    with style():
        made = figure(8.5, 3.0)
        left, right = made.subplots(1, 2)
        rows = min(trace.t.size for trace in traces)
        for k, trace in enumerate(traces):
            colour, line = LOOKS[k % len(LOOKS)]
            label = f"{trace.score.file} ({trace.score.use})"
            lag, correlation = autocorrelation_of(trace)
            left.plot(lag, correlation, color=colour, ls=line, lw=0.9, label=label)
            frequency, power = spectrum_of(trace)
            right.plot(frequency, power, color=colour, ls=line, lw=0.9, label=label)
        for end in (-HALF_WIDTH_95, HALF_WIDTH_95):
            left.axhline(end / rows**0.5, color=MEASURED, lw=0.6, ls="--")
        left.set_xlabel("lag [s]")
        left.set_ylabel("autocorrelation [1]")
        right.axhline(1.0, color=MEASURED, lw=0.6, ls="--")
        right.set_xscale("log")
        right.set_yscale("log")
        right.set_xlabel("frequency [Hz]")
        right.set_ylabel("spectrum / noise [1]")
        right.legend(fontsize=6)
    return made


def _scored_residual(trace: Trace) -> tuple[Array, float]:
    """Return the residual of the first joint over its noise on the scored rows, and the time between rows [s]."""
    scored = trace.t >= trace.scored_from
    r = (trace.measured - trace.simulated)[scored, 0] / trace.sigma[0]
    return np.nan_to_num(r), float(np.median(np.diff(trace.t)))


def autocorrelation_of(trace: Trace) -> tuple[Array, Array]:
    """Compute the autocorrelation of a residual.

    Parameters
    ----------
    trace
        Signals of a run.

    Returns
    -------
    lag, correlation : ndarray, shape (n_lags,) each
        Lags [s] from one row on, and c(lag)/c(0) [1].
    """
    r, step = _scored_residual(trace)
    longest = max(int(LONGEST_LAG * r.size), 1)
    c = autocovariance((r[:, None],), longest)
    lag: Array = step * np.arange(1, longest + 1, dtype=float)
    return lag, np.asarray(c[1:] / (c[0] or 1.0), dtype=float)


def spectrum_of(trace: Trace) -> tuple[Array, Array]:
    """Compute the spectrum of a residual over that of the sensor's white noise.

    Parameters
    ----------
    trace
        Signals of a run.

    Returns
    -------
    frequency, power : ndarray, shape (n_bands,) each
        Middle of each band [Hz], and the mean of the periodogram there over that of white noise [1].
    """
    r, step = _scored_residual(trace)
    frequency, power = periodogram(r, fs=1.0 / step, detrend=False)
    frequency, power = frequency[1:], power[1:] / (2.0 * step)
    edges = np.geomspace(frequency[0], frequency[-1] * (1 + 1e-9), BANDS_OF_SPECTRUM + 1)
    band = np.digitize(frequency, edges)
    own = np.unique(band)
    middles = np.array([frequency[band == b].mean() for b in own])
    means = np.array([power[band == b].mean() for b in own])
    return middles, np.asarray(np.maximum(means, LEAST_POWER))
