"""The least-squares problem of a fit: `Simulator`, `Run`s and `FitOptions` in, `Problem` out.

A `Problem` maps the unknowns x to whitened residuals r and their Jacobian (`Blocks`); its cost is ‖r‖².

x = (s, δ₁, …, δ_K): scaled parameters (`Parametrisation`), then the initial states of each run (`Start`).
r = (√λ·(y_meas − y_sim)/σ for every row, run and joint; velocity priors δ; parameter priors (p − mean)/std).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from haptid.identification.problem.initial_states import Start, start_of
from haptid.identification.problem.loss import pseudo_huber
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.problem.weights import time_weights
from haptid.identification.simulators.protocol import Simulator, Trajectory
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class Blocks:
    """Whitened residuals by run, in the order of time, and residuals of the priors.

    Parameters
    ----------
    rows
        Residuals √λ·(y_meas − y_sim)/σ by run, shape (n_t, n_y) each.
    jacobians
        ∂r/∂x by run, shape (n_t, n_y, n) each, or None without derivatives.
    prior, prior_jacobian
        Residuals of the priors, shape (n_prior,), and their Jacobian, shape (n_prior, n).
    """

    rows: tuple[Array, ...]
    jacobians: tuple[Array, ...] | None
    prior: Array
    prior_jacobian: Array

    @property
    def residual(self) -> Array:
        """All residuals, shape (n_r,)."""
        return np.concatenate([*(r.ravel() for r in self.rows), self.prior])

    @property
    def jacobian(self) -> Array:
        """Jacobian of `residual`, shape (n_r, n)."""
        n = self.prior_jacobian.shape[1]
        return np.concatenate([*(j.reshape(-1, n) for j in self.jacobians or ()), self.prior_jacobian])


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """Least-squares problem of some runs and one simulator; picklable, so that starts can run in other processes.

    Parameters
    ----------
    simulator
        Model that simulates the runs.
    parametrisation
        Free parameters of the simulator's equations and their scales.
    runs
        Runs whose residuals count.
    starts
        Initial states of the runs as nuisance parameters.
    roots
        Roots √λ of the time weights by run, shape (n_t,) each.
    options
        Choices of the fit: weights, priors, loss, gains.
    """

    simulator: Simulator
    parametrisation: Parametrisation
    runs: tuple[Run, ...]
    starts: tuple[Start, ...]
    roots: tuple[Array, ...]
    options: FitOptions
    threads: int = 1
    """Threads that simulate the runs side by side; the results do not depend on it."""

    @classmethod
    def of(cls, simulator: Simulator, runs: tuple[Run, ...], options: FitOptions) -> Problem:
        """Build the problem: scale the parameters, choose the initial states and weight the rows.

        Parameters
        ----------
        simulator
            Model that simulates the runs.
        runs
            Runs to fit, whatever their ``use``.
        options
            Choices of the fit.

        Returns
        -------
        Problem

        Raises
        ------
        InputError
            Where a run has a joint without sensor noise and resolution, because residuals are divided by their σ.
        """
        equations = simulator.equations
        for run in runs:
            if not bool(np.all(run.sensor_std > 0)):
                raise InputError(
                    run.file,
                    expected="sensor noise or resolution above 0",
                    got=str(run.sensor_std),
                    todo="estimate it with measurement.checks.preparation.prepare, or state it under [sensor]",
                )
        return cls(
            simulator=simulator,
            parametrisation=Parametrisation.of(equations),
            runs=runs,
            starts=tuple(start_of(equations, run, free_velocity=options.free_velocity) for run in runs),
            roots=tuple(np.sqrt(time_weights(run, options.weights)) for run in runs),
            options=options,
        )

    @property
    def n_parameters(self) -> int:
        """Number of scaled parameters."""
        return len(self.parametrisation.free)

    @property
    def size(self) -> int:
        """Length of x."""
        return self.n_parameters + sum(len(start.states) for start in self.starts)

    @property
    def weight(self) -> float:
        """Sum Σλ of the weights over rows and joints; cost/Σλ is the weighted mean square over the noise."""
        return float(sum((root**2).sum() * run.y.shape[1] for root, run in zip(self.roots, self.runs, strict=True)))

    def slices(self) -> tuple[slice, ...]:
        """Locate the initial states of the runs within x.

        Returns
        -------
        tuple of slice
            Slice of x that holds the initial state of each run, in the order of the runs.
        """
        edges = np.cumsum([self.n_parameters, *(len(start.states) for start in self.starts)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(edges))

    def theta(self, x: Array) -> Array:
        """Return the physical parameters of the unknowns.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        ndarray, shape (n_p,)
            θ in the order of ``equations.parameters``.
        """
        return self.parametrisation.physical(x[: self.n_parameters])

    def x0(self, x: Array) -> tuple[Array, ...]:
        """Return the initial state of every run.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        tuple of ndarray
            Initial states in the order of the runs, shape (n_x,) each.
        """
        return tuple(start.at(x[part]) for start, part in zip(self.starts, self.slices(), strict=True))

    def unknowns_at(self, theta: Array) -> Array:
        """Return the unknowns at given parameters, with every run started at δ = 0 or at the state of the options.

        Parameters
        ----------
        theta
            Parameters in the order of ``equations.parameters``, shape (n_p,).

        Returns
        -------
        ndarray, shape (n,)
            Unknowns x.
        """
        x = np.zeros(self.size)
        x[: self.n_parameters] = self.parametrisation.to_coordinates(theta)
        for run, start, part in zip(self.runs, self.starts, self.slices(), strict=True):
            state = self.options.states.get(run.file, ())
            if len(state) == start.base.size:
                x[part] = start.delta_of(np.array(state))
        return x

    def constraints(self) -> tuple[Array, Array]:
        """Write finite bounds and orderings as linear inequalities A·x ≥ b.

        Returns
        -------
        A : ndarray, shape (n_c, n)
            Coefficients; those of initial states are 0.
        b : ndarray, shape (n_c,)
            Limits.
        """
        A, b = self.parametrisation.constraints()
        return np.pad(A, ((0, 0), (0, self.size - self.n_parameters))), b

    def blocks(self, x: Array, gain: float = 0.0, *, jacobian: bool = True) -> Blocks:
        """Simulate every run at x and form whitened residuals and their Jacobian.

        Parameters
        ----------
        x
            Unknowns, shape (n,).
        gain
            Observer gain L [1/s]; 0 simulates freely.
        jacobian
            Whether the simulator's sensitivities are used to form ∂r/∂x.

        Returns
        -------
        Blocks
        """
        theta = self.theta(x)
        slope = self.parametrisation.slope(theta)
        rows, jacobians = [], []
        simulated = self._trajectories(x, theta, gain, sensitivities=jacobian)
        for run, start, root, part, y in zip(self.runs, self.starts, self.roots, self.slices(), simulated, strict=True):
            scale = root[:, None] / run.row_std
            r = scale * (run.y - y.y[:, : run.y.shape[1]])
            outer = np.ones_like(r)
            # The loss turns residuals in units of the noise, so that it comes after the whitening.
            if self.options.robust:
                r, outer = pseudo_huber(r)
            rows.append(r)
            if jacobian and y.dy_dtheta is not None and y.dy_dx0 is not None:
                J = np.zeros((*r.shape, self.size))
                ny = r.shape[1]
                factor = (-scale * outer)[..., None]
                J[..., : self.n_parameters] = factor * (y.dy_dtheta[:, :ny, list(self.parametrisation.free)] * slope)
                J[..., part] = factor * (y.dy_dx0[:, :ny, list(start.states)] * start.unit)
                jacobians.append(J)
        prior, prior_jacobian = self._priors(x, theta, slope)
        return Blocks(
            rows=tuple(rows),
            jacobians=tuple(jacobians) if jacobian else None,
            prior=prior,
            prior_jacobian=prior_jacobian,
        )

    def _trajectories(self, x: Array, theta: Array, gain: float, *, sensitivities: bool) -> list[Trajectory]:
        """Simulate every run from its start."""

        def one(run: Run, x0: Array) -> Trajectory:
            return self.simulator.simulate(theta, run, x0=x0, gain=gain, sensitivities=sensitivities)

        return map_threads(one, self.runs, self.x0(x), threads=self.threads)

    def _priors(self, x: Array, theta: Array, slope: Array) -> tuple[Array, Array]:
        """Return residuals (p − mean)/std of parameters and δ of initial states with a prior, and their Jacobian."""
        residuals, rows = [], []
        for k, (i, q) in enumerate(zip(self.parametrisation.free, self.parametrisation.quantities, strict=True)):
            if self.options.priors and q.prior is not None:
                row = np.zeros(self.size)
                row[k] = slope[k] / q.prior.std
                rows.append(row)
                residuals.append((theta[i] - q.prior.mean) / q.prior.std)
        for start, part in zip(self.starts, self.slices(), strict=True):
            for place in np.flatnonzero(start.prior) + part.start:
                row = np.zeros(self.size)
                row[place] = 1.0
                rows.append(row)
                residuals.append(float(x[place]))
        return np.array(residuals), np.array(rows).reshape(len(rows), self.size)
