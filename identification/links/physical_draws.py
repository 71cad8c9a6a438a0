"""Draws of the inertial parameters from their Gaussian belief: `LinkBelief` in, physically consistent π out.

Hit-and-run (Smith 1984) in whitened coordinates: along a random direction the belief is a normal distribution, and the
pseudo-inertia of every link stays positive definite on one interval around the present point, found from the
generalised eigenvalues of J(point) and J(direction). The next point is drawn from the normal distribution cut to
that interval. Several chains go side by side: the arrays of one are too small for compiled code to gain anything.
"""

from __future__ import annotations

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from haptid.identification.links.consistent_links import pseudo_inertia
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.device.device import Device
from haptid.model.planning.inertial_belief import LinkBelief

_OF_UNIT_BODIES = np.array([pseudo_inertia(unit) for unit in np.eye(10).tolist()])
"""J of the ten unit vectors, shape (10, 4, 4): J is linear in the inertial parameters of a body."""


def physical_draws(
    device: Device, belief: LinkBelief, start: Array, count: int, rng: np.random.Generator
) -> tuple[Array, ...]:
    """Draw physically consistent inertial parameters from their belief.

    Parameters
    ----------
    device
        Device with the links.
    belief
        Gaussian belief over π.
    start
        Physically consistent first point, shape (n_pi,).
    count
        Number of draws.
    rng
        Random numbers.

    Returns
    -------
    tuple of ndarray, shape (n_pi,) each
        π in SI units; ``count`` draws.

    References
    ----------
    Smith, Efficient Monte Carlo procedures for generating points uniformly distributed over bounded regions, 1984.
    """
    # Scaled before the eigenvalues are cut: masses and inertias differ by orders of magnitude.
    scale = np.sqrt(np.maximum(np.diag(belief.covariance), 1e-300))
    values, vectors = np.linalg.eigh(belief.covariance / np.outer(scale, scale))
    kept = values > 1e-14 * values[-1]
    root = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    unroot = (vectors[:, kept] / np.sqrt(values[kept])).T / scale
    chains = min(THRESHOLDS.chains_of_physical_draws, count)
    rounds = -(-count // chains)
    centre = np.tile(unroot @ (start - belief.mean), (chains, 1))
    pi, drawn = np.tile(start, (chains, 1)), []
    for step in range(1, THRESHOLDS.steps_between_physical_draws * rounds + 1):
        direction = rng.standard_normal(centre.shape)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        along = direction @ root.T
        lower, upper = _intervals(device, pi, along)
        middle = -np.sum(direction * centre, axis=1)
        move = middle + _cut_normal(lower - middle, upper - middle, rng.uniform(size=chains))
        centre, pi = centre + move[:, None] * direction, pi + move[:, None] * along
        if step % THRESHOLDS.steps_between_physical_draws == 0:
            drawn += list(pi)
    return tuple(drawn[:count])


def _cut_normal(lower: Array, upper: Array, share: Array) -> Array:
    """Return quantiles of standard normal distributions cut to intervals, accurate far out in their tails.

    scipy.stats.truncnorm does the same arithmetic at several times the cost of all else that a step does.
    """
    # The distribution function has digits to spare in the left tail alone.
    turned = lower > 0
    low, high = np.where(turned, -upper, lower), np.where(turned, -lower, upper)
    least, most = log_ndtr(low), log_ndtr(high)
    beneath = np.exp(least - most)
    share = np.where(turned, 1.0 - share, share)
    quantile = ndtri_exp(most + np.log(beneath + share * (1.0 - beneath)))
    return np.asarray(np.where(turned, -quantile, quantile))


def _intervals(device: Device, pi: Array, direction: Array) -> tuple[Array, Array]:
    """Return the ranges of s in which the points π + s·direction, shapes (n_chains, n_pi), are physically consistent.

    J(π) + s·J(direction) is positive definite where 1 + s·λ > 0 for every generalised eigenvalue λ.
    """
    chains, n = len(pi), 10 * len(device.massive)
    bodies = _eigenvalues(pi[:, :n].reshape(-1, 10), direction[:, :n].reshape(-1, 10)).reshape(chains, -1)
    rotors = np.where(pi[:, n:] > 0, direction[:, n:] / np.maximum(pi[:, n:], 1e-300), 0.0)
    rates = np.concatenate([bodies, rotors], axis=1)
    falling, rising = rates.min(axis=1, initial=0.0), rates.max(axis=1, initial=0.0)
    with np.errstate(divide="ignore"):
        return np.where(rising > 0, -1.0 / rising, -np.inf), np.where(falling < 0, -1.0 / falling, np.inf)


def _eigenvalues(bodies: Array, directions: Array) -> Array:
    """Return the eigenvalues of L⁻¹·J(direction)·L⁻ᵀ with J(body) = L·Lᵀ, for n bodies (n, 10), shape (n, 4)."""
    L = np.linalg.cholesky(_pseudo_inertias(bodies))
    half = np.linalg.solve(L, _pseudo_inertias(directions))
    whitened = np.linalg.solve(L, half.swapaxes(1, 2))
    return np.asarray(np.linalg.eigvalsh((whitened + whitened.swapaxes(1, 2)) / 2))


def _pseudo_inertias(bodies: Array) -> Array:
    """Return J of n bodies (n, 10), shape (n, 4, 4)."""
    return (bodies @ _OF_UNIT_BODIES.reshape(10, 16)).reshape(-1, 4, 4)
