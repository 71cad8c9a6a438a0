"""White sensor noise and encoder step, estimated from the data where a campaign does not state them."""

from __future__ import annotations

import numpy as np

from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run

ORDERS = (3, 4, 5, 6, 7, 8)
CUT = 3.0
KEPT = 0.9733
"""Variance of a standard normal variable cut at ±3 (its density renormalised)."""
FLOOR = 1e-9
BLOCK = 20_000
"""Rows whose weights are held at a time: 81 numbers each."""


def contrasts(t: Array, y: Array, order: int) -> Array:
    """Return combinations of ``order + 1`` neighbouring rows that no polynomial below that order reaches.

    d_i = Σ_j w_ij·y_{i+j} / √(Σ_j w_ij²) with w_ij = 1/∏_{k≠j}(t_{i+j} − t_{i+k}): a divided difference scaled so
    that white noise of standard deviation σ gives d the same σ, whether or not the rows are evenly spaced.

    Returns
    -------
    ndarray, shape (n_t - order,)
    """
    rows = np.lib.stride_tricks.sliding_window_view(t / np.median(np.diff(t)), order + 1)
    windows = np.lib.stride_tricks.sliding_window_view(y - y[0], order + 1)
    parts = [slice(first, first + BLOCK) for first in range(0, len(rows), BLOCK)]
    return np.concatenate([_contrasts(rows[part], windows[part]) for part in parts])


def _contrasts(rows: Array, windows: Array) -> Array:
    gaps = rows[:, :, None] - rows[:, None, :]
    weights = 1.0 / np.prod(gaps + np.eye(rows.shape[1]), axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    return np.asarray(np.einsum("ij,ij->i", weights, windows), dtype=np.float64)


def robust_std(values: Array) -> float:
    """Return a standard deviation that stray values do not move: 1.4826·median|v|, then cut at ±3 σ until it rests."""
    std = 1.4826 * float(np.median(np.abs(values)))
    for _ in range(20):
        kept = values[np.abs(values) <= CUT * std]
        refined = float(np.sqrt(np.mean(kept**2) / KEPT)) if kept.size else std
        if abs(refined - std) <= 1e-3 * std:
            return refined
        std = refined
    return std


def estimate_noise(t: Array, y: Array, resolution: float = 0.0) -> float:
    """Estimate the standard deviation of the white noise of a reading.

    The motion is taken out by divided differences of rising order; the lowest order is used whose estimate is within
    5 % of the smallest. What the encoder step accounts for is subtracted: σ = √(max(s² − h²/12, 0)), and never less
    than 1e-9 of the range, so that a ratio to the noise stays finite.

    Parameters
    ----------
    t, y
        Time [s] and reading [rad] or [m], shape (n_t,).
    resolution
        Encoder step h [rad] or [m].

    Notes
    -----
    Where the joint rests inside one encoder step for most of the run, the step hides the noise and the estimate
    is near 0: √(σ² + h²/12) is then h/√12. Noise of a filtered reading is not white and comes out too small.
    """
    estimates = np.array([robust_std(contrasts(t, y, order)) for order in ORDERS if y.size > 2 * order])
    least = float(estimates.min())
    lowest = float(estimates[estimates <= 1.05 * least][0])
    return float(np.sqrt(max(lowest**2 - resolution**2 / 12.0, (FLOOR * float(np.ptp(y)) + 1e-15) ** 2)))


def with_noise(run: Run) -> Run:
    """Return the run with every NaN of ``noise`` and ``resolution`` replaced by an estimate from its own rows."""
    if np.isfinite(run.noise).all() and np.isfinite(run.resolution).all():
        return run
    resolution = np.array([estimate_resolution(y) for y in run.y.T])
    resolution = np.where(np.isnan(run.resolution), resolution, run.resolution)
    noise = np.array([estimate_noise(run.t, y, h) for y, h in zip(run.y.T, resolution, strict=True)])
    return run.but(noise=np.where(np.isnan(run.noise), noise, run.noise), resolution=resolution)


def campaign_with_noise(campaign: Campaign) -> Campaign:
    """Return the campaign with noise and resolution filled in, pooled per joint by the median over its runs."""
    filled = [with_noise(run) for run in campaign.runs]
    pooled = {joint: _pool(campaign, filled, joint) for joint in {j for run in campaign.runs for j in run.free_joints}}
    runs = [
        run.but(
            noise=np.where(np.isnan(run.noise), [pooled[j][0] for j in run.free_joints], run.noise),
            resolution=np.where(np.isnan(run.resolution), [pooled[j][1] for j in run.free_joints], run.resolution),
        )
        for run in campaign.runs
    ]
    return campaign.but(runs=tuple(runs))


def _pool(campaign: Campaign, filled: list[Run], joint: int) -> tuple[float, float]:
    """Median noise and resolution of a joint over the runs that had to be estimated (all of them where none had)."""
    pairs = list(zip(campaign.runs, filled, strict=True))
    at = [(run, full, run.free_joints.index(joint)) for run, full in pairs if joint in run.free_joints]
    noise = [full.noise[i] for run, full, i in at if np.isnan(run.noise[i])] or [full.noise[i] for _, full, i in at]
    return float(np.median(noise)), float(np.median([full.resolution[i] for _, full, i in at]))
