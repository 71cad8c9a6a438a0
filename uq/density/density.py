"""The posterior density that everything else here samples, maximises or scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import Terms, linearise, scatter_columns
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.forward import Forward
from haptid.uq.density.likelihood import log_likelihood


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """log p(η | runs) up to a constant, for many η at once.

    Parameters
    ----------
    coordinates
        What is sampled, with priors.
    model
        The random parts of the data.
    terms
        The fitted runs, linearised in their nuisances.
    forward
        Simulates a run for many parameter sets.
    """

    coordinates: Coordinates
    model: NoiseModel
    terms: tuple[Terms, ...]
    forward: Forward

    @property
    def equations(self) -> Equations:
        """The equations that are simulated."""
        return self.coordinates.equations

    def hyper(self, eta: Array) -> dict[str, Array]:
        """Values of the noise model's parameters by id, shape (n_sets,) each."""
        values = self.coordinates.values(eta)
        first = len(self.coordinates.free)
        return {h.id: values[:, first + i] for i, h in enumerate(self.coordinates.hyper)}

    def simulated(self, eta: Array, terms: Terms) -> Array:
        """Positions (n_sets, n_t) from the start around which ``terms`` is linear."""
        return self.forward(self.coordinates.thetas(eta), terms.run, terms.x0)

    def log_likelihoods(self, eta: Array, simulated: Sequence[Array] | None = None) -> Array:
        """Log marginal likelihood of each run, shape (n_sets, n_runs); ``simulated`` where it is known already."""
        thetas, hyper = self.coordinates.thetas(eta), self.hyper(eta)
        positions = simulated or [self.simulated(eta, terms) for terms in self.terms]
        columns = [
            log_likelihood(terms, self.model, self.equations, thetas, hyper, y)
            for terms, y in zip(self.terms, positions, strict=True)
        ]
        return np.stack(columns, axis=1)

    def __call__(self, eta: Array) -> Array:
        """Log posterior of η (n_sets, n), shape (n_sets,); −inf outside the prior."""
        eta = np.atleast_2d(eta)
        out = self.coordinates.log_prior(eta)
        inside = np.isfinite(out)
        if inside.any():
            out[inside] += self.log_likelihoods(eta[inside]).sum(axis=1)
        return np.where(np.isnan(out), -np.inf, out)

    def linearised(self, simulator: Simulator, eta: Array) -> Density:
        """Return a copy whose fixed columns and corrections of the inner step are taken at η (n,)."""
        theta = self.coordinates.thetas(eta)
        made = []
        for terms in self.terms:
            scattered = scatter_columns(terms, simulator, theta, self.model)
            trajectory = simulator.simulate(theta, terms.run, x0=terms.x0, sensitivities=True)
            correction = self.forward.shortfall(theta[None], terms.run, terms.x0)[0]
            made.append(linearise(scattered, trajectory).but(correction=correction))
        return replace(self, terms=tuple(made))

    def but(self, **changes: Any) -> Density:
        """Return a copy with ``changes``."""
        return replace(self, **changes)
