"""Estimate white sensor noise from readings: `Run` in, `Run` with its ``noise`` and ``resolution`` filled in out.

1. Divided differences of orders 3 to 8 remove the motion and keep the standard deviation of white noise (`contrasts`).
2. A robust standard deviation of each order ignores stray readings (`robust_std`).
3. The lowest order whose estimate is within 5 % of the smallest gives the noise (`estimate_noise`).
4. Readings that a low-pass filter smoothed hold next to no noise from row to row; then rows farther apart give it
   (`_behind_filter`).
5. Noise that a campaign leaves open is pooled per joint by the median over its runs (`campaign_with_noise`).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run

DIFFERENCE_ORDERS = (3, 4, 5, 6, 7, 8)
"""Orders of the divided differences that are tried, ascending."""
ORDER_OF_NOISE = 4
"""Order of the divided differences in which noise is compared or looked at by frequency."""
VARIANCE_OF_CUT_NORMAL = 0.9733
"""Variance of a standard normal variable cut at ±3 (its density renormalised), which is where `THRESHOLDS` cuts it."""
ROWS_PER_BLOCK = 20_000
"""Rows whose gaps are held at a time: 81 numbers each."""
LARGEST_UNEVENNESS = 1e-10
"""Range of the intervals between rows over their median [1] up to which all have the same weights: what rounding makes
of the times of an even clock, a thousand seconds of milliseconds."""
CLOCKS_KEPT = 4
"""Clocks whose weights are kept for the next run."""


def contrasts(t: Array, y: Array, order: int) -> Array:
    """Remove the motion from a signal by divided differences that keep the standard deviation of white noise.

    Parameters
    ----------
    t
        Time [s], shape (n_t,), strictly increasing; the rows need not be evenly spaced.
    y
        Signal in any unit, shape (n_t,).
    order
        Order of the divided differences. Polynomials of a lower degree give 0.

    Returns
    -------
    ndarray, shape (n_t - order,)
        Contrasts in the unit of ``y``. Neighbours share rows, so they are correlated.

    Notes
    -----
    d_i = Σ_j w_ij·y_{i+j} / √(Σ_j w_ij²) with w_ij = 1/∏_{k≠j}(t_{i+j} − t_{i+k}), j = 0..order. Since the weights
    have norm 1, white noise of standard deviation σ gives d the standard deviation σ.
    """
    # A constant in y changes nothing; it is taken out, so that a large position does not cost digits.
    windows = np.lib.stride_tricks.sliding_window_view(y - y[0], order + 1)
    clock = np.ascontiguousarray(t, dtype=np.float64).tobytes()
    return np.asarray(np.einsum("ij,ij->i", _weights(clock, order), windows), dtype=np.float64)


@lru_cache(maxsize=CLOCKS_KEPT * len(DIFFERENCE_ORDERS))
def _weights(clock: bytes, order: int) -> Array:
    """Compute the weights of `contrasts` from the bytes of the time; runs of a campaign often share their clock."""
    t = np.frombuffer(clock)
    gaps = np.diff(t)
    if np.ptp(gaps) <= LARGEST_UNEVENNESS * np.median(gaps):
        even = np.arange(order + 1.0)[None]
        return np.broadcast_to(_weights_of(even), (t.size - order, order + 1))
    # The unit of t changes nothing; it is taken out, so that products of gaps stay near 1.
    rows = np.lib.stride_tricks.sliding_window_view(t / np.median(gaps), order + 1)
    parts = [slice(first, first + ROWS_PER_BLOCK) for first in range(0, len(rows), ROWS_PER_BLOCK)]
    return np.concatenate([_weights_of(rows[part]) for part in parts])


def _weights_of(rows: Array) -> Array:
    gaps = rows[:, :, None] - rows[:, None, :]
    # The identity turns the factor k = j, which is 0, into 1.
    weights = 1.0 / np.prod(gaps + np.eye(rows.shape[1]), axis=2)
    return np.asarray(weights / np.linalg.norm(weights, axis=1, keepdims=True))


def shows_noise(t: Array, y: Array) -> bool:
    """Say whether divided differences leave noise of a signal, and not motion.

    Parameters
    ----------
    t
        Time [s], shape (n_t,), strictly increasing.
    y
        Signal in any unit, shape (n_t,).

    Returns
    -------
    bool
        False where the highest order leaves clearly less than order `ORDER_OF_NOISE`. Noise keeps its standard
        deviation in every order. A motion of f periods a row is multiplied by (2·sin πf)^k/√(2k choose k) in order k:
        with six rows a period, order 4 leaves a tenth of it, far more than noise, and order 8 a hundred and fiftieth.
    """
    low, high = (robust_std(contrasts(t, y, order)) for order in (ORDER_OF_NOISE, DIFFERENCE_ORDERS[-1]))
    return high >= THRESHOLDS.least_noise_in_higher_order * low


def write_estimated_noise(noise: float, step: float) -> str:
    """Write an estimated noise; where readings rest on the encoder's levels and show none, the step's error above it.

    Parameters
    ----------
    noise
        Standard deviation of the noise, in any unit.
    step
        Encoder step in the same unit; 0 where there is none.

    Returns
    -------
    str
        Two digits.

    Examples
    --------
    >>> write_estimated_noise(2.04e-4, 1e-4), write_estimated_noise(7e-10, 1.5e-3)
    ('0.0002', '<0.00043')
    """
    rounding = step / 12.0**0.5
    below = noise < rounding / THRESHOLDS.largest_stated_over_estimated_noise
    return f"<{rounding:.2g}" if below else f"{noise:.2g}"


def robust_std(values: Array) -> float:
    """Estimate the standard deviation of zero-mean values of which a few may be stray.

    Parameters
    ----------
    values
        Shape (n,), n ≥ 1, with mean 0.

    Returns
    -------
    float
        In the unit of ``values``.

    Notes
    -----
    Starts from 1.4826·median|v|, the standard deviation of a normal variable with that median. Then the values beyond
    ±3σ are dropped and σ² becomes the mean square of the others over 0.9733, the variance of a standard normal
    variable cut at ±3, until σ changes by less than 0.1 % (at most 20 times).
    """
    std = 1.4826 * float(np.median(np.abs(values)))
    for _ in range(20):
        kept = values[np.abs(values) <= THRESHOLDS.stray_contrast_in_std * std]
        refined = float(np.sqrt(np.mean(kept**2) / VARIANCE_OF_CUT_NORMAL)) if kept.size else std
        if abs(refined - std) <= 1e-3 * std:
            return refined
        std = refined
    return std


def share_kept_of_average(order: int, rows: int) -> float:
    """Return what divided differences show of the noise of positions that are averages over rows.

    Parameters
    ----------
    order
        Order m of the differences, of evenly spaced rows.
    rows
        Number of rows N of the average; 0 and 1 are none.

    Returns
    -------
    float
        Standard deviation of the contrasts over that of a reading, √N·‖w ∗ 1_N/N‖ with the weights w of norm 1 of a
        difference: 1 without an average, less with one, for neighbouring averages share rows.
    """
    difference = np.array([1.0])
    for _ in range(order):
        difference = np.convolve(difference, [1.0, -1.0])
    window = np.ones(max(rows, 1))
    norms = np.linalg.norm(np.convolve(difference, window)) / np.linalg.norm(difference)
    return float(norms / np.sqrt(window.size))


def estimate_noise(t: Array, y: Array, resolution: float = 0.0, averaged_rows: int = 1) -> float:
    """Estimate the standard deviation of the white noise of a reading.

    Parameters
    ----------
    t, y
        Time [s] and reading [rad] or [m], shape (n_t,), with at least 7 rows.
    resolution
        Encoder step h [rad] or [m].
    averaged_rows
        Number of rows over which the recorder averaged the readings.

    Returns
    -------
    float
        Standard deviation σ of the noise without that of the encoder step [rad] or [m], above 0.

    Notes
    -----
    Divided differences of rising order (`contrasts`) remove the motion. With s the robust standard deviation of the
    lowest order that is within 5 % of the smallest, σ = √(max(s² − h²/12, (1e-9·range)²)). The floor keeps ratios to
    the noise finite.

    Where the joint rests inside one encoder step for most of the run, the step hides the noise and the estimate
    is near 0: √(σ² + h²/12) is then h/√12. The noise of an average over rows is corrected by `share_kept_of_average`;
    behind a low-pass filter, every k-th row is looked at until s grows more slowly than k.
    """
    noise = _from_differences(t, y, averaged_rows=averaged_rows)
    if averaged_rows <= 1:
        noise = _behind_filter(t, y, noise)
    least = THRESHOLDS.least_noise_over_range * float(np.ptp(y)) + 1e-15
    return float(np.sqrt(max(noise**2 - resolution**2 / 12.0, least**2)))


def _from_differences(t: Array, y: Array, *, averaged_rows: int = 1, stride: int = 1) -> float:
    """Return the robust standard deviation of the lowest order of differences that removes the motion.

    The differences are of every ``stride``-th row, over all rows to begin with.
    """
    estimates = []
    for order in (order for order in DIFFERENCE_ORDERS if y.size // stride > 2 * order):
        values = np.concatenate([contrasts(t[k::stride], y[k::stride], order) for k in range(stride)])
        estimates.append(robust_std(values) / share_kept_of_average(order, averaged_rows))
    # Higher orders remove more motion but average over fewer independent rows: the lowest sufficient one is used.
    return next(one for one in estimates if one <= 1.05 * min(estimates))


def _behind_filter(t: Array, y: Array, noise: float) -> float:
    """Return the noise of readings that a low-pass filter smoothed; ``noise`` as given where none shows.

    Neighbouring rows behind a filter share their noise, so that their differences show the digits of the file at most.
    Of every k-th row the differences grow with k, faster than k, until the rows are farther apart than the filter's
    memory; there they show the noise. They grow again where the motion shows.
    """
    if y.size // 2 < THRESHOLDS.least_rows_of_noise_estimate:
        return noise
    stride, before = 2, _from_differences(t, y, stride=2)
    if before <= THRESHOLDS.least_rise_behind_filter * noise:  # both are 0 where nothing moves
        return noise
    while y.size // stride >= THRESHOLDS.least_rows_of_noise_estimate:
        wider = max(stride + 1, round(THRESHOLDS.growth_of_stride * stride))
        now = _from_differences(t, y, stride=wider)
        if now > THRESHOLDS.largest_noise_behind_filter_over_range * float(np.ptp(y)):
            return noise
        if now / before < wider / stride:
            return before
        stride, before = wider, now
    return noise


def with_noise(run: Run) -> Run:
    """Return the run with every NaN of ``noise`` and ``resolution`` replaced by an estimate from its own rows.

    Stated values are kept; a stated encoder step also enters the estimate of the noise.

    Parameters
    ----------
    run
        NaN in ``noise`` and ``resolution``, shape (n_joints,), marks a value that nobody stated.

    Returns
    -------
    Run
        With finite ``noise`` and ``resolution`` [rad] ([m]); the run itself where all are stated.
    """
    if np.isfinite(run.noise).all() and np.isfinite(run.resolution).all():
        return run
    resolution = np.array([estimate_resolution(y) for y in run.y.T])
    resolution = np.where(np.isnan(run.resolution), resolution, run.resolution)
    rows = run.averaged_rows
    noise = np.array([estimate_noise(run.t, y, h, rows) for y, h in zip(run.y.T, resolution, strict=True)])
    return run.but(noise=np.where(np.isnan(run.noise), noise, run.noise), resolution=resolution)


def campaign_with_noise(campaign: Campaign) -> Campaign:
    """Fill in the noise and the resolution that a campaign leaves open.

    Parameters
    ----------
    campaign
        As it was read; NaN in ``Run.noise`` and ``Run.resolution`` marks a value that nobody stated.

    Returns
    -------
    Campaign
        Each NaN is the median of the estimates over the runs that free the joint. Stated values stay.
    """
    filled = [with_noise(run) for run in campaign.runs]
    tested: set[int] = set()
    for run in campaign.runs:
        tested.update(run.free_joints)
    pooled = {joint: _pool(campaign, filled, joint) for joint in tested}
    runs = []
    for run in campaign.runs:
        noise, resolution = np.array([pooled[joint] for joint in run.free_joints]).T
        noise = np.where(np.isnan(run.noise), noise, run.noise)
        resolution = np.where(np.isnan(run.resolution), resolution, run.resolution)
        runs.append(run.but(noise=noise, resolution=resolution))
    return campaign.but(runs=tuple(runs))


def _pool(campaign: Campaign, filled: list[Run], joint: int) -> tuple[float, float]:
    """Median noise and resolution of a joint over the runs that had to be estimated (all of them where none had)."""
    pairs = list(zip(campaign.runs, filled, strict=True))
    at = [(run, full, run.free_joints.index(joint)) for run, full in pairs if joint in run.free_joints]
    noise = [full.noise[i] for run, full, i in at if np.isnan(run.noise[i])] or [full.noise[i] for _, full, i in at]
    return float(np.median(noise)), float(np.median([full.resolution[i] for _, full, i in at]))
