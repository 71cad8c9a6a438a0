"""Scores of runs at fitted parameters: `Simulator`, parameters and `Run` in, residuals and `RunScore` out.

The first sample determines the initial position only to the sensor's noise: the initial state is fitted, also of runs
that no fit saw. There only the first rows determine it (`rows_of_start`), so that the rest of the run is a prediction.
A held-out part of a run is scored from an initial state that only the rows before that part determine.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Protocol

import numpy as np
from scipy.optimize import least_squares

from haptid.identification.problem.initial_states import Start, start_of
from haptid.identification.result.fit import RunScore
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.covariance import correlation_time, tapered_autocovariance
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import column_rms, rms


class HasTheta(Protocol):
    """Object with parameters, such as a `Fit`."""

    @property
    def theta(self) -> Array:
        """Parameters, shape (n_p,)."""


def residuals(simulator: Simulator, theta: Array, run: Run, x0: Array) -> Array:
    """Simulate a run freely and return measured − simulated positions.

    Parameters
    ----------
    simulator
        Simulator of the configuration.
    theta
        Parameters, shape (n_p,).
    run
        Run to simulate.
    x0
        Initial state, shape (n_x,).

    Returns
    -------
    ndarray, shape (n_t, n_joints)
        Residuals [rad].
    """
    y = simulator.simulate(theta, run, x0=x0).y
    return np.asarray(run.y - y[:, : run.y.shape[1]])


def fit_initial_state(simulator: Simulator, theta: Array, run: Run, *, free_velocity: bool = False) -> Array:
    """Fit the initial state of a run at fixed parameters, by least squares from rest or from the first rows' slope.

    Parameters
    ----------
    simulator
        Simulator of the configuration.
    theta
        Parameters, shape (n_p,).
    run
        Run whose first rows, those of `rows_of_start`, determine the initial state.
    free_velocity
        Whether the initial velocities are fitted in any case, see `start_of`.

    Returns
    -------
    ndarray, shape (n_x,)
        Initial state; that of the first row where its simulation is not finite.
    """
    start = start_of(simulator.equations, run, free_velocity=free_velocity)
    rows = slice(0, rows_of_start(run))

    @lru_cache(maxsize=2)  # SciPy asks for residual and Jacobian apart: one simulation gives both
    def whiten_at(*delta: float) -> tuple[Array, Array]:
        return _whiten(simulator, theta, run, start, np.array(delta), rows)

    begins = [np.zeros(len(start.states)), start.guess] if start.guess.any() else [start.guess]
    costs = [float(np.sum(whiten_at(*delta)[0] ** 2)) for delta in begins]
    first = begins[int(np.argmin(costs))]
    if not np.isfinite(min(costs)):
        return start.at(first)
    best = least_squares(
        lambda delta: whiten_at(*delta)[0],
        first,
        lambda delta: whiten_at(*delta)[1],
        ftol=THRESHOLDS.cost_change_of_initial_state,
        max_nfev=THRESHOLDS.most_simulations_of_initial_state,
    )
    return start.at(best.x)


def rows_of_start(run: Run) -> int:
    """Count the first rows that determine the initial state of a run at fixed parameters.

    Parameters
    ----------
    run
        Run to score.

    Returns
    -------
    int
        The rows before the scored ones where there are such; else `THRESHOLDS.start_rows_over_rows` of the run, at
        least `THRESHOLDS.least_start_rows`.
    """
    if run.score_from:
        return run.score_from
    share = int(np.ceil(THRESHOLDS.start_rows_over_rows * run.t.size))
    return min(max(share, THRESHOLDS.least_start_rows), run.t.size)


def _whiten(
    simulator: Simulator, theta: Array, run: Run, start: Start, delta: Array, rows: slice
) -> tuple[Array, Array]:
    made = simulator.simulate(theta, run, x0=start.at(delta), sensitivities=True)
    n, k = run.y.shape[1], delta.size
    r = (run.y - made.y[:, :n])[rows] / run.sensor_std
    if made.dy_dx0 is None or not np.isfinite(r).all():
        return np.full(1, np.inf), np.ones((1, k))
    J = -(made.dy_dx0[rows][:, :n][..., list(start.states)] * start.unit) / run.sensor_std[:, None]
    prior = np.flatnonzero(start.prior)
    r = np.concatenate((r.ravel(), delta[prior]))
    return r, np.concatenate((J.reshape(-1, k), np.eye(k)[prior]))


def score(
    simulator: Simulator, fit: HasTheta, run: Run, *, x0: Array | None = None, free_velocity: bool = False
) -> RunScore:
    """Score a run on its scored rows.

    Parameters
    ----------
    simulator
        Simulator of the configuration.
    fit
        Object with the parameters.
    run
        Run to score.
    x0
        Initial state, shape (n_x,); fitted to the run (`fit_initial_state`) where None.
    free_velocity
        Whether the initial velocities are fitted in any case.

    Returns
    -------
    RunScore
    """
    start = fit_initial_state(simulator, fit.theta, run, free_velocity=free_velocity) if x0 is None else x0
    return score_of(run, residuals(simulator, fit.theta, run, start)[run.scored], start)


def score_of(run: Run, r: Array, x0: Array) -> RunScore:
    """Compute the score of a run from its residuals.

    Parameters
    ----------
    run
        Run with sensor noise and positions.
    r
        Residuals of the scored rows [rad], shape (n_scored, n_joints).
    x0
        Initial state of the simulation, shape (n_x,).

    Returns
    -------
    RunScore
    """
    rmse = column_rms(r)
    return RunScore(
        file=run.file,
        use=run.use,
        rmse=rmse,
        over_noise=rms(r / run.sensor_std),
        nrmse=float(np.max(rmse / np.maximum(np.ptp(run.y, axis=0), 1e-300))),
        x0=x0,
        rows=r.size,
        correlation_time=_correlation_time_of(r / run.sensor_std),
    )


def _correlation_time_of(r: Array) -> float | None:
    """Return the correlation time of a residual over its noise [rows]; None for one that is not finite or too short."""
    if r.shape[0] < 2 or not np.isfinite(r).all():
        return None
    return correlation_time(tapered_autocovariance((r,)))


def residual_over_motion(runs: Sequence[Run], scores: Sequence[RunScore]) -> float:
    """Compute how much of the motion of fitted runs a fit leaves.

    Parameters
    ----------
    runs
        The fitted runs.
    scores
        Scores of all runs.

    Returns
    -------
    float
        RMS of the residual over that of the motion about its mean [1], the largest of the joints.
    """
    fitted = {score.file: score for score in scores if score.use == "fit"}
    residual = np.mean([fitted[run.file].rmse ** 2 for run in runs], axis=0)
    motion = np.mean([np.var(run.y, axis=0) for run in runs], axis=0)
    return float(np.sqrt(np.max(residual / np.maximum(motion, np.finfo(float).tiny))))
