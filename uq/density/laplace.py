"""Laplace approximation of the posterior: `Density` and a start η in, mode and covariance (`Laplace`) out.

Each round of the climb to the mode

1. linearises the initial states and the scatter columns at the present point, and moves the initial states to their
   conditional means,
2. climbs in the free parameters by the Levenberg–Marquardt steps of the fits,
3. climbs in the noise parameters by Nelder–Mead, which needs no further simulation,

until a round changes the log posterior by less than `Climb.change`. The ensembles start from the approximation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import minimize

from haptid.identification.optimise.levenberg_marquardt import Trial, minimise
from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array
from haptid.support.errors import NumericalError
from haptid.support.linear_algebra import inverse, root_of_inverse
from haptid.uq.density.density import Density
from haptid.uq.density.normal_equations import expand
from haptid.uq.thresholds import THRESHOLDS

ORDERING_MARGIN = 1e-4
"""Least difference of the coordinates of two ordered parameters [1]: the density is 0 beyond equality."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Climb:
    """How far a climb to the mode goes.

    Parameters
    ----------
    rounds
        Most rounds.
    steps
        Most points that Levenberg–Marquardt tries in a round.
    tolerance
        Predicted decrease of −2·log posterior [1] below which Levenberg–Marquardt ends.
    change
        Change of the log posterior [1] in a round below which the climb has converged.
    noise
        Change of the log posterior [1] below which a climb in the noise parameters alone has converged.
    worth
        Log posterior [1] that the climb has to come to: one that would not at its present pace, ends.
    """

    rounds: int = 20
    steps: int = 24
    tolerance: float = 0.01
    change: float = THRESHOLDS.largest_last_change_of_log_posterior
    noise: float = 1e-3
    worth: float = -np.inf

    def ends(self, rounds: int, value: float, before: float) -> bool:
        """Say whether a climb ends after a round.

        Parameters
        ----------
        rounds
            Rounds that are done.
        value, before
            Log posterior after this round and after the one before; −inf where there was none.

        Returns
        -------
        bool
        """
        hopeless = value + (self.rounds - rounds) * (value - before) < self.worth
        return abs(value - before) < self.change or hopeless


THOROUGH = Climb()
"""Climb of a posterior whose length nobody limits."""
SHORT = Climb(
    steps=12,
    tolerance=2 * THRESHOLDS.largest_last_change_of_short_climb,
    change=THRESHOLDS.largest_last_change_of_short_climb,
    noise=THRESHOLDS.largest_last_change_of_short_climb / 10,
)
"""Climb of a short sampling: far enough to tell noise models apart, and for ensembles to start from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Laplace:
    """Normal approximation of the posterior at its mode.

    Parameters
    ----------
    eta
        Mode, shape (n,).
    covariance
        Inverse of the expected information of the data plus the information of the prior, shape (n, n).
    density
        Posterior density with starts and columns linearised at the mode.
    log_density
        Log posterior density at the mode, up to the constant of `Density`.
    """

    eta: Array
    covariance: Array
    density: Density
    log_density: float

    @property
    def lower(self) -> Array:
        """Lower Cholesky factor of the covariance, shape (n, n)."""
        return np.asarray(np.linalg.cholesky(self.covariance), dtype=np.float64)


def lowest_reached(log_density: float, n: int) -> float:
    """Return the log density down to which the posterior reaches a point: 2·n + 10 below its largest value.

    Parameters
    ----------
    log_density
        Largest log posterior density.
    n
        Number of coordinates.

    Returns
    -------
    float
        Of a normal density hardly one draw in 10⁶ lies below.
    """
    return log_density - 2.0 * n - 10.0


def laplace(density: Density, simulator: Simulator, eta: Array, *, climb: Climb = THOROUGH) -> Laplace:
    """Climb from η to the mode: Levenberg–Marquardt in the parameters and Nelder–Mead in the noise model, in turns.

    Parameters
    ----------
    density
        Posterior density.
    simulator
        Simulator with sensitivities, of the same equations.
    eta
        Start, shape (n,).
    climb
        How far the climb goes.

    Returns
    -------
    Laplace
        Mode, covariance and log density there, with the density linearised at the mode.

    Raises
    ------
    NumericalError
        Where the density is not finite at η.
    """
    best = -np.inf
    for done in range(1, climb.rounds + 1):
        density = expand(density.linearise(simulator, eta), simulator, eta).density
        eta = _climb_noise(density, _climb_parameters(density, simulator, eta, climb), climb)
        value = float(density(eta)[0])
        if climb.ends(done, value, best):
            break
        best = value
    density = density.linearise(simulator, eta)
    value = float(density(eta)[0])
    if not np.isfinite(value):
        msg = f"{density.equations.name}: the posterior density is not finite at the fit"
        raise NumericalError(msg)
    return Laplace(eta=eta, covariance=covariance(density, simulator, eta), density=density, log_density=value)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Cost:
    """−2·log posterior over the free parameters s (n_free,), with the noise parameters of η; satisfies `Cost`."""

    density: Density
    simulator: Simulator
    eta: Array

    def with_parameters(self, s: Array) -> Array:
        """Return η with the free parameters s."""
        return np.concatenate([s, self.eta[s.size :]])

    def at(self, s: Array) -> Trial:
        cost = -2.0 * float(self.density(self.with_parameters(s))[0])
        return Trial(cost=cost, excess=0.0, triangle=partial(self._triangle, s))

    def _triangle(self, s: Array) -> tuple[Array, Array]:
        eta, n = self.with_parameters(s), s.size
        likelihood = expand(self.density, self.simulator, eta)
        prior_gradient, prior_curvature = _prior_slopes(self.density, eta)
        H = likelihood.information + np.diag(prior_curvature[:n])
        g = likelihood.gradient + prior_gradient[:n]
        if not (np.isfinite(H).all() and np.isfinite(g).all()):
            return np.zeros((n, n)), np.zeros(n)  # predicts no decrease: the climb ends here
        root = root_of_inverse(H)
        return triangle(np.asarray(np.linalg.inv(root), dtype=np.float64), -root.T @ g)

    def constraints(self, s: Array) -> tuple[Array, Array]:
        parametrisation = self.density.coordinates.parametrisation
        A, b = parametrisation.constraints()
        b[len(b) - len(parametrisation.orderings()[1]) :] += ORDERING_MARGIN
        return A, np.minimum(b - A @ s, 0.0)

    def move(self, s: Array, d: Array) -> Array:
        """Return s + d, slightly inside the bounds, beyond which rounding would make the density 0."""
        lower, upper = self.density.coordinates.parametrisation.bounds
        room = np.minimum(1e-6 * (upper - lower), 1e-6)
        return np.clip(s + d, lower + room, upper - room)


def _climb_parameters(density: Density, simulator: Simulator, eta: Array, climb: Climb) -> Array:
    """Return η (n,) with the free parameters of largest posterior density for its noise parameters."""
    cost = _Cost(density=density, simulator=simulator, eta=eta)
    parametrisation = density.coordinates.parametrisation
    start = parametrisation.put_in_order(eta[: len(parametrisation.free)], ORDERING_MARGIN)
    start = cost.move(start, np.zeros_like(start))
    return cost.with_parameters(minimise(cost, start, iterations=climb.steps, tolerance=climb.tolerance).x)


def _prior_slopes(density: Density, eta: Array) -> tuple[Array, Array]:
    """Return gradient and negative curvature of the log prior at η by central differences, shape (n,) each.

    Both are 0 where a difference leaves the prior's support, and the curvature where it would be negative.
    """
    h = 1e-3 * np.maximum(np.abs(eta), 1e-3)
    points = np.concatenate([eta[None], eta + np.diag(h), eta - np.diag(h)])
    p = density.coordinates.log_prior(points)
    n = eta.size
    up, down = p[1 : 1 + n], p[1 + n :]
    with np.errstate(invalid="ignore"):
        gradient, curvature = (up - down) / (2 * h), -(up - 2 * p[0] + down) / h**2
    sound = np.isfinite(gradient) & np.isfinite(curvature)
    return np.where(sound, gradient, 0.0), np.where(sound, np.maximum(curvature, 0.0), 0.0)


def _climb_noise(density: Density, eta: Array, climb: Climb) -> Array:
    """Return η (n,) with the noise parameters of largest posterior density for the simulations at η."""
    n = len(density.coordinates.free)
    misfits = density.misfits(eta)
    if not misfits:
        return eta  # no noise explains a simulation that diverged

    def negative(tail: Array) -> float:
        point = np.concatenate([eta[:n], tail])[None]
        prior = float(density.coordinates.log_prior(point)[0])
        if not np.isfinite(prior):
            return 1e30  # finite: Nelder–Mead subtracts values of its simplex
        hyper = density.hyper(point)
        return -prior - float(np.stack([misfit.log_likelihood(hyper) for misfit in misfits], axis=1).sum())

    start = eta[n:]
    simplex = np.vstack([start, start + np.eye(start.size)])
    options = {"xatol": climb.noise, "fatol": climb.noise, "maxfev": 150 * start.size, "initial_simplex": simplex}
    optimum = minimize(negative, start, method="Nelder-Mead", options=options)
    return np.concatenate([eta[:n], optimum.x if optimum.fun < negative(start) else start])


def covariance(density: Density, simulator: Simulator, eta: Array) -> Array:
    """Return the covariance of η, the inverse of the information at η.

    The information of the parameters is that of Gauss–Newton plus that of the prior; the information of the noise
    model is the negative Hessian of the log posterior by differences. Covariances between the two are 0.

    Parameters
    ----------
    density
        Posterior density, linearised at η.
    simulator
        Simulator with sensitivities, of the same equations.
    eta
        Mode, shape (n,).

    Returns
    -------
    ndarray, shape (n, n)

    Raises
    ------
    NumericalError
        Where the information is not finite, with the parameters that are to blame.
    """
    n, size = len(density.coordinates.free), eta.size
    information = expand(density, simulator, eta).information
    _, curvature = _prior_slopes(density, eta)
    total = np.zeros((size, size))
    total[:n, :n] = information
    total[n:, n:] = _noise_information(density, eta)
    lower, upper = density.coordinates.bounds()
    wide = np.zeros(size)
    # A flat prior has no curvature. Where the data say nothing either, the variance is that of a uniform distribution
    # between the bounds, width²/12, so that the information stays invertible.
    wide[:n] = 12.0 / np.minimum(upper - lower, 1e6)[:n] ** 2
    total += np.diag(np.maximum(np.append(curvature[:n], np.zeros(size - n)), wide))
    if not np.isfinite(total).all():
        lost = [name for name, row in zip(density.coordinates.names, total, strict=False) if not np.isfinite(row).all()]
        todo = "measure with more motion, or state priors or fixed values in campaign.toml"
        what = f"the likelihood has no finite curvature in {', '.join(lost[:4])} at the fit"
        msg = f"{density.equations.name}: {what}: the runs do not determine it, or do not follow the model; {todo}"
        raise NumericalError(msg)
    return inverse(total)


def _noise_information(density: Density, eta: Array, h: float = 0.05) -> Array:
    """Return the negative Hessian of the log posterior in the noise parameters, shape (k, k).

    Eigenvalues below 1/`THRESHOLDS.largest_std_of_log_noise`² are lifted to it; the matrix is returned as it is where
    it is not finite. ``h`` is the step of the differences in the logarithm of a noise parameter [1].
    """
    n = len(density.coordinates.free)
    k = eta.size - n
    simulated = [density.simulate(eta[None], terms) for terms in density.terms]
    pairs = [(a, b) for a in range(k) for b in range(a + 1)]
    shifts = [(a, b, sa, sb) for a, b in pairs for sa, sb in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
    points = np.tile(eta, (len(shifts), 1))
    for row, (a, b, sa, sb) in zip(points, shifts, strict=True):
        row[n + a] += sa * h
        row[n + b] += sb * h
    repeated = [np.repeat(y, len(points), axis=0) for y in simulated]
    values = density.coordinates.log_prior(points) + density.log_likelihoods(points, repeated).sum(axis=1)
    hessian = np.zeros((k, k))
    # Outside the support of a prior the density is 0, and the matrix is not finite.
    with np.errstate(invalid="ignore"):
        for value, (a, b, sa, sb) in zip(values, shifts, strict=True):
            hessian[a, b] -= sa * sb * value / (4 * h * h)
        hessian[b, a] = hessian[a, b]
    if not np.isfinite(hessian).all():
        return hessian
    weights, vectors = np.linalg.eigh(hessian)
    return (vectors * np.maximum(weights, 1 / THRESHOLDS.largest_std_of_log_noise**2)) @ vectors.T
