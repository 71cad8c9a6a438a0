"""Gauss–Newton equations of the marginal likelihood: `Density` and η in, `Expansion` out.

For every run:

1. Simulate with sensitivities, and take the columns ∂y/∂x₀ at the trajectory.
2. Build the Gram matrix of [r, J, random columns] under the inverse noise covariance.
3. Eliminate the random columns by a Schur complement: Jᵀ·C⁻¹·J (expected information) and Jᵀ·C⁻¹·r (gradient) remain.
4. Move the start of the run to the conditional mean of its initial states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array
from haptid.noise.gram import dense_columns
from haptid.noise.marginal import coefficients, eliminate
from haptid.noise.terms import Terms, column_scales, linearise
from haptid.noise.whitening import gram, whiten
from haptid.uq.density.density import Density
from haptid.uq.density.equilibrium import equilibrium


@dataclass(frozen=True, slots=True, kw_only=True)
class Expansion:
    """The log-likelihood to second order at a point.

    Parameters
    ----------
    density
        The density with the columns of the initial states taken at the point and every start moved to its conditional
        mean there.
    information
        Jᵀ·C⁻¹·J over the free parameters of the equations, summed over runs, shape (n_free, n_free).
    gradient
        Jᵀ·C⁻¹·r, shape (n_free,): the gradient of the log-likelihood at fixed noise.
    """

    density: Density
    information: Array
    gradient: Array


def expand(density: Density, simulator: Simulator, eta: Array) -> Expansion:
    """Expand the log-likelihood to second order by one simulation with sensitivities per run.

    Parameters
    ----------
    density
        Posterior density; its prior takes no part.
    simulator
        Simulator with sensitivities, of the same equations.
    eta
        Point of the expansion, shape (n,).

    Returns
    -------
    Expansion
        Information and gradient over the free parameters, initial states and amplitudes of cycles eliminated.
    """
    n = len(density.coordinates.free)
    information, gradient, moved = np.zeros((n, n)), np.zeros(n), []
    for terms in density.terms:
        fresh, full, scales = _full_gram(density, simulator, terms, eta)
        reduced = eliminate(full, scales, 1 + n)
        information += reduced[1:, 1:]
        gradient += reduced[1:, 0]
        kept = [0, *range(1 + n, full.shape[0])]  # without J: the conditional mean is that at η
        moved.append(_restart(fresh, coefficients(full[np.ix_(kept, kept)], scales)[0]))
    return Expansion(density=density.but(terms=tuple(moved)), information=information, gradient=gradient)


def run_information(density: Density, simulator: Simulator, terms: Terms, eta: Array) -> Array:
    """Return the expected information Jᵀ·C⁻¹·J of one run, random columns eliminated.

    Parameters
    ----------
    density
        Gives coordinates and noise model.
    simulator
        Simulator with sensitivities.
    terms
        The run; it need not be one of the fitted runs.
    eta
        Point at which J is taken, shape (n,).

    Returns
    -------
    ndarray, shape (n_free, n_free)
        In the coordinates η.
    """
    _, full, scales = _full_gram(density, simulator, terms, eta)
    return eliminate(full, scales, 1 + len(density.coordinates.free))[1:, 1:]


def _restart(terms: Terms, mean: Array) -> Terms:
    """Move the start by the mean of its columns' coefficients; the centre of its prior stays where it was."""
    x0, states = terms.x0.copy(), list(terms.states)
    shift = terms.start_shift + mean[: len(states)]
    x0[states] += shift
    return terms.but(x0=x0, start_shift=terms.start_shift - shift)


def _full_gram(density: Density, simulator: Simulator, terms: Terms, eta: Array) -> tuple[Terms, Array, Array]:
    """Return the linearised terms, the Gram matrix of [r, J, random columns], and the random columns' scales."""
    coordinates, model = density.coordinates, density.model
    theta, hyper = coordinates.thetas(eta), density.hyper(eta[None])
    trajectory = simulator.simulate(theta, terms.run, x0=terms.x0, sensitivities=True)
    fresh = linearise(terms, trajectory)
    y, slopes = trajectory.y[:, 0], trajectory.dy_dtheta
    assert slopes is not None  # linearise refuses a trajectory without sensitivities
    parametrisation = coordinates.parametrisation
    jacobian = slopes[:, 0, list(parametrisation.free)] * parametrisation.slope(theta)
    residual = terms.data - y - terms.start_shift @ fresh.fixed[: len(terms.states)]
    rest = equilibrium(coordinates.equations, theta[None], float(terms.data.mean()))[0]
    columns = dense_columns(fresh, model, residual, y - rest)
    stacked = np.vstack([columns[:1], jacobian.T, columns[1:]])
    noise = float(hyper["noise_factor"][0]) * terms.sensor_std
    if model.correlated:
        error, time = float(hyper["model_error"][0]), float(hyper["error_time"][0])
        keep = np.ones(terms.run.t.size, dtype=bool)
        stacked, _ = whiten(stacked, terms.run.t, noise=noise, error=error, time=time, keep=keep)
    else:
        stacked = stacked / noise
    return fresh, gram(stacked), column_scales(fresh, model, hyper)[0]
