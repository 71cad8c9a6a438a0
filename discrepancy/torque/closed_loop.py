"""Refit of a driven joint by simulation through its controller: `TorqueFit` in, `ClosedLoop` out.

The torque fit stands near the minimum of the simulated position, whose other minima a fit from first guesses may end
in. From there, and from starts around it, all parameters, those of the drive too, are fitted to the positions of the
fitted runs; the start with the least cost counts. Errors of the position are counted from the measured start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.discrepancy.fit.whitened import OPTIONS
from haptid.discrepancy.torque.fit import TorqueFit, descend_from_all, rms
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Array, Run
from haptid.model.friction.registry import law_named


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """A model simulated through the recorded controller.

    Parameters
    ----------
    values
        Parameters by id, those of the drive too.
    mean_absolute, rms
        Mean over the runs of each use, ``fit`` or ``validate``, of the mean absolute and the RMS error of the position
        [rad], or [m] of a prismatic joint; a use without runs is left out.
    """

    values: Mapping[str, float]
    mean_absolute: Mapping[str, float]
    rms: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """Convert to ``closed_loop`` of the finding's JSON.

        Returns
        -------
        dict
            ``mean_absolute`` and ``rms`` [rad], or [m] of a prismatic joint, by use.
        """
        return {use: {"mean_absolute": self.mean_absolute[use], "rms": self.rms[use]} for use in self.rms}


def refit_through_controller(model: TorqueFit, *, starts: int, seed: int) -> ClosedLoop | None:
    """Fit a model to the positions of the fitted runs, simulated through the controller.

    Parameters
    ----------
    model
        Fit to the torque, at which the refit starts.
    starts
        Number of starts around it, the further ones by a Sobol sequence.
    seed
        Seed of the starts.

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
    # Where the torque leaves no Coulomb friction, a descent hardly moves: the second start has that of the first guess.
    roles = law_named(equations.friction[0]).roles
    guessed = {id: study.base.parameter(id).initial for id in {roles.coulomb, roles.stiction}}
    first, second = (np.array([start[q.id] for q in equations.parameters]) for start in (values, values | guessed))
    thetas = [*sobol_starts(problem.parametrisation, first, starts, seed), second]
    best = min(descend_from_all(problem, thetas, threads=study.threads), key=lambda descent: descent.cost)
    if not np.isfinite(best.cost):
        return None
    theta = problem.theta(best.x)
    errors: dict[str, list[Array]] = {}
    for run in study.recorded:
        errors.setdefault(run.use, []).append(_error(simulator, theta, run))
    return ClosedLoop(
        values={q.id: float(value) for q, value in zip(equations.parameters, theta, strict=True)},
        mean_absolute={use: float(np.mean([np.mean(np.abs(e)) for e in some])) for use, some in errors.items()},
        rms={use: float(np.mean([rms(e) for e in some])) for use, some in errors.items()},
    )


def _error(simulator: KernelSimulator, theta: Array, run: Run) -> Array:
    return (run.y - simulator.simulate(theta, run).y)[run.scored, 0]
