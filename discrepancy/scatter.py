"""Amplitudes that scatter from cycle to cycle: how a cycle's amplitude moves the reading, and how much it scatters."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from discrepancy.noise import Noise
from identification.simulator import Simulator
from measurement.cycles import find_cycles
from measurement.run import Array, Run

PROBE = 1e-2
"""Relative change of a cycle's torque from which its effect on the reading is taken."""


def cycle_columns(simulator: Simulator, run: Run, noise: Noise, theta: Array, x0: Array) -> Array:
    """Return M (n_t, n_cycles): change of the reading with the relative amplitude of each cycle, over the sensor's std.

    Where the scatter acts on the reading, column c is q − centre within cycle c and 0 outside; where it acts on the
    torque, it is the difference of two simulations, the torque of cycle c changed by a hundredth.
    """
    cycles = find_cycles(run)
    y = simulator.simulate(theta, run, x0=x0).y[:, 0]
    inside = cycles.index[:, None] == np.arange(cycles.count)
    if noise.path == "reading":
        return np.asarray((y - noise.centre)[:, None] * inside / run.sensor_std[0])
    columns = [_torque_column(simulator, run, theta, x0, y, mask) for mask in inside.T]
    return np.stack(columns, axis=1) / run.sensor_std[0]


def _torque_column(simulator: Simulator, run: Run, theta: Array, x0: Array, y: Array, mask: Array) -> Array:
    u = run.u.copy()
    u[mask] *= 1.0 + PROBE
    return np.asarray((simulator.simulate(theta, run.but(u=u), x0=x0).y[:, 0] - y) / PROBE)


def restricted_likelihood(r: Array, M: Array) -> tuple[Array, Array]:
    """Return variances d² and squared projections of r of the model r = M·b + ε, b ~ N(0, s²): both shape (K,)."""
    U, d, _ = np.linalg.svd(M, full_matrices=False)
    keep = d > 1e-6 * max(float(d[0]), 1e-300)
    return d[keep] ** 2, (U[:, keep].T @ r) ** 2


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
