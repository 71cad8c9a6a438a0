"""Amplitudes that scatter from cycle to cycle: how a cycle's amplitude moves the reading, and how much it scatters."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from discrepancy.cycles import whole_cycles
from discrepancy.kernels import TwoStep
from discrepancy.noise import Noise, directions
from identification.simulator import Simulator
from measurement.cycles import Cycles
from measurement.run import Array, Run

LINEARISATIONS, NEAR = 12, 5e-4
"""Most linearisations of a run about its cycles' amplitudes, and the change of these from which another one pays.

Three do for most; a joint whose torque steps while it reverses takes nine.
"""
LARGEST = 1.0
"""Largest |ln| of a cycle's relative torque that is linearised about: beyond it the model is wrong."""
PROBE = 1e-2
"""Relative change of a cycle's torque from which its effect on the reading is taken."""


def cycle_columns(
    simulator: TwoStep, run: Run, noise: Noise, theta: Array, x0: Array, *, cycles: Cycles | None = None
) -> Array:
    """Return M (n_t, n_cycles): change of the reading with the relative amplitude of each cycle, over the sensor's std.

    Where the scatter acts on the reading, column c is q − centre within cycle c and 0 outside; where it acts on the
    torque, it is the difference of two simulations, the torque of cycle c changed by a hundredth. Like sensitivities,
    they run at the coarse step.
    """
    cycles = whole_cycles(run) if cycles is None else cycles
    y = simulator.coarse.simulate(theta, run, x0=x0).y[:, 0]
    inside = cycles.index[:, None] == np.arange(cycles.count)
    if noise.path == "reading":
        return np.asarray((y - noise.centre)[:, None] * inside / run.sensor_std[0])
    columns = [_torque_column(simulator.coarse, run, theta, x0, y, mask) for mask in inside.T]
    return np.stack(columns, axis=1) / run.sensor_std[0]


def _torque_column(simulator: Simulator, run: Run, theta: Array, x0: Array, y: Array, mask: Array) -> Array:
    u = run.u.copy()
    u[mask] *= 1.0 + PROBE
    return np.asarray((simulator.simulate(theta, run.but(u=u), x0=x0).y[:, 0] - y) / PROBE)


def relinearised(simulator: TwoStep, run: Run, noise: Noise, theta: Array, x0: Array) -> tuple[Run, Array]:
    """Return the run about the most probable amplitudes of its cycles, and M there.

    With torque u·exp(b) in a cycle, b ~ N(0, s²), the reading is linearised about the posterior mean b̂ instead of 0:
    y(b) ≈ y(b̂) + σ·M·(b − b̂). The returned run has the torque u·exp(b̂) and the reading y + σ·M·b̂, so that residual
    and M stay those of the linear model r = M·b + ε. A scatter on the reading is linear as it is.
    """
    cycles = whole_cycles(run)
    if noise.path == "reading":
        return run, cycle_columns(simulator, run, noise, theta, x0, cycles=cycles)
    b: Array = np.zeros(cycles.count)
    for _ in range(LINEARISATIONS):
        moved = run.but(u=run.u * np.exp(_spread(b, cycles))[:, None])
        M = cycle_columns(simulator, moved, noise, theta, x0, cycles=cycles)
        if not np.isfinite(M).all():
            return run, M
        r = (run.y[:, 0] - simulator.simulate(theta, moved, x0=x0).y[:, 0]) / run.sensor_std[0] + M @ b
        shift = run.sensor_std[0] * (M @ b)
        flat, left = noise.colour.whiten(M), noise.colour.whiten(r)
        weight = flat.T @ flat + np.eye(b.size) / noise.scatter**2
        before, b = b, np.clip(np.linalg.solve(weight, flat.T @ left), -LARGEST, LARGEST)
        if np.abs(b - before).max() < NEAR:
            break
    return moved.but(y=run.y + shift[:, None]), M


def _spread(b: Array, cycles: Cycles) -> Array:
    """Value of b in every row; 0 outside all cycles."""
    inside = cycles.index[:, None] == np.arange(cycles.count)
    return np.asarray(inside @ b)


def restricted_likelihood(r: Array, M: Array) -> tuple[Array, Array]:
    """Return variances d² and squared projections of r of the model r = M·b + ε, b ~ N(0, s²): both shape (K,).

    Nothing (K = 0) where the simulation behind them left the finite numbers.
    """
    if not (np.isfinite(M).all() and np.isfinite(r).all()):
        return np.empty(0), np.empty(0)
    U, d = directions(M)
    return d**2, (U.T @ r) ** 2


def best_scatter(d2: Array, c2: Array, largest: float = 0.5) -> tuple[float, float]:
    """Return s ≥ 0 of largest restricted likelihood, and twice its gain over s = 0.

    −2 ln L(s) = Σ ln(1 + s²·d²) + c²/(1 + s²·d²)
    """

    def deviance(log_s: float) -> float:
        grown = 1.0 + np.exp(2 * log_s) * d2
        return float(np.sum(np.log(grown) + c2 / grown))

    found = minimize_scalar(deviance, bounds=(np.log(1e-7), np.log(largest)), method="bounded")
    gain = float(c2.sum()) - float(found.fun)
    return (float(np.exp(found.x)), gain) if gain > 1e-3 else (0.0, 0.0)
