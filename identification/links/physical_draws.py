"""Draws of the inertial parameters from their Gaussian belief: `LinkBelief` in, physically consistent π out.

Hit-and-run (Smith 1984) in whitened coordinates: along a random direction the belief is a normal distribution, and the
pseudo-inertia of every link stays positive definite on one interval around the present point, found from the
generalised eigenvalues of J(point) and J(direction). The next point is drawn from the normal distribution cut to
that interval.
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
    centre, pi, drawn = unroot @ (start - belief.mean), start, []
    for step in range(1, THRESHOLDS.steps_between_physical_draws * count + 1):
        direction = rng.standard_normal(root.shape[1])
        direction /= np.linalg.norm(direction)
        lower, upper = _interval(device, pi, root @ direction)
        middle = -float(direction @ centre)
        move = middle + _cut_normal(lower - middle, upper - middle, rng.uniform())
        centre, pi = centre + move * direction, pi + move * (root @ direction)
        if step % THRESHOLDS.steps_between_physical_draws == 0:
            drawn.append(pi)
    return tuple(drawn)


def _cut_normal(lower: float, upper: float, share: float) -> float:
    """Return the quantile of a standard normal distribution cut to an interval, accurate far out in its tails.

    scipy.stats.truncnorm does the same arithmetic at several times the cost of all else that a step does.
    """
    if lower > 0:
        # The distribution function has digits to spare in the left tail alone.
        return -_cut_normal(-upper, -lower, 1.0 - share)
    least, most = log_ndtr(lower), log_ndtr(upper)
    beneath = np.exp(least - most)
    return float(ndtri_exp(most + np.log(beneath + share * (1.0 - beneath))))


def _interval(device: Device, pi: Array, direction: Array) -> tuple[float, float]:
    """Return the range of s in which π + s·direction is physically consistent.

    J(π) + s·J(direction) is positive definite where 1 + s·λ > 0 for every generalised eigenvalue λ.
    """
    n = 10 * len(device.massive)
    slowest = _eigenvalues(pi[:n].reshape(-1, 10), direction[:n].reshape(-1, 10)).ravel()
    with np.errstate(divide="ignore"):
        rotors = np.where(pi[n:] > 0, direction[n:] / np.maximum(pi[n:], 1e-300), 0.0)
    rates = np.concatenate([slowest, rotors])
    falling, rising = rates.min(initial=0.0), rates.max(initial=0.0)
    return (-1.0 / rising if rising > 0 else -np.inf), (-1.0 / falling if falling < 0 else np.inf)


def _eigenvalues(bodies: Array, directions: Array) -> Array:
    """Return the eigenvalues of L⁻¹·J(direction)·L⁻ᵀ with J(body) = L·Lᵀ, for n bodies (n, 10), shape (n, 4)."""
    # All bodies at once: one call of LAPACK for each would take most of the time of a draw.
    L = np.linalg.cholesky(_pseudo_inertias(bodies))
    half = np.linalg.solve(L, _pseudo_inertias(directions))
    whitened = np.linalg.solve(L, half.swapaxes(1, 2))
    return np.asarray(np.linalg.eigvalsh((whitened + whitened.swapaxes(1, 2)) / 2))


def _pseudo_inertias(bodies: Array) -> Array:
    """Return J of n bodies (n, 10), shape (n, 4, 4)."""
    return np.einsum("kab,nk->nab", _OF_UNIT_BODIES, bodies)
