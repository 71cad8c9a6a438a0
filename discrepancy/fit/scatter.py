"""Linearise amplitudes that scatter from cycle to cycle: simulator, `Run` and `Noise` in, columns S = s·M out.

Column c of M is the change of the readings with the relative amplitude of cycle c, over the sensor's standard
deviation. On the reading it follows from one simulation. On the torque it is a difference of two simulations, and the
linearisation is repeated about the most probable amplitudes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.discrepancy.study.channels import alone
from haptid.discrepancy.study.simulators import TwoStep
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.signals.cycles import Cycles, whole_cycles
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Noise, Scatter, Whitener
from haptid.noise.cycle_torque import torque_columns


def cycles_of(run: Run, scatter: Scatter) -> Cycles:
    """Return the cycles of the torque of the joint whose amplitude scatters.

    Parameters
    ----------
    run
        Run of one or several free joints.
    scatter
        Scatter whose ``column`` is the index of the joint in the run.

    Returns
    -------
    Cycles
        Cycles of that joint's torque, every begun one counted.
    """
    return whole_cycles(alone(run, scatter.column))


def cycle_columns(
    simulator: TwoStep, run: Run, scatter: Scatter, theta: Array, x0: Array, *, cycles: Cycles | None = None
) -> Array:
    """Compute the change of the readings with each cycle's relative amplitude.

    Parameters
    ----------
    simulator
        Simulator of the model; the coarse step is used, as for sensitivities.
    run
        Run of one or several joints.
    scatter
        Joint, path and centre of the scatter.
    theta
        Parameters, shape (n_p,).
    x0
        Initial state, shape (n_x,).
    cycles
        Cycles of the torque; those of ``run`` where None.

    Returns
    -------
    ndarray
        M over the sensor's standard deviation, shape (n_t, n_joints, n_cycles).

    Notes
    -----
    On the reading, column c is q − centre of the joint within cycle c and 0 elsewhere. On the torque, it is that of
    `torque_columns`.
    """
    cycles = cycles_of(run, scatter) if cycles is None else cycles
    at = scatter.column
    if scatter.path == "reading":
        y = _readings(simulator.coarse, theta, run, x0)
        M = np.zeros((*y.shape, cycles.count))
        M[:, at] = (y[:, at] - scatter.centre)[:, None] * cycles.inside
    else:
        M = torque_columns(simulator.coarse, theta, run, x0, cycles.index, column=at)
    return np.asarray(M / run.sensor_std[:, None])


def _readings(simulator: Simulator, theta: Array, run: Run, x0: Array) -> Array:
    return simulator.simulate(theta, run, x0=x0).y[:, : run.y.shape[1]]


def relinearise_cycles(simulator: TwoStep, run: Run, noise: Noise, theta: Array, x0: Array) -> tuple[Run, Array]:
    """Linearise a run about the most probable amplitudes of its cycles.

    Parameters
    ----------
    simulator
        Simulator of the model.
    run
        Run as it was measured.
    noise
        Noise model with its scatters.
    theta
        Parameters, shape (n_p,).
    x0
        Initial state, shape (n_x,).

    Returns
    -------
    run, S
        Run with torque u·exp(s·ξ̂) and reading y + σ·S·ξ̂, and S = s·M at ξ̂, shape (n_t, n_joints, K). The run is
        unchanged where no torque scatters or the simulation left the finite numbers.

    Notes
    -----
    With torque u·exp(s·ξ) in a cycle, ξ standard normal, the reading is linearised about the posterior mean ξ̂ instead
    of 0: y(ξ) ≈ y(ξ̂) + σ·S·(ξ − ξ̂). With the returned run, residual and S stay those of the linear model r = S·ξ + ε.
    A scatter on the reading is linear as it is.
    """
    cycles = [cycles_of(run, scatter) for scatter in noise.scatters]
    counts = [c.count for c in cycles]
    s = np.repeat([scatter.size for scatter in noise.scatters], counts)
    acting = np.repeat([scatter.path == "torque" for scatter in noise.scatters], counts)

    def columns(about: Run) -> Array:
        pairs = zip(noise.scatters, cycles, strict=True)
        each = [cycle_columns(simulator, about, scatter, theta, x0, cycles=c) for scatter, c in pairs]
        return np.concatenate(each, axis=2) * s

    if not acting.any():
        return run, columns(run)
    b: Array = np.zeros(s.size)
    for _ in range(THRESHOLDS.fit.most_linearisations):
        moved = run.but(u=run.u * np.exp(_spread_over_rows(b, noise.scatters, cycles, run)))
        S = columns(moved)
        # The whitener takes no directions from such columns; the residual is infinite there.
        if not np.isfinite(S).all():
            return run, S
        shift = S @ (b / s)
        r = (run.y - _readings(simulator, theta, moved, x0)) / run.sensor_std + shift
        flat, left = noise.arma.whiten(S).reshape(-1, s.size), noise.arma.whiten(r).ravel()
        xi = most_probable(flat, left)
        farthest = THRESHOLDS.fit.largest_log_torque_factor
        before, b = b, np.where(acting, np.clip(s * xi, -farthest, farthest), 0.0)
        if np.abs(b - before).max() < THRESHOLDS.fit.settled_log_torque_change:
            break
    return moved.but(y=run.y + run.sensor_std * shift), S


def most_probable(S: Array, r: Array) -> Array:
    """Return the posterior mean of the cycles' amplitudes, ξ̂ = (SᵀS + I)⁻¹·Sᵀ·r, of the model r = S·ξ + ε.

    Parameters
    ----------
    S
        Columns of the scatter, shape (n, K).
    r
        Residual with white noise of variance 1, shape (n,).

    Returns
    -------
    ndarray
        ξ̂, shape (K,).
    """
    return np.asarray(np.linalg.lstsq(S.T @ S + np.eye(S.shape[1]), S.T @ r, rcond=None)[0])


def _spread_over_rows(b: Array, scatters: Sequence[Scatter], cycles: Sequence[Cycles], run: Run) -> Array:
    """Return the value of b in every row of its joint, shape (n_t, n_joints); 0 outside all cycles."""
    spread, first = np.zeros(run.u.shape), 0
    for scatter, c in zip(scatters, cycles, strict=True):
        spread[:, scatter.column] += c.inside @ b[first : first + c.count]
        first += c.count
    return spread


def degrees_of_freedom(
    runs: Sequence[Run], whiteners: Sequence[Whitener], scatters: Sequence[Scatter], scatter: Scatter
) -> float:
    """Compute the degrees of freedom to which the size of a scatter is known.

    Parameters
    ----------
    runs
        Fitted runs.
    whiteners
        Whiteners of these runs under the noise model.
    scatters
        All scatters of the noise model.
    scatter
        The scatter among them whose size is asked for.

    Returns
    -------
    float
        Degrees of freedom, at least 1.

    Notes
    -----
    A direction in which the cycles' amplitudes add λ to the noise variance of 1 counts (λ/(1 + λ))², half its
    information on ln s. A run has as many directions as its joints have cycles, and the joint's share is that of its
    cycles. Only differences between the cycles of one run are informative, beside their drift: any other parameter
    could produce what the cycles share.
    """
    freedom = 0.0
    for run, whitener in zip(runs, whiteners, strict=True):
        own, all_joints = cycles_of(run, scatter).count, sum(cycles_of(run, one).count for one in scatters)
        grown = np.zeros(0) if whitener.growth is None else whitener.growth
        # Two degrees of freedom of each run are lost to the amplitude that its cycles share and to its drift.
        freedom += float(np.sum((grown / (1.0 + grown)) ** 2)) * max(own - 2, 0) / max(all_joints, 1)
    return max(freedom, 1.0)
