"""Calibration of a foreign FMU: `ForeignCampaign` and FMU in, `Calibration` out.

1. Check the campaign's names against the FMU's variables (`identification.foreign.binding`).
2. Simulate every run at the first guess: what fails here is told as the FMU says it.
3. Follow several starts to their minima, as in every other fit, with difference quotients for sensitivities.
4. Compute covariance, statuses and scores at the best minimum.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.calibration.best_minimum import polish, reach_minima
from haptid.identification.calibration.difference_steps import with_chosen_steps
from haptid.identification.calibration.remarks import remarks_on
from haptid.identification.calibration.simulator import ForeignSimulator, equations_of
from haptid.identification.fit.multistart import fit_at
from haptid.identification.foreign.binding import quantities_of
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.statistics.covariance import curvature
from haptid.identification.statistics.score import score_of
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.watched import Watched
from haptid.identification.workers.workers import Here, Processes, Tell, Workers, tell_nobody
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.measurement.values.run import Array
from haptid.support.processes.threads import single_threaded


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Result of a calibration.

    Parameters
    ----------
    campaign
        Runs and variables.
    fit
        Fit of the FMU's parameters; its ``rmse`` are by output.
    simulated
        Outputs of every run but the excluded ones at the estimates, by file, shape (n_t, n_outputs) each.
    units
        Unit of each output, empty where the FMU states none.
    simulation_s
        Duration of the simulation of all fitted runs once [s].
    remarks
        What the FMU's description says against its use here, a sentence each.
    """

    campaign: ForeignCampaign
    fit: Fit
    simulated: Mapping[str, Array]
    units: tuple[str, ...]
    simulation_s: float
    remarks: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Estimates by variable."""
        return {q.structured: float(v) for q, v in zip(self.fit.equations.parameters, self.fit.theta, strict=True)}


def simulator_of(campaign: ForeignCampaign, fmu: ForeignFmu) -> ForeignSimulator:
    """Check a campaign against its FMU and return the simulator of its runs.

    Parameters
    ----------
    campaign
        As `read_foreign_campaign` returns it.
    fmu
        The FMU, which stays open.

    Returns
    -------
    ForeignSimulator

    Raises
    ------
    InputError
        Where a variable is unknown or cannot play its part.
    """
    return ForeignSimulator(
        fmu=fmu,
        equations=equations_of(fmu.description.modelName, quantities_of(campaign, fmu)),
        outputs=campaign.outputs,
        starts=campaign.starts,
    )


def try_all_runs(campaign: ForeignCampaign, simulator: ForeignSimulator) -> float:
    """Simulate every run once at the first guess.

    Parameters
    ----------
    campaign
        Campaign about the FMU; its excluded runs are not simulated.
    simulator
        Simulator of the FMU; the first guess is the ``initial`` of its parameters.

    Returns
    -------
    float
        Duration of the fitted runs' simulations [s].

    Raises
    ------
    NumericalError
        Where the FMU fails, in its own words.
    """
    theta = np.array([q.initial for q in simulator.equations.parameters])
    took = 0.0
    for run in campaign.runs:
        if run.use != "excluded":
            simulator.fmu.start()
            begun = time.perf_counter()
            simulator.outputs_at(theta, run)
            took += (time.perf_counter() - begun) * (run.use == "fit")
    return took


def calibrate(campaign: ForeignCampaign, fmu: ForeignFmu, options: FitOptions, tell: Tell = tell_nobody) -> Calibration:
    """Identify the parameters of an FMU.

    Parameters
    ----------
    campaign
        Runs, variables and what is stated of them.
    fmu
        The FMU, which stays open.
    options
        Method, starts, seed, workers and loss of the fit.
    tell
        Told the share of the starts that is done, and figures.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        Where a variable is unknown or cannot play its part.
    NumericalError
        Where the FMU crashes or hangs, or refuses the first guess.
    """
    begun = time.perf_counter()
    simulator = simulator_of(campaign, fmu)
    took = try_all_runs(campaign, simulator)
    fitted = tuple(run for run in campaign.runs if run.use == "fit")
    first = np.array([q.initial for q in simulator.equations.parameters])
    simulator = with_chosen_steps(simulator, first, fitted)
    # An FMU has no observer, and its runs no half that weighs more.
    tolerance = max(options.tolerance, largest_residual_of_noise(sum(run.y.size for run in fitted)))
    problem = Problem.of(simulator, fitted, options.but(gains=(0.0,), weights=(1.0, 1.0), tolerance=tolerance))
    with _workers(problem, took) as workers:
        minima = single_threaded(reach_minima, problem, Watched(workers=workers, tell=tell))
    # Events may lie closer or wider at the minimum than at the first guess.
    there = with_chosen_steps(simulator, problem.theta(minima.best.x), fitted)
    problem = replace(problem, simulator=there)
    minima = single_threaded(polish, problem, minima)
    best = minima.best
    theta = problem.theta(best.x)
    simulated = {run.file: simulator.outputs_at(theta, run) for run in campaign.runs if run.use != "excluded"}
    scores = tuple(
        score_of(run, run.y - simulated[run.file], np.zeros(0)) for run in campaign.runs if run.file in simulated
    )
    bent = single_threaded(curvature, problem, best.x) if problem.n_parameters else None
    # An FMU's parameters have no gravity and no spring, whose sizes would be known.
    fit = fit_at(problem, minima, bent, scores, felt=np.full(problem.n_parameters, np.nan))
    # Each evaluation takes two more simulations for every slope.
    simulations = fit.simulations * (1 + 2 * problem.n_parameters)
    return Calibration(
        campaign=campaign,
        fit=fit.but(simulations=simulations, wall_s=time.perf_counter() - begun),
        simulated=simulated,
        units=tuple(fmu.variables[name].unit for name in campaign.outputs),
        simulation_s=took,
        remarks=remarks_on(campaign, fmu),
    )


def largest_residual_of_noise(readings: int) -> float:
    """Return the RMS over the noise that white noise alone hardly exceeds: √(1 + k·√(2/n)).

    The mean of n squares of standard normal numbers is 1, with a standard deviation of √(2/n). A joint's test has
    thousands of readings; a campaign about an FMU may have thirty, whose noise alone often is above a fixed tolerance.

    Parameters
    ----------
    readings
        Number n of readings of the fitted runs, all outputs together.

    Returns
    -------
    float
        Residual over the noise, with k of `THRESHOLDS.standard_errors_of_residual`.
    """
    return float(np.sqrt(1 + THRESHOLDS.standard_errors_of_residual * np.sqrt(2 / max(readings, 1))))


def _workers(problem: Problem, simulation_s: float) -> AbstractContextManager[Workers]:
    """Return processes only where the starts take longer than processes take to begin; no result depends on it."""
    workers = problem.options.workers
    if workers == 1 or expected_duration(problem, simulation_s) < THRESHOLDS.least_serial_duration_s:
        return nullcontext(Here())
    return Processes(workers)


def expected_duration(problem: Problem, simulation_s: float) -> float:
    """Estimate how long all starts take in one process.

    Parameters
    ----------
    problem
        Problem with parameters and starts.
    simulation_s
        Duration of the simulation of all fitted runs once [s].

    Returns
    -------
    float
        Duration [s]: simulations of central differences for `THRESHOLDS.expected_iterations_of_start` iterations a
        start.
    """
    per_iteration = simulation_s * (1 + 2 * problem.n_parameters)
    return per_iteration * THRESHOLDS.expected_iterations_of_start * problem.options.starts
