"""Delay between the recorded torque and the motion: filtered columns and torques of runs in, `Delay` or None out.

A drive reports torque and position at different ages. The torque that acts at t is the one recorded at t − T, as for
the catalogue's ``time_delay``; T is negative where the torque is reported later than the motion. By variable projection
(Golub and Pereyra 1973) T minimises the weighted cost of the plain model,

    C(T) = min_θ Σ w²·(τ(t − T) − W·θ)²,

1. within `bracket` on either side, a tenth of the time in which the speed changes by its own size;
2. beside columns of what a delay is easily taken for: a spring, dry friction that turns later than the speed, as
   presliding lets it turn, and dry friction that falls with speed;
3. with the covariance of blocks, ∂τ/∂T as one more column, and with the change of T by one more filter on columns and
   torque: a delay is the same for slow and fast parts, while a backlash or what a controller makes of the encoder's
   noise is not. Of both the one with the smaller standard error is taken;
4. under a position controller with the change by a filter as wide as the bracket as well: what the plain model lacks
   (ripple, a Stribeck curve) moves the joint, and the controller answers late; only the slow parts are those that its
   reference asks for.

The delay earns its place as an effect does in the search for missing ones: it is
`THRESHOLDS.least_delay_in_standard_errors` from 0, lies inside its bracket, and blocks that are held out are predicted
better by the others with it than without it, by more than the standard error over the blocks. Otherwise there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from haptid.identification.baseline.least_squares import block_covariance, blocks_of, independent_columns
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.filtered_motion import FilteredMotion
from haptid.measurement.signals.smoothing import convolve_gaussian
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import column_rms, rms


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay:
    """A delay that earned its place.

    Parameters
    ----------
    value, std
        Delay T and its standard deviation [s].
    rows
        The same delay in rows of the runs [1].
    held_out_gain
        Share of the plain model's energy on held-out blocks that it takes away [1].
    """

    value: float
    std: float
    rows: float
    held_out_gain: float

    def as_json(self) -> dict[str, float | str]:
        """Return ``baseline.delay`` of identification.json.

        Returns
        -------
        dict
            ``value`` and ``std`` in ``unit``, ``rows``, and ``held_out_gain``.
        """
        return {
            "value": self.value,
            "std": self.std,
            "unit": "s",
            "rows": self.rows,
            "held_out_gain": self.held_out_gain,
        }


@dataclass(frozen=True, slots=True)
class _Rows:
    """Rows of one run that are fitted: times and torque before the cut, columns after it."""

    t: Array
    torque: CubicSpline
    columns: Array
    moving: Array

    def torque_at(self, delay: float, order: int = 0) -> Array:
        """Return τ(t − T), or its derivative of an order by time, shape (n, n_joints)."""
        at = np.clip(self.t - delay, self.torque.x[0], self.torque.x[-1])
        return np.asarray(self.torque(at, order)) * self.moving

    def columns_with_slope(self, delay: float) -> Array:
        """Return the columns and what a longer delay takes from the torque, shape (n, n_joints, n_columns + 1)."""
        return np.concatenate([self.columns, self.torque_at(delay, 1)[:, :, None]], axis=2)


@dataclass(frozen=True, slots=True)
class _Gain:
    """Decrease of the energy of held-out blocks by a delay: as a share, and in its standard errors over the blocks."""

    share: float
    errors: float

    @property
    def is_clear(self) -> bool:
        return self.errors > THRESHOLDS.least_gain_of_delay_in_standard_errors


def estimate_delay(
    motions: Sequence[FilteredMotion],
    columns: Sequence[Array],
    moving: Sequence[NDArray[np.bool_]],
    *,
    controlled: bool = False,
) -> Delay | None:
    """Estimate the delay of the torque behind which the plain model explains it best.

    Parameters
    ----------
    motions
        Filtered motions of the fitted runs.
    columns
        Columns of the plain model along each motion after both passes of the filter, shape (n_t, n_joints, n_ids).
    moving
        Whether each row of each joint counts, shape (n_t, n_joints).
    controlled
        Whether a position controller makes the torque.

    Returns
    -------
    Delay or None
        None where no delay earns its place, as where no torque changes.
    """
    if not any(np.any(np.ptp(motion.torque, axis=0) > 0) for motion in motions):
        return None
    limit = bracket(motions)
    runs = list(zip(motions, columns, moving, strict=True))
    found = _fit_delay([_rows_of(*run, 0.0) for run in runs], limit)
    if abs(found.delay) > THRESHOLDS.largest_delay_over_bracket * limit:
        return None
    # A delay is the same for slow and fast parts of a torque; what else shifts them is not known better than this.
    widths = [THRESHOLDS.width_of_slower_delay_over_filter]
    if controlled:
        rows_of_bracket = limit / float(np.median([one.t[1] - one.t[0] for one in motions]))
        widths.append(rows_of_bracket / max(one.width_in_rows for one in motions))
    slower = [_fit_delay([_rows_of(*run, width) for run in runs], limit) for width in widths]
    # Noise of the encoder is in the fast parts of the acceleration, and biases a delay that is read from them.
    best = min((found, slower[0]), key=lambda fit: fit.std)
    delay, std = best.delay, float(np.hypot(best.std, max(abs(one.delay - found.delay) for one in slower)))
    if not abs(delay) > THRESHOLDS.least_delay_in_standard_errors * std:
        return None
    counts = blocks_of(found.residuals)
    # The delay is to help the plain model itself as well, not only one that has what the delay is taken for.
    n_plain = columns[0].shape[2]
    plain = [replace(one, columns=one.columns[:, :, found.kept[:n_plain].nonzero()[0]]) for one in found.rows]
    gains = [_gain(some, found.weights, delay, counts) for some in (found.rows, plain)]
    if not all(gain.is_clear for gain in gains):
        return None
    row = float(np.median([one.t[1] - one.t[0] for one in motions]))
    return Delay(value=delay, std=std, rows=delay / row, held_out_gain=gains[1].share)


@dataclass(frozen=True, slots=True)
class _DelayFit:
    """Delay of least cost and its standard error [s], with the independent columns and weights that it was found by."""

    delay: float
    std: float
    rows: Sequence[_Rows]
    kept: Array
    weights: Sequence[Array]
    residuals: Sequence[Array]


def _fit_delay(rows: Sequence[_Rows], limit: float) -> _DelayFit:
    kept = independent_columns(np.concatenate([one.columns.reshape(-1, one.columns.shape[2]) for one in rows]))
    rows = [replace(one, columns=one.columns[:, :, kept]) for one in rows]
    delay, weights = 0.0, [np.ones(one.moving.shape[1]) for one in rows]
    # The columns explain a torque exactly that never changes in one joint or run: its weight stays finite.
    torques = np.concatenate([one.torque_at(0.0).ravel() for one in rows])
    least = THRESHOLDS.least_residual_torque_over_torque * rms(torques)
    for _ in range(THRESHOLDS.weighted_solutions):
        # The weights are those of the residual before, as in the plain model's own least squares.
        weights = [1.0 / np.maximum(column_rms(e), least) for e in _residuals(rows, weights, delay)]
        delay = _minimise(rows, weights, limit)
    residuals = _residuals(rows, weights, delay)
    sloped = [one.columns_with_slope(delay) for one in rows]
    std = np.inf
    # A torque that never changes, or that the columns explain at any delay, tells none.
    if independent_columns(np.concatenate([one.reshape(-1, one.shape[2]) for one in sloped]))[-1]:
        std = float(np.sqrt(block_covariance(sloped, residuals, weights)[-1, -1]))
    return _DelayFit(delay, std, rows, kept, weights, residuals)


def bracket(motions: Sequence[FilteredMotion]) -> float:
    """Return the largest delay that is looked for.

    Parameters
    ----------
    motions
        Filtered motions of the fitted runs.

    Returns
    -------
    float
        `THRESHOLDS.largest_delay_over_time_of_speed` times RMS speed over RMS acceleration of the fastest joint [s], at
        most what the ends of the runs leave. A longer delay would be a phase of the motion itself.
    """
    times = []
    for k in range(motions[0].q.shape[1]):
        speed = rms(np.concatenate([m.v[m.interior, k] for m in motions]))
        acceleration = rms(np.concatenate([m.a[m.interior, k] for m in motions]))
        times.append(speed / max(float(acceleration), np.finfo(float).tiny))
    ends = min(float(m.t[m.edge]) for m in motions)
    return min(THRESHOLDS.largest_delay_over_time_of_speed * float(min(times)), ends)


def with_delayed_torque(run: Run, delay: float) -> Run:
    """Let the torque of a run act later than it was recorded.

    Parameters
    ----------
    run
        Run with its recorded torque.
    delay
        Delay T [s] of either sign.

    Returns
    -------
    Run
        With τ(t − T) for the torque. A held torque becomes its mean over each row; the first and the last torque go on
        beyond the ends.
    """
    if delay == 0.0:
        return run
    if run.hold == "linear":
        return run.but(u=np.column_stack([np.interp(run.t - delay, run.t, u) for u in run.u.T]))
    edges = np.append(run.t, 2.0 * run.t[-1] - run.t[-2])
    reach = abs(delay) + float(edges[-1] - edges[-2])
    knots = np.concatenate([[edges[0] - reach], edges, [edges[-1] + reach]])
    steps = np.diff(knots)[:, None] * np.concatenate([run.u[:1], run.u, run.u[-1:]])
    impulse = np.concatenate([np.zeros((1, run.u.shape[1])), np.cumsum(steps, axis=0)])
    at = np.column_stack([np.interp(edges - delay, knots, column) for column in impulse.T])
    return run.but(u=np.diff(at, axis=0) / np.diff(edges)[:, None])


def _rows_of(motion: FilteredMotion, columns: Array, moving: NDArray[np.bool_], extra: float) -> _Rows:
    """Cut the rows of a run, with the columns that a delay is not to stand for.

    ``extra`` is the width of one more filter on columns and torque, over that of the motion; 0 for none.
    """
    joints = range(motion.q.shape[1])
    own = [_with_memory(motion.q[:, k], motion.v[:, k]) for k in joints]
    width = 1 + own[0].shape[1]
    beside = np.zeros((motion.t.size, len(joints), width * len(joints)))
    for k in joints:
        dry = motion.through_filter(own[k])
        beside[:, k, width * k : width * (k + 1)] = np.column_stack([motion.q[:, k] - motion.q[:, k].mean(), dry])
    torque = motion.through_filter(motion.torque)
    columns = np.concatenate([columns, motion.through_filter(beside)], axis=2)
    if extra:
        rows = extra * motion.width_in_rows
        columns, torque = convolve_gaussian(columns, rows), convolve_gaussian(torque, rows)
    # Behind two passes nothing is left beyond the frequency of rows a width apart (decimation, Gautier 1997).
    inside = slice(motion.interior.start, motion.interior.stop, max(int(motion.width_in_rows), 1))
    counts = moving[inside].astype(float)
    return _Rows(
        t=motion.t[inside],
        torque=CubicSpline(motion.t, torque),
        columns=columns[inside] * counts[:, :, None],
        moving=counts,
    )


def _with_memory(q: Array, v: Array) -> Array:
    """Return dry friction that lags or falls with speed, shape (n_t, n): bristles of several travels, Stribeck curves.

    A bristle of travel δ follows ż = q̇ − |q̇|·z/δ, of which z/δ is the share of its friction (Dahl 1968).
    """
    travels = np.array(THRESHOLDS.bristles_beside_delay_over_travel) * float(np.ptp(q))
    moved = np.diff(q, prepend=q[0])
    kept = np.exp(-np.abs(moved)[:, None] / travels)
    ends = np.sign(moved)[:, None] * (1.0 - kept)
    z, shares = np.zeros(travels.size), np.empty((q.size, travels.size))
    for k in range(q.size):
        z = ends[k] + kept[k] * z
        shares[k] = z
    speeds = np.array(THRESHOLDS.stribeck_beside_delay_over_speed) * float(np.max(np.abs(v)))
    return np.column_stack([shares, np.sign(v)[:, None] * np.exp(-((v[:, None] / speeds) ** 2))])


def _minimise(rows: Sequence[_Rows], weights: Sequence[Array], limit: float) -> float:
    """Return the delay of least cost, shape of its neighbourhood first: the cost may have several minima."""
    basis = np.linalg.qr(_stack([one.columns for one in rows], weights))[0]

    def cost(delay: float) -> float:
        b = _stack([one.torque_at(delay)[:, :, None] for one in rows], weights)[:, 0]
        return float(b @ b - np.sum((basis.T @ b) ** 2))

    grid = np.linspace(-limit, limit, THRESHOLDS.delays_of_scan)
    costs = [cost(delay) for delay in grid]
    best = int(np.argmin(costs))
    ends = (grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)])
    found = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 1e-5 * limit})
    return float(found.x) if found.fun <= costs[best] else float(grid[best])


def _residuals(rows: Sequence[_Rows], weights: Sequence[Array], delay: float) -> list[Array]:
    A = _stack([one.columns for one in rows], weights)
    torques = [one.torque_at(delay) for one in rows]
    theta = np.linalg.lstsq(A, _stack([tau[:, :, None] for tau in torques], weights)[:, 0], rcond=None)[0]
    return [tau - one.columns @ theta for tau, one in zip(torques, rows, strict=True)]


def _gain(rows: Sequence[_Rows], weights: Sequence[Array], delay: float, counts: Sequence[int]) -> _Gain:
    """Compare the blocks as the others predict them with the delay and without it."""
    without = _held_out_energies(rows, [one.columns for one in rows], weights, 0.0, counts)
    having = _held_out_energies(rows, [one.columns_with_slope(delay) for one in rows], weights, delay, counts)
    gain = without - having
    spread = max(float(np.std(gain, ddof=1)), np.finfo(float).tiny)
    return _Gain(share=float(gain.sum() / without.sum()), errors=float(np.sqrt(gain.size) * np.mean(gain)) / spread)


def _held_out_energies(
    rows: Sequence[_Rows], columns: Sequence[Array], weights: Sequence[Array], delay: float, counts: Sequence[int]
) -> Array:
    """Return the energy of each block as the other blocks predict it, shape (n_blocks,).

    r_b⁻ = r_b + W_b·(WᵀW − W_bᵀW_b)⁻¹·W_bᵀ·r_b is exact for what the torque is linear in, and of first order for T.
    """
    A = _stack(columns, weights)
    size = np.linalg.norm(A, axis=0)
    A = A / size
    b = _stack([one.torque_at(delay)[:, :, None] for one in rows], weights)[:, 0]
    residual = b - A @ np.linalg.lstsq(A, b, rcond=None)[0]
    normal = A.T @ A
    energies, first = [], 0
    for one, count in zip(rows, counts, strict=True):
        joints = one.moving.shape[1]
        for block in np.array_split(np.arange(one.t.size), count):
            # Rows lie one after the other, the joints of a row together.
            part = slice(first + joints * int(block[0]), first + joints * (int(block[-1]) + 1))
            W, e = A[part], residual[part]
            energies.append(float(np.sum((e + W @ np.linalg.lstsq(normal - W.T @ W, W.T @ e, rcond=None)[0]) ** 2)))
        first += joints * one.t.size
    return np.array(energies)


def _stack(columns: Sequence[Array], weights: Sequence[Array]) -> Array:
    """Return all weighted rows below each other, shape (n_rows, n_columns)."""
    return np.concatenate([(W * w[:, None]).reshape(-1, W.shape[2]) for W, w in zip(columns, weights, strict=True)])
