"""Proposal of the next run: posterior in, the cosine torque that most narrows the least known parameter out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.signals.cycles import find_cycles
from haptid.measurement.values.run import Array, Run
from haptid.noise.terms import linearise, prepare, scatter_columns
from haptid.support.linear_algebra import inverse
from haptid.uq.density.density import Density
from haptid.uq.density.laplace import Laplace
from haptid.uq.density.normal_equations import run_information
from haptid.uq.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class NextRun:
    """Proposed run with the precision that is expected of it.

    Parameters
    ----------
    parameter
        Id of the least known parameter (widest interval relative to its value).
    amplitude, omega, duration
        Amplitude A [N m] and angular frequency ω [rad/s] of the torque A·cos(ω·t), and its duration [s].
    before, after
        Standard deviation of the parameter's coordinate (relative, for a logarithmic one) now, and as expected with
        the proposed run.
    repeat
        Expected standard deviation where the most informative of the fitted runs is repeated instead.
    """

    parameter: str
    amplitude: float
    omega: float
    duration: float
    before: float
    after: float
    repeat: float


def next_run(mode: Laplace, simulator: Simulator, covariance: Array) -> NextRun | None:
    """Search amplitudes and frequencies around those used for the largest gain in the least known parameter.

    Parameters
    ----------
    mode
        Normal approximation under the chosen noise model.
    simulator
        Simulator with sensitivities.
    covariance
        Posterior covariance of η, shape (n, n).

    Returns
    -------
    NextRun or None
        None where no parameter is free, where every candidate leaves the permitted travel, or where the residual is a
        torque: a run under position control cannot be foreseen from its torque.

    Notes
    -----
    Expected covariance (C⁻¹ + JᵀΣ⁻¹J)⁻¹ with the candidate's sensitivities at the mode. Torque stays within
    1.4 times the largest used so far, travel within 1.3 times.
    """
    density = mode.density
    if not simulator.equations.joints:
        return None
    theta = density.coordinates.thetas(mode.eta)
    worst = _least_known(density, mode.eta, covariance)
    if worst is None:
        return None
    information = inverse(covariance)
    base = density.terms[0].run
    torque = max(float(np.ptp(t.run.u)) / 2 for t in density.terms)
    travel = max(float(np.ptp(t.data)) for t in density.terms)
    omega = float(np.median([find_cycles(t.run).omega or 1.0 for t in density.terms]))
    found: list[tuple[float, float, float]] = []
    for a in THRESHOLDS.tried_amplitudes_over_largest:
        for w in THRESHOLDS.tried_frequencies_over_median:
            run = _cosine(base, a * torque, w * omega)
            y = simulator.simulate(theta, run).y[:, 0]
            if np.isfinite(y).all() and np.ptp(y) <= 1.3 * travel:
                run = run.but(y=y[:, None])  # the simulated motion stands for the reading, as `prepare` needs one
                found.append((_std_with(mode, simulator, run, information, worst), a * torque, w * omega))
    if not found:
        return None
    after, amplitude, omega = min(found)
    repeats = [_std_with(mode, simulator, terms.run, information, worst) for terms in density.terms]
    return NextRun(
        parameter=density.coordinates.names[worst],
        amplitude=amplitude,
        omega=omega,
        duration=float(base.t[-1]),
        before=float(np.sqrt(covariance[worst, worst])),
        after=after,
        repeat=min(repeats),
    )


def _least_known(density: Density, eta: Array, covariance: Array) -> int | None:
    """Return the index of the free parameter with the largest relative standard deviation; None where none is free."""
    std = np.sqrt(np.diag(covariance))
    n = len(density.coordinates.free)
    logarithmic = np.array(density.coordinates.logarithmic[:n])
    linear = std[:n] / np.maximum(np.abs(eta[:n]), std[:n])  # at most 1, also of a parameter near 0
    return int(np.argmax(np.where(logarithmic, std[:n], linear))) if n else None


def _cosine(base: Run, amplitude: float, omega: float) -> Run:
    u = amplitude * np.cos(omega * base.t)[:, None]
    return base.but(u=u, v=None, extra={}, file="candidate", score_from=0)


def _std_with(mode: Laplace, simulator: Simulator, run: Run, information: Array, worst: int) -> float:
    """Predict the standard deviation of the coordinate ``worst`` after ``run``, by (C⁻¹ + JᵀΣ⁻¹J)⁻¹."""
    density = mode.density
    n = len(density.coordinates.free)
    theta = density.coordinates.thetas(mode.eta)
    terms = prepare(simulator.equations, run)
    trajectory = simulator.simulate(theta, run, x0=terms.x0, sensitivities=True)
    terms = scatter_columns(linearise(terms, trajectory), simulator, theta, density.model)
    total = information.copy()
    total[:n, :n] += run_information(density, simulator, terms, mode.eta)
    return float(np.sqrt(inverse(total)[worst, worst]))
