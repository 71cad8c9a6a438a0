"""Refit of a driven joint by simulation through its controller: `TorqueFit` in, `ClosedLoop` out.

The torque fit stands near the minimum of the simulated position, whose other minima a fit from first guesses may end
in. From there, and from the friction of the first guess, all parameters, those of the drive too, are fitted to the
positions of the fitted runs, first beside an observer whose gain falls (`identification.optimise.homotopy`); the start
that it leaves the least cost goes on without. Errors of the position are counted from the measured start.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.discrepancy.fit.whitened import OPTIONS
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.identification.optimise.homotopy import follow_gains
from haptid.identification.optimise.levenberg_marquardt import Descent, SumOfSquares, minimise
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import rms
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """A model simulated through the recorded controller.

    Parameters
    ----------
    values
        Parameters by id, those of the drive too.
    mean_absolute, rms
        Mean over the runs of each use, ``fit``, ``validate`` or ``sealed``, of the mean absolute and the RMS error of
        the position [rad], or [m] of a prismatic joint; a use without runs is left out.
    runs
        Number of runs of each use.
    squares
        Mean square error of the position of each run [rad²], or [m²], by use, each of shape (n_runs,).
    """

    values: Mapping[str, float]
    mean_absolute: Mapping[str, float]
    rms: Mapping[str, float]
    runs: Mapping[str, int]
    squares: Mapping[str, Array]

    def is_better_than(self, other: ClosedLoop) -> bool:
        """Whether this model simulates the recorded runs better than another, by more than the runs differ.

        Runs that neither model was fitted to tell two models apart that follow the fitted ones alike, one of them with
        more parameters. Where there are fewer than two of them, the fitted runs have to tell.

        Parameters
        ----------
        other
            The other model, simulated along the same runs.

        Returns
        -------
        bool
            Whether the mean decrease of the square error exceeds its standard error over the runs.
        """
        decreases = [other.squares[use] - self.squares[use] for use in ("validate", "fit") if use in self.squares]
        decrease = next((each for each in decreases if each.size > 1), None)
        if decrease is None:
            return False
        error = float(np.std(decrease, ddof=1)) / np.sqrt(decrease.size)
        return bool(np.mean(decrease) > THRESHOLDS.torque.least_gain_in_standard_errors * error)

    def as_json(self) -> dict[str, Any]:
        """Convert to ``closed_loop`` of the finding's JSON.

        Returns
        -------
        dict
            ``mean_absolute`` and ``rms`` [rad], or [m] of a prismatic joint, and the number of ``runs``, by use.
        """
        return {
            use: {"mean_absolute": self.mean_absolute[use], "rms": self.rms[use], "runs": self.runs[use]}
            for use in self.rms
        }


def refit_through_controller(model: TorqueFit) -> ClosedLoop | None:
    """Fit a model to the positions of the fitted runs, simulated through the controller.

    Parameters
    ----------
    model
        Fit to the torque, at which the refit starts.

    Returns
    -------
    ClosedLoop or None
        None where the study has no drive with a known controller, or the start gives no finite simulation.

    Raises
    ------
    InputError
        Where a run has a joint without sensor noise and resolution.
    NumericalError
        Where the compiler is missing or fails.
    """
    study = model.study
    if study.drive is None or not study.drive.drive.is_closed:
        return None
    values = {**model.values, **study.drive.values}
    equations = study.driven_equations(model.effects)
    # The torque constant and the resistance are free here, and the plant gain cannot be told from them.
    if not all(q.fixed for q in study.drive.rows):
        equations = equations.with_parameters({"Kp": {"initial": values["Kp"], "fixed": True}})
    simulator = KernelSimulator.of(equations)
    fitted = tuple(run for run in study.recorded if run.use == "fit")
    problem = Problem.of(simulator, fitted, OPTIONS)
    # Where the torque leaves no Coulomb friction, or bristles as long as the travel, a descent hardly moves: the second
    # start has the friction of the first guess.
    guessed = study.guessed_friction
    thetas = [np.array([start[q.id] for q in equations.parameters]) for start in (values, values | guessed)]
    gains = IDENTIFICATION.observer_gains_beside_controller
    near = map_threads(lambda theta: _follow(problem, theta, gains[:-1]), thetas, threads=study.threads)
    best = minimise(
        SumOfSquares.of(problem, gains[-1]),
        min(near, key=lambda descent: descent.cost).x,
        iterations=THRESHOLDS.torque.most_simulations_of_start,
        relative=THRESHOLDS.torque.least_decrease_of_cost,
        tolerance=0.0,
    )
    if not np.isfinite(best.cost):
        return None
    return _judge(study, simulator, problem.theta(best.x))


def _judge(study: TorqueStudy, simulator: KernelSimulator, theta: Array) -> ClosedLoop:
    """Simulate all runs through the controller, and sum up their position errors by use."""
    errors: dict[str, list[Array]] = {}
    for run in study.recorded:
        errors.setdefault(run.use, []).append(_error(simulator, theta, run))
    for run in study.recorded_sealed:
        errors.setdefault("sealed", []).append(_error(simulator, theta, run))
    equations = simulator.equations
    return ClosedLoop(
        values={q.id: float(value) for q, value in zip(equations.parameters, theta, strict=True)},
        mean_absolute={use: float(np.mean([np.mean(np.abs(e)) for e in some])) for use, some in errors.items()},
        rms={use: float(np.mean([rms(e) for e in some])) for use, some in errors.items()},
        runs={use: len(some) for use, some in errors.items()},
        squares={use: np.array([np.mean(e**2) for e in some]) for use, some in errors.items()},
    )


def _follow(problem: Problem, theta: Array, gains: Sequence[float]) -> Descent:
    """Follow a start through falling observer gains [1/s]."""

    def minimise_at(x: Array, gain: float, _: int) -> Descent:
        return minimise(
            SumOfSquares.of(problem, gain),
            x,
            iterations=IDENTIFICATION.most_iterations_of_early_level,
            relative=IDENTIFICATION.tolerance_of_early_level,
            tolerance=0.0,
        )

    return follow_gains(Descent.at(problem.unknowns_at(theta)), gains, minimise_at)


def _error(simulator: KernelSimulator, theta: Array, run: Run) -> Array:
    return (run.y - simulator.simulate(theta, run).y)[run.scored, 0]
