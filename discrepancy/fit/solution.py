"""Fit nominal model and effects together under a noise model: `Study`, effects and `Noise` in, `Solution` out.

1. Lay out the least-squares problem under the noise model; a scatter is linearised about the current trajectories.
2. Move a factor that all cycles share from the scatter into the parameters (a scatter on the torque, one joint alone).
3. Minimise ‖r‖² of the whitened residual by Levenberg–Marquardt.
4. Repeat steps 1 to 3 `fits_under_scatter` times where there is scatter and the tolerance is fine.
5. Compute likelihood and Jacobian at the optimum, a scatter on the torque linearised there once more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.fit.scatter import relinearise_cycles
from haptid.discrepancy.fit.whitened import Whitened
from haptid.discrepancy.study.simulators import TwoStep
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.optimise.levenberg_marquardt import SumOfSquares, minimise
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect, id_of
from haptid.model.equations.equations import Equations
from haptid.noise.correlation import Noise, Scatter, Whitener
from haptid.support.processes.threads import map_threads

SCATTER = "amplitude_scatter"
"""Id of the random catalogue effect; it stands in the noise model and not in the equations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Optimum of a model on the fitted runs.

    Parameters
    ----------
    effects
        Effects in the equations, in SI units.
    noise
        Noise model under which the model was fitted.
    equations
        Equations of nominal model and effects.
    theta
        Parameters in the order of ``equations.parameters``, shape (n_p,).
    x0
        Initial state of every fitted run, shape (n_x,) each.
    problem
        The least-squares problem.
    x
        Optimum of the problem in scaled unknowns, shape (n,).
    raw
        Residuals over the sensor's standard deviation at the optimum, with their Jacobians, before whitening.
    blocks
        The same residuals and Jacobians after whitening.
    log_likelihood
        −½(‖r‖² + ln det C), priors included.
    calls
        Number of simulations of all runs that the fit took.
    converged
        Whether the minimiser met its tolerance.
    """

    effects: tuple[Effect, ...]
    noise: Noise
    equations: Equations
    theta: Array
    x0: tuple[Array, ...]
    problem: Whitened
    x: Array
    raw: Blocks
    blocks: Blocks
    log_likelihood: float
    calls: int
    converged: bool

    @property
    def values(self) -> dict[str, float]:
        """Parameters by id."""
        return {q.id: float(p) for q, p in zip(self.equations.parameters, self.theta, strict=True)}

    @property
    def residual(self) -> Array:
        """Whitened residuals of all fitted runs and of the priors, shape (n_r,)."""
        return self.blocks.residual

    @property
    def chi2(self) -> float:
        """‖r‖² of the whitened residual, priors included."""
        return float(self.residual @ self.residual)

    @property
    def finite(self) -> bool:
        """Whether log-likelihood and Jacobian are finite."""
        return bool(np.isfinite(self.log_likelihood) and np.isfinite(self.blocks.jacobian).all())

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the effects, including the random ones."""
        return (*(e.key for e in self.effects), *self.random)

    @property
    def touching(self) -> bool:
        """Whether an effect of the model is a contact."""
        return any(e.touches for e in self.effects)

    @property
    def random(self) -> tuple[str, ...]:
        """Keys of the random effects, in the order of the noise's scatters."""
        return tuple(random_key(self.problem.runs[0], scatter) for scatter in self.noise.scatters)

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the effects, including the random ones, each once; variants of an effect share its id."""
        return tuple(dict.fromkeys(id_of(key) for key in self.keys))


def random_key(run: Run, scatter: Scatter) -> str:
    """Return the key of a scatter: ``amplitude_scatter``, or ``joint1_amplitude_scatter`` where several joints move.

    Parameters
    ----------
    run
        Run of one or several free joints.
    scatter
        Scatter of one of them.

    Returns
    -------
    str
        The key, with the number of the joint where the run frees several.
    """
    return SCATTER if len(run.free_joints) == 1 else f"joint{run.free_joints[scatter.column]}_{SCATTER}"


def under_noise(
    simulator: TwoStep, runs: Sequence[Run], noise: Noise, theta: Array, x0: Sequence[Array], *, threads: int = 1
) -> Whitened:
    """Lay out the least-squares problem of ``runs`` under ``noise``.

    Parameters
    ----------
    simulator
        Simulator of the model.
    runs
        Runs to fit or to predict.
    noise
        Noise model; a scatter is linearised about the trajectories at ``theta`` and ``x0``.
    theta
        Parameters, shape (n_p,).
    x0
        Initial state of every run, shape (n_x,) each; not used where nothing scatters.
    threads
        Number of threads that simulate runs side by side.

    Returns
    -------
    Whitened
        Problem whose residuals have covariance 1 under ``noise``. Where a torque scatters, its runs have the torques
        and readings of `relinearise_cycles`.
    """
    if not noise.scatters:
        return Whitened.under(simulator, tuple(runs), tuple(Whitener(arma=noise.arma) for _ in runs), threads=threads)

    def one(run: Run, start: Array) -> tuple[Run, Array]:
        return relinearise_cycles(simulator, run, noise, theta, start)

    about = map_threads(one, runs, x0, threads=threads)
    whiteners = tuple(Whitener.of(noise.arma, S) for _, S in about)
    return Whitened.under(simulator, tuple(run for run, _ in about), whiteners, threads=threads)


def start_vector(equations: Equations, values: Mapping[str, float]) -> Array:
    """Return start values of all parameters.

    Parameters
    ----------
    equations
        Equations with first guesses and bounds.
    values
        Start values by id; first guesses serve for the others.

    Returns
    -------
    ndarray
        Parameters clipped to their bounds, shape (n_p,).
    """
    return np.array([min(max(values.get(q.id, q.initial), q.lower), q.upper) for q in equations.parameters])


def solve(
    study: Study,
    effects: Sequence[Effect],
    noise: Noise,
    values: Mapping[str, float],
    *,
    x0: Sequence[Array] | None = None,
    iterations: int = 40,
    tolerance: float = 0.01,
) -> Solution:
    """Fit nominal model and effects together, by Levenberg–Marquardt on whitened residuals.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units.
    noise
        Noise model; it is held during the fit.
    values
        Start values of parameters by id; the others start at their first guesses.
    x0
        Initial state of every fitted run at the start, shape (n_x,) each; None for the problem's own starts.
    iterations
        Largest number of simulations of all runs in each fit.
    tolerance
        Predicted decrease of ‖r‖², in squares over the noise, at which the fit ends. At `rough_tolerance_chi2` or
        above, a scatter is linearised once only.

    Returns
    -------
    Solution
        Optimum with its likelihood and Jacobian. `Solution.finite` says whether the simulation stayed finite.

    Notes
    -----
    A scatter's columns are linearised anew before each of `fits_under_scatter` fits. Those of a scatter on
    the torque are linearised at the optimum too, because likelihood and curvature belong to the columns at the optimum.
    """
    simulator = study.simulator(effects)
    theta = start_vector(simulator.equations, values)
    runs = study.fitted
    # The first layout only places the unknowns. A scatter needs trajectories, and so initial states, to be linearised
    # about; the loop adds it.
    problem = under_noise(simulator, runs, noise.but(scatters=()), theta, (), threads=study.threads)
    x = problem.unknowns_at(theta)
    if x0 is not None:
        x = with_starts(problem, x, x0)
    calls, converged = 0, True
    settled = tolerance < THRESHOLDS.fit.rough_tolerance_chi2
    for _ in range(THRESHOLDS.fit.fits_under_scatter if noise.scatters and settled else 1):
        problem, x = _about(study, simulator, noise, problem.theta(x), problem.x0(x))
        if study.alone and noise.on_torque:
            problem, x = _balance_common_factor(study, simulator, noise, problem, x)
        descent = minimise(SumOfSquares.of(problem), x, iterations=iterations, tolerance=tolerance)
        x, calls, converged = descent.x, calls + descent.calls, descent.converged
    if settled and noise.on_torque:
        problem, x = _about(study, simulator, noise, problem.theta(x), problem.x0(x))
    # One simulation serves both: the noise estimate needs the residuals before whitening.
    raw = Problem.blocks(problem, x)
    blocks = problem.whiten_blocks(raw)
    chi2 = float(blocks.residual @ blocks.residual)
    return Solution(
        effects=tuple(effects),
        noise=noise,
        equations=simulator.equations,
        theta=problem.theta(x),
        x0=problem.x0(x),
        problem=problem,
        x=x,
        raw=raw,
        blocks=blocks,
        log_likelihood=-0.5 * (chi2 + problem.log_determinant),
        calls=calls,
        converged=converged,
    )


def deviance(study: Study, solution: Solution, x: Array) -> float:
    """Return −2 ln L at other unknowns of a solution's problem.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Solution whose model and noise are kept.
    x
        Scaled unknowns, shape (n,); a scatter on the torque is linearised there.

    Returns
    -------
    float
        ‖r‖² + ln det C, priors included.
    """
    problem = solution.problem
    if solution.noise.on_torque:
        problem, x = _about(study, study.simulator(solution.effects), solution.noise, problem.theta(x), problem.x0(x))
    residual = problem.blocks(x, jacobian=False).residual
    return float(residual @ residual) + problem.log_determinant


def _about(
    study: Study, simulator: TwoStep, noise: Noise, theta: Array, begun: Sequence[Array]
) -> tuple[Whitened, Array]:
    """Return the problem linearised about the trajectories at ``theta``, and that point."""
    problem = under_noise(simulator, study.fitted, noise, theta, begun, threads=study.threads)
    return problem, with_starts(problem, problem.unknowns_at(theta), begun)


def _balance_common_factor(
    study: Study, simulator: TwoStep, noise: Noise, problem: Whitened, x: Array
) -> tuple[Whitened, Array]:
    """Move a factor that all cycles' torques share into the parameters, where that is more probable.

    A factor c on every torque moves the joint as 1/c on inertia, stiffness and friction does. Fits about fixed
    amplitudes creep along that valley, each as far as its linearisation reaches.
    """
    pairs = [(moved.u[:, 0], run.u[:, 0]) for moved, run in zip(problem.runs, study.fitted, strict=True)]
    factor = sum(float(m @ u) for m, u in pairs) / max(sum(float(u @ u) for _, u in pairs), 1e-300)
    if factor <= 0 or abs(factor - 1.0) < THRESHOLDS.fit.least_common_factor_over_scatter * noise.scatters[0].size:
        return problem, x
    quantities = simulator.equations.parameters
    driven = np.array([not q.fixed and _with_torque(q.unit) for q in quantities])
    theta = np.where(driven, problem.theta(x) / factor, problem.theta(x))
    theta = np.clip(theta, [q.lower for q in quantities], [q.upper for q in quantities])
    other, there = _about(study, simulator, noise, theta, problem.x0(x))
    better = _deviance(other, there) < _deviance(problem, x)
    return (other, there) if better else (problem, x)


def _with_torque(unit: str) -> bool:
    """Whether a quantity of this unit grows with the torque that moves the joint: it has newtons or kilograms."""
    return any(part in ("N", "kg") for part in unit.replace("/", " ").split())


def _deviance(problem: Whitened, x: Array) -> float:
    """Return −2 ln L at x."""
    r = problem.blocks(x, jacobian=False).residual
    return float(r @ r) + problem.log_determinant


def with_starts(problem: Whitened, x: Array, x0: Sequence[Array]) -> Array:
    """Return x with the initial states of ``x0``.

    Parameters
    ----------
    problem
        Problem whose unknowns x holds.
    x
        Scaled unknowns, shape (n,).
    x0
        Initial state of every run, shape (n_x,) each.

    Returns
    -------
    ndarray
        Copy of x, shape (n,), whose fitted initial states (position, and speed where it is fitted) are those of ``x0``.
    """
    moved = x.copy()
    for start, part, state in zip(problem.starts, problem.slices(), x0, strict=True):
        chosen = list(start.states)
        moved[part] = (np.asarray(state)[chosen] - start.base[chosen]) / start.unit
    return moved
