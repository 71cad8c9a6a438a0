"""The posterior density that the other modules sample, maximise or score: coordinates, noise model and runs in."""

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
from haptid.uq.density.likelihood import Misfit, log_likelihood


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """log p(η | runs) up to a constant, for many η at once.

    Parameters
    ----------
    coordinates
        Coordinates η with their priors.
    model
        Random parts of the data.
    terms
        The fitted runs, linearised in their initial states and in a scatter on the torque.
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
        """Return the values of the noise model's parameters.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n).

        Returns
        -------
        dict
            Values by id, shape (n_sets,) each.
        """
        values = self.coordinates.values(eta)
        first = len(self.coordinates.free)
        return {h.id: values[:, first + i] for i, h in enumerate(self.coordinates.hyper)}

    def simulate(self, eta: Array, terms: Terms) -> Array:
        """Simulate a run from the start around which ``terms`` is linear.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n).
        terms
            The run.

        Returns
        -------
        ndarray, shape (n_sets, n_t)
            Positions [rad], NaN where a simulation diverged.
        """
        return self.forward(self.coordinates.thetas(eta), terms.run, terms.x0)

    def log_likelihoods(self, eta: Array, simulated: Sequence[Array] | None = None) -> Array:
        """Return the log marginal likelihood of each fitted run.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n).
        simulated
            Positions of every run at η [rad], shape (n_sets, n_t) each; simulated here where None.

        Returns
        -------
        ndarray, shape (n_sets, n_runs)
            ln p(run | η), the initial state and the amplitudes of cycles integrated out.
        """
        thetas, hyper = self.coordinates.thetas(eta), self.hyper(eta)
        positions = simulated or [self.simulate(eta, terms) for terms in self.terms]
        columns = [
            log_likelihood(terms, self.model, self.equations, thetas, hyper, y)
            for terms, y in zip(self.terms, positions, strict=True)
        ]
        return np.stack(columns, axis=1)

    def misfits(self, eta: Array) -> tuple[Misfit, ...]:
        """Simulate every fitted run at one point, for densities that differ in the noise parameters alone.

        Parameters
        ----------
        eta
            Coordinates, shape (n,).

        Returns
        -------
        tuple of Misfit
            One a run; empty where a simulation diverged.
        """
        thetas = self.coordinates.thetas(eta[None])
        simulated = [self.simulate(eta[None], terms) for terms in self.terms]
        if not all(np.isfinite(y).all() for y in simulated):
            return ()
        return tuple(
            Misfit.of(terms, self.model, self.equations, thetas, y)
            for terms, y in zip(self.terms, simulated, strict=True)
        )

    def __call__(self, eta: Array) -> Array:
        """Return the log posterior density of η up to a constant.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n) or (n,).

        Returns
        -------
        ndarray, shape (n_sets,)
            −inf outside the prior's support and where a simulation diverged.
        """
        eta = np.atleast_2d(eta)
        out = self.coordinates.log_prior(eta)
        inside = np.isfinite(out)
        if inside.any():  # simulations are the cost: none outside the prior's support
            out[inside] += self.log_likelihoods(eta[inside]).sum(axis=1)
        return np.where(np.isnan(out), -np.inf, out)  # a diverged K gives NaN (`noise.marginal`), which emcee refuses

    def linearise(self, simulator: Simulator, eta: Array) -> Density:
        """Return a copy whose fixed columns and corrections of the inner step are taken at η.

        Parameters
        ----------
        simulator
            Simulator with sensitivities, of the same equations.
        eta
            Coordinates, shape (n,).

        Returns
        -------
        Density
            Copy whose terms are taken anew, by one simulation with sensitivities of every run and, for a scatter on the
            torque, two of every cycle.
        """
        theta = self.coordinates.thetas(eta)
        made = []
        for terms in self.terms:
            scattered = scatter_columns(terms, simulator, theta, self.model)
            trajectory = simulator.simulate(theta, terms.run, x0=terms.x0, sensitivities=True)
            correction = self.forward.shortfall(theta[None], terms.run, terms.x0)[0]
            made.append(linearise(scattered, trajectory).but(correction=correction))
        return replace(self, terms=tuple(made))

    def but(self, **changes: Any) -> Density:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Density
            The copy.
        """
        return replace(self, **changes)
