"""Lock postures as design variables: choose the postures that reduce the torque error of the full model most.

`Device` and configurations come in, a `PosturePlan` goes out. After tests with coefficient rows A and standard
deviations σ the covariance of π is P = (P₀⁻¹ + Σ Aᵀ A/σ²)⁻¹. The design minimises the expected relative variance of the
full model's torque over random motions, tr(W P) with W = mean of Yᵀ Y / rms(τ)² (V-optimality; Fedorov 1972):

1. Form a pool of tests, each a configuration at one of the Sobol postures.
2. Start from P after the tests with all locked joints at home.
3. Add greedily the test that reduces tr(W P) most.
4. Exchange one test at a time for the best one given the others, in at most two sweeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from haptid.model.device.device import Device
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.locked_dynamics import LockedDynamics, locked_motion
from haptid.model.rigid_body.regressor import regressor
from haptid.model.thresholds import THRESHOLDS

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Test:
    """One configuration at one lock posture.

    Parameters
    ----------
    dynamics
        Equation of motion with its n coefficients.
    std
        Expected standard deviations of the fitted coefficients, in their units, shape (n,).
    """

    dynamics: LockedDynamics
    std: Array

    @property
    def whitened(self) -> Array:
        """A/σ, shape (n, n_pi); 0 where σ is 0: such a coefficient is known before any test."""
        std = self.std[:, np.newaxis]
        return np.divide(self.dynamics.linear_map, std, out=np.zeros_like(self.dynamics.linear_map), where=std > 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PosturePlan:
    """The chosen tests beyond those at home, and the expected rms torque error over rms torque, before and after.

    Parameters
    ----------
    accuracy
        Relative accuracy that the fits of coefficients are taken to reach.
    home, chosen
        Tests with the locked joints at home, and those at the proposed postures.
    error_prior, error_home, error_planned
        √(tr(W P)/n_q) before any test, after the tests at home, and with the chosen ones.
    """

    home: tuple[Test, ...]
    chosen: tuple[Test, ...]
    accuracy: float
    error_prior: float
    error_home: float
    error_planned: float


def torque_weight(device: Device, samples: int = 400, seed: int = 0) -> Array:
    """Compute the weight of the inertial parameters in the relative torque error of the full model.

    Parameters
    ----------
    device
        Device with n_q joints.
    samples, seed
        Number and seed of the random states within the limits.

    Returns
    -------
    Array
        W, shape (n_pi, n_pi): Σ over joints of mean(Yᵀ Y)/mean(τ²), with τ = Y·π at the first guesses.
    """
    pi, _ = pi_prior(device)
    q, v, a = random_motion(device, samples, seed)
    W = np.zeros((pi.size, pi.size))
    for Y in regressor(device, q, v, a):
        W += Y.T @ Y / samples / max(float(np.mean((Y @ pi) ** 2)), 1e-30)  # a joint may need no torque at all
    return W


def random_motion(device: Device, samples: int, seed: int) -> tuple[Array, Array, Array]:
    """Draw states of random harmonic motions within `THRESHOLDS.reach_of_postures_over_range` of the position limits.

    Parameters
    ----------
    device
        Device with n_q joints.
    samples, seed
        Number and seed of the states.

    Returns
    -------
    q, v, a : Array
        Positions [rad], speeds [rad/s] and accelerations [rad/s²], or in m for a prismatic joint, each of shape
        (n_q, samples), at frequencies from 1 to 7 rad/s and random phase.
    """
    rng = np.random.default_rng(seed)
    lower, upper = _limits(device)
    middle, half = (lower + upper) / 2, THRESHOLDS.reach_of_postures_over_range * (upper - lower) / 2
    phase = rng.uniform(0.0, 2 * np.pi, (lower.size, samples))
    omega = rng.uniform(1.0, 7.0, (lower.size, samples))
    column = half[:, np.newaxis]
    return (
        middle[:, np.newaxis] + column * np.sin(phase),
        column * omega * np.cos(phase),
        -column * omega**2 * np.sin(phase),
    )


def _limits(device: Device) -> tuple[Array, Array]:
    limits = np.array([joint.planned_range for joint in device.joints])
    return limits[:, 0], limits[:, 1]


def candidate_postures(device: Device, number: int, seed: int) -> Array:
    """Draw postures from a Sobol sequence within `THRESHOLDS.reach_of_postures_over_range` of the position limits.

    Parameters
    ----------
    device
        Device with n_q joints.
    number
        Number of postures.
    seed
        Seed of the scrambled sequence.

    Returns
    -------
    Array
        Positions [rad] or [m], shape (number, n_q).
    """
    lower, upper = _limits(device)
    middle, half = (lower + upper) / 2, THRESHOLDS.reach_of_postures_over_range * (upper - lower) / 2
    # a Sobol sequence is balanced for powers of 2: the next larger power is drawn and then cut to the number
    points = qmc.Sobol(lower.size, seed=seed).random_base2(int(np.ceil(np.log2(number))))[:number]
    return np.asarray(middle + half * (2 * points - 1))


def expected_std(dynamics: LockedDynamics, relative: float) -> Array:
    """Return the expected standard deviations of fitted coefficients.

    Parameters
    ----------
    dynamics
        Equation of motion with n coefficients.
    relative
        Relative accuracy of a fit.

    Returns
    -------
    Array
        `relative` times the larger of first guess and prior standard deviation, in the coefficients' units, shape (n,).
    """
    return np.array([relative * max(abs(c.initial), c.prior_std) for c in dynamics.coefficients])


def plan_postures(
    device: Device,
    configurations: Sequence[tuple[int, ...]],
    *,
    extra: int = 14,
    relative: float = 0.005,
    candidates: int = 48,
    seed: int = 0,
) -> PosturePlan:
    """Choose tests at other lock postures in addition to those at home.

    Parameters
    ----------
    device
        Device with n_q joints.
    configurations
        Free joints of each configuration.
    extra
        Number of tests to choose; none where every configuration frees all joints.
    relative
        Relative accuracy that the fits of coefficients are assumed to reach.
    candidates
        Number of postures per configuration in the pool.
    seed
        Seed of postures and random motions.

    Returns
    -------
    PosturePlan
        Tests at home, chosen tests and the expected torque errors.
    """
    postures = candidate_postures(device, candidates, seed)
    pool = []
    for free in configurations:
        if _matters(device, free):
            pool += [_test(device, free, posture, relative) for posture in postures]
    home = tuple(_test(device, free, np.zeros(len(device.joints)), relative) for free in configurations)
    W = torque_weight(device, seed=seed)
    _, prior = pi_prior(device)
    P_home = _after(prior, home)
    chosen: list[int] = []
    P = P_home
    for _ in range(extra if pool else 0):
        best = int(np.argmax([_gain(P, W, test.whitened) for test in pool]))
        chosen.append(best)
        P = _update(P, pool[best].whitened)
    chosen = _exchange_tests(P_home, W, pool, chosen)
    picked = tuple(pool[i] for i in sorted(chosen))
    n = len(device.joints)

    def error(covariance: Array) -> float:
        return float(np.sqrt(np.sum(W * covariance) / n))

    return PosturePlan(
        home=home,
        chosen=picked,
        accuracy=relative,
        error_prior=error(prior),
        error_home=error(P_home),
        error_planned=error(_after(P_home, picked)),
    )


def _matters(device: Device, free: tuple[int, ...]) -> bool:
    return len(free) < len(device.joints)


def _test(device: Device, free: tuple[int, ...], posture: Array, relative: float) -> Test:
    dynamics = locked_motion(device, free, tuple(np.round(posture, 3)))
    return Test(dynamics=dynamics, std=expected_std(dynamics, relative))


def _gain(P: Array, W: Array, rows: Array) -> float:
    """tr(W P) − tr(W P⁺) for the update P⁺ by whitened rows, by the matrix inversion lemma."""
    PA = P @ rows.T
    return float(np.trace(np.linalg.solve(np.eye(len(rows)) + rows @ PA, PA.T @ W @ PA)))


def _update(P: Array, rows: Array) -> Array:
    PA = P @ rows.T
    result = P - PA @ np.linalg.solve(np.eye(len(rows)) + rows @ PA, PA.T)
    return np.asarray((result + result.T) / 2)


def _after(P: Array, tests: Sequence[Test]) -> Array:
    for test in tests:
        P = _update(P, test.whitened)
    return P


def _exchange_tests(P_home: Array, W: Array, pool: Sequence[Test], chosen: list[int], sweeps: int = 2) -> list[int]:
    """Replace one test at a time by the best of the pool given the others, until nothing improves."""
    for _ in range(sweeps):
        before = list(chosen)
        for place in range(len(chosen)):
            others = _after(P_home, [pool[i] for n, i in enumerate(chosen) if n != place])
            chosen[place] = int(np.argmax([_gain(others, W, test.whitened) for test in pool]))
        if chosen == before:
            break
    return chosen
