"""Recognise positions that a recorder averaged over rows, and average simulated ones alike: `Run`s in, rows out.

A recorder that reports the mean of N readings about each row leaves notches in the spectrum of the noise:

    S(f) = D_N(f)²·exp(a + b·f + c·f²),   D_N(f) = sin(π·N·f)/(N·sin(π·f))                    f in 1/row

with zeros at f = k/N. Motion, drifts and lags have no such zeros, and smooth spectra. A simulation has to be averaged
in the same way, or its turns are sharper than those that were recorded.

1. Divided differences of order m remove the motion; they multiply the spectrum by (2·sin(π·f))^(2m) over its mean.
   Where so few rows a period were recorded that motion is left, a run says nothing (`shows_noise`).
2. The likelihood of the periodogram I(f) after Whittle, −Σ(ln S + I/S), is compared for every N with a, b and c at
   their best. N = 1 stands for white noise and for every other filter, whose spectrum is smooth.
3. The best N counts where it beats N = 1 by far.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from haptid.measurement.signals.noise import contrasts, shows_noise
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run

ORDER = 6
"""Order of the divided differences that remove the motion before the spectrum is taken."""
WINDOWS = (3, 5, 7, 9, 11, 13, 15)
"""Numbers of rows of an average that are recognised: odd ones, which have no delay."""


def average_rows(values: Array, rows: int) -> Array:
    """Average values over some rows about each, over fewer at the ends.

    Parameters
    ----------
    values
        Shape (n_t, …); averaged along the first axis.
    rows
        Number of rows N, odd; 1 leaves the values as they are.

    Returns
    -------
    ndarray, shape (n_t, …)
        ȳ_k = Σ_{|j − k| ≤ h} y_j/(2·h + 1) with h = (N − 1)/2, and less where an end is nearer than h.
    """
    half = min(rows // 2, (len(values) - 1) // 2)
    if half == 0:
        return values
    # The first value is taken out, so that a large position does not cost digits in the sums.
    sums = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values - values[:1], axis=0)])
    k = np.arange(len(values))
    reach = np.minimum(np.minimum(half, k), len(values) - 1 - k)
    count = (2 * reach + 1).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(values[:1] + (sums[k + reach + 1] - sums[k - reach]) / count)


@lru_cache(maxsize=1)  # both the preparation of a campaign and the remarks on it ask
def averaged_rows(runs: tuple[Run, ...]) -> int:
    """Return the number of rows over which a recorder averaged the positions of some runs.

    Parameters
    ----------
    runs
        Runs of one recorder; those with uneven rows, or with too few, say nothing.

    Returns
    -------
    int
        N of `WINDOWS`; 1 where no average shows.
    """
    spectra = [found for run in runs if _is_even(run) for y in run.y.T if (found := _spectrum(y)) is not None]
    spectra = spectra[: THRESHOLDS.most_spectra_of_averaging]
    if not spectra:
        return 1
    by_window = {rows: sum(_likelihood(f, power, rows) for f, power in spectra) for rows in (1, *WINDOWS)}
    best = max(by_window, key=lambda rows: by_window[rows])
    ahead = by_window[best] - by_window[1]
    return best if ahead > THRESHOLDS.least_lead_of_average_per_spectrum * len(spectra) else 1


def with_averaging(campaign: Campaign) -> Campaign:
    """Fill in over how many rows the recorder averaged the positions, where the campaign does not state it.

    Parameters
    ----------
    campaign
        As it was read; 0 in ``Run.averaged_rows`` marks what nobody stated.

    Returns
    -------
    Campaign
        With the number that all these runs show together.
    """
    unstated = tuple(run for run in campaign.runs if run.averaged_rows == 0)
    if not unstated:
        return campaign
    rows = averaged_rows(unstated)
    runs = (run.but(averaged_rows=run.averaged_rows or rows) for run in campaign.runs)
    return campaign.but(runs=tuple(runs))


def _is_even(run: Run) -> bool:
    gaps = np.diff(run.t)
    even = float(np.ptp(gaps)) <= THRESHOLDS.largest_spread_of_even_rows * float(np.median(gaps))
    return even and run.t.size >= THRESHOLDS.least_rows_of_spectrum


def _spectrum(y: Array) -> tuple[Array, Array] | None:
    """Return frequencies [1/row] above those of motion, and the periodogram there without the differences' factor.

    None where a joint rests within a step of its encoder, or where so few rows a period were recorded that motion is
    left: the differences then say nothing of its noise.
    """
    y = y[: THRESHOLDS.most_rows_of_spectrum]
    if not shows_noise(np.arange(y.size, dtype=float), y):
        return None
    n = y.size - ORDER
    rest = contrasts(np.arange(y.size, dtype=float), y, ORDER) * np.hanning(n)
    if np.count_nonzero(np.abs(rest) > 0) < n // 2:
        return None
    every = np.fft.rfftfreq(n)
    # Every second frequency: the window correlates neighbours.
    kept = np.flatnonzero(every >= THRESHOLDS.least_frequency_of_averaging_per_row)[::2]
    f = every[kept]
    power = np.abs(np.fft.rfft(rest)[kept]) ** 2
    return np.asarray(f, dtype=float), np.asarray(power / (2.0 * np.sin(np.pi * f)) ** (2 * ORDER), dtype=float)


def _likelihood(f: Array, power: Array, rows: int) -> float:
    """Return Whittle's log likelihood of D_N²·exp(a + b·f + c·f²) at its best a, b and c, but for a constant."""
    notched = (np.sin(np.pi * rows * f) / (rows * np.sin(np.pi * f))) ** 2 + THRESHOLDS.floor_of_notch
    over = power / notched

    def loss(c: Array) -> float:
        slope = np.clip(c[0] * f + c[1] * f**2, -60.0, 60.0)
        return float(np.sum(slope) + f.size * np.log(np.mean(over * np.exp(-slope))))

    return -float(np.sum(np.log(notched))) - float(minimize(loss, np.zeros(2), method="Nelder-Mead").fun)
