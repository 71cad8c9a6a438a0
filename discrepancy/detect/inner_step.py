"""Choose the inner step of the readings: `Study` and `Solution` in, step [s] out.

Halving a step h changes the readings by e = (y_h − y_{h/2})/σ. The part of e that no parameter can reproduce, P·e with
P off the tangent space of the fitted model, adds ‖P·e‖² to the χ² of the residual whatever the data. It has to stay
well below the spread of every test: below one square of the noise over all rows, not per row.

1. Begin at the longest step.
2. Compare the readings at the step and at half of it, projected off the tangent space.
3. Halve the step until ‖P·e‖² is below the limit, at most `most_step_halvings` times.

Where the residual is far above noise anyway, a small share of its excess is invisible too: a nominal model that misses
the readings by a thousand times the noise may stick where the joint slips, and no step follows its stops. The best
models are compared at the steps that they need themselves (`step_refinement`).

An error of time is a lag. At a step near a lag, the lag's own parameter makes up for that error, and so may a rival's:
a delay of half a step looks like a lag there and nowhere else. So effects are compared with a P that leaves their
parameters out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.fit.tangent_space import tangent_space
from haptid.discrepancy.study.simulators import Factory
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def at_step(study: Study, step: float) -> Study:
    """Return the study with another inner step.

    Parameters
    ----------
    study
        Study at any inner step.
    step
        Longest inner step of the readings [s].

    Returns
    -------
    Study
        The same study with a factory at that step.
    """
    return replace(study, factory=replace(study.factory, step=step))


def at_needed_step(study: Study, step: float) -> Study:
    """Return the study at the inner step that its motion needs, with sensitivities and first tries that follow it.

    A slope that is integrated at many times the step of the readings is that of another motion where bristles settle
    within it, and a fit along it ends beside the minimum.

    Parameters
    ----------
    study
        Study at any inner step.
    step
        Longest inner step of the readings [s].

    Returns
    -------
    Study
        Its coarse step is at most `longest_coarse_step_over_needed` times that of the readings.
    """
    coarse = THRESHOLDS.study.longest_coarse_step_over_needed * step
    share = min(1.0, coarse / THRESHOLDS.study.coarse_step_s)
    return replace(study, factory=Factory(step, share))


def readings(study: Study, solution: Solution, step: float) -> Array:
    """Simulate the readings of all fitted runs at the optimum of ``solution``.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    step
        Inner step [s].

    Returns
    -------
    ndarray
        Whitened readings over the sensor's standard deviation, shape (n_r,).
    """
    simulator = replace(study.factory, step=step)(solution.equations)
    rows = [
        whiten(simulator.simulate(solution.theta, run, x0=x0).y / run.sensor_std).ravel()
        for run, x0, whiten in zip(study.fitted, solution.x0, solution.problem.whiteners, strict=True)
    ]
    return np.concatenate(rows)


def visible(study: Study, solution: Solution, step: float) -> float:
    """Return the visible error of an inner step.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    step
        Inner step h [s].

    Returns
    -------
    float
        ‖P·(y_h − y_{h/2})/σ‖², with P off the tangent space of nominal parameters and initial states alone.
    """
    change = readings(study, solution, step) - readings(study, solution, step / 2)
    return off_tangent_space(solution, change)


def off_tangent_space(solution: Solution, change: Array) -> float:
    """Return how much of a change of the readings no parameter of the nominal model can reproduce.

    Parameters
    ----------
    solution
        Fitted model.
    change
        Whitened change e of the readings over the noise, shape (n_r,).

    Returns
    -------
    float
        ‖P·e‖², with P off the tangent space of nominal parameters and initial states alone.
    """
    Q = tangent_space(solution, without={q.id for e in solution.effects for q in e.parameters})
    e = np.zeros(Q.shape[0])
    # The rows of the priors come last and do not depend on the simulation.
    e[: change.size] = change
    e -= Q @ (Q.T @ e)
    return float(e @ e)


def step_for(
    study: Study, solution: Solution, first: float = THRESHOLDS.study.coarse_step_s, share: float = 0.0
) -> float:
    """Return the longest inner step whose error is invisible.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    first
        Longest step that is tried [s].
    share
        Share of the excess of the solution's χ² over noise that counts as invisible too.

    Returns
    -------
    float
        The longest ``first``/2ᵏ [s] with an invisible error, or the shortest step where none has one.
    """
    step = first
    limit = max(THRESHOLDS.detect.invisible_step_error_chi2, share * (solution.chi2 - solution.residual.size))
    for _ in range(THRESHOLDS.detect.most_step_halvings):
        if visible(study, solution, step) < limit:
            break
        step /= 2
    return step
