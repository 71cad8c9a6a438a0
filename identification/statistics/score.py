"""Residuals of a run under fitted parameters, and how they compare with the sensor's noise.

The initial position is not known better than one sample tells: it is profiled with the prior N(y[0], σ²), for runs
that no fit saw too. A held-out part is judged from a start that only the rows before it determine.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from haptid.identification.problem.initial_states import Start, start_of
from haptid.identification.result.fit import RunScore
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run

STEPS = 8


class HasTheta(Protocol):
    """Anything with parameters, as a `Fit`."""

    @property
    def theta(self) -> Array:
        """Parameters, shape (n_p,)."""


def residuals(simulator: Simulator, theta: Array, run: Run, x0: Array) -> Array:
    """Return measured − simulated [rad], shape (n_t, n_joints)."""
    y = simulator.simulate(theta, run, x0=x0).y
    return np.asarray(run.y - y[:, : run.y.shape[1]])


def fit_initial_state(simulator: Simulator, theta: Array, run: Run, *, free_velocity: bool = False) -> Array:
    """Return the initial state that fits ``run`` best at fixed parameters, by Gauss–Newton from the first sample."""
    start = start_of(simulator.equations, run, free_velocity=free_velocity)
    rows = slice(0, run.score_from) if run.score_from else slice(None)
    delta = np.zeros(len(start.states))
    r, J = _whiten(simulator, theta, run, start, delta, rows)
    if not np.isfinite(r).all():
        return start.at(delta)
    step = -np.linalg.lstsq(J, r, rcond=None)[0]
    for _ in range(STEPS):
        new_r, new_J = _whiten(simulator, theta, run, start, delta + step, rows)
        gained = float(r @ r) - float(new_r @ new_r)
        if gained > 0:
            delta, r, J = delta + step, new_r, new_J
            step = -np.linalg.lstsq(J, r, rcond=None)[0]
        else:
            step = step / 4.0
        if abs(gained) < 1e-9 * float(r @ r):
            break
    return start.at(delta)


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
    """Judge ``run`` on its scored rows; the initial state is profiled where ``x0`` is None."""
    start = fit_initial_state(simulator, fit.theta, run, free_velocity=free_velocity) if x0 is None else x0
    return score_of(run, residuals(simulator, fit.theta, run, start)[run.scored], start)


def score_of(run: Run, r: Array, x0: Array) -> RunScore:
    """Return the score of scored residuals r (n_scored, n_joints) [rad]."""
    rmse = np.sqrt(np.mean(r**2, axis=0))
    return RunScore(
        file=run.file,
        use=run.use,
        rmse=rmse,
        over_noise=float(np.sqrt(np.mean((r / run.sensor_std) ** 2))),
        nrmse=float(np.max(rmse / np.maximum(np.ptp(run.y, axis=0), 1e-300))),
        x0=x0,
    )
