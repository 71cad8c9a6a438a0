"""Posterior density of an FMU's parameters: simulator and runs in, `ForeignDensity` out.

log p(η) = log prior − (N·ln ν + ½·Σ (r/ν)²)/τ, with r the residuals in units of the noise, N their number, ν a factor
on the noise, and τ the correlation time of the residuals at the fit: N/τ of them are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.calibration.simulator import ForeignSimulator
from haptid.measurement.values.run import Array, Run
from haptid.noise.hyper import noise_factor, noise_prior_width
from haptid.noise.noise_model import NoiseModel
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.density import Density
from haptid.uq.density.forward import EachForward
from haptid.uq.density.laplace import Laplace


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignDensity(Density):
    """log p(η | runs) up to a constant; the noise factor is the last coordinate.

    Parameters
    ----------
    simulator
        The FMU.
    runs
        Fitted runs.
    correlation_time
        τ [rows], at least 1.
    """

    simulator: ForeignSimulator
    runs: tuple[Run, ...]
    correlation_time: float

    def log_likelihoods(self, eta: Array, simulated: Sequence[Array] | None = None) -> Array:  # noqa: ARG002 # see `Density`
        """Return the log likelihood of each run.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n).
        simulated
            Not used: every run is simulated here.

        Returns
        -------
        ndarray, shape (n_sets, n_runs)
            −∞ where the FMU refuses the parameters.

        Raises
        ------
        NumericalError
            Where the FMU ends its process, or gives no answer in time.
        """
        thetas, nu = self.coordinates.thetas(eta), self.coordinates.values(eta)[:, -1]
        made = np.empty((len(eta), len(self.runs)))
        for i, theta in enumerate(thetas):
            for k, run in enumerate(self.runs):
                r = (run.y - self.simulator.simulate(theta, run).y) / run.sensor_std
                cost = r.size * np.log(nu[i]) + 0.5 * float(np.sum(r**2)) / nu[i] ** 2
                made[i, k] = -cost / self.correlation_time if np.isfinite(cost) else -np.inf
        return made


def normal_approximation(
    simulator: ForeignSimulator,
    runs: tuple[Run, ...],
    theta: Array,
    covariance: Array,
    *,
    correlation_time: float,
    noise_given: bool,
) -> Laplace:
    """Return the normal approximation of the posterior that a fit gives.

    Parameters
    ----------
    simulator
        The FMU with its parameters, all of finite bounds.
    runs
        Fitted runs.
    theta
        Estimates, shape (n_p,).
    covariance
        Covariance of the free parameters in their units, shape (n_free, n_free).
    correlation_time
        Correlation time of the residuals [rows].
    noise_given
        Whether the noise of all outputs is stated.

    Returns
    -------
    Laplace
        With the density that the sampler needs.
    """
    equations, tau = simulator.equations, max(correlation_time, 1.0)
    coordinates = Coordinates.of(equations, (noise_factor(noise_prior_width(stated=noise_given)),))
    density = ForeignDensity(
        coordinates=coordinates,
        model=NoiseModel(),
        terms=(),
        forward=EachForward(simulator=simulator),
        simulator=simulator,
        runs=runs,
        correlation_time=tau,
    )
    squares = [((run.y - simulator.simulate(theta, run).y) / run.sensor_std) ** 2 for run in runs]
    rows = sum(part.size for part in squares)
    factor = np.sqrt(sum(float(part.sum()) for part in squares) / rows)
    slope = coordinates.parametrisation.slope(theta)
    spread = np.zeros((coordinates.size, coordinates.size))
    spread[:-1, :-1] = covariance / np.outer(slope, slope)
    spread[-1, -1] = tau / (2.0 * rows)
    eta = coordinates.eta(theta, np.array([max(factor, np.finfo(float).tiny)]))
    return Laplace(eta=eta, covariance=spread, density=density, log_density=float(density(eta)[0]))
