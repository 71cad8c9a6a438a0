"""The inner step of the readings: as long as its error stays invisible among all rows together.

Halving a step h changes the readings by e = (y_h − y_{h/2})/σ. What the parameters cannot make good of it, ‖P·e‖² with
P off the tangent space of the fitted model, is added to the residual's χ² whatever the data; it has to stay well below
the spread of every test: below one square of the noise over all rows, not per row.

Where far more than noise is left anyway, a small share of it is invisible too: a base that misses the readings by a
thousand times the noise may stick where the joint slips, and no step follows its stops. The best models are compared at
the steps that they need themselves (`closer`).

An error of time is a lag. At a step near a lag, the lag's own parameter makes good of that error, and so may a rival's:
a delay of half a step looks like a lag there and nowhere else. So effects are compared where P leaves their parameters
out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.fit.tangent_space import tangent_space
from haptid.discrepancy.study.simulators import COARSE, Factory
from haptid.discrepancy.study.study import Study
from haptid.measurement.values.run import Array

INVISIBLE = 0.5
"""Largest ‖P·e‖²,"""
SMALL_SHARE = 1e-6
"""and about a base its largest share of what that leaves beyond noise."""
HALVINGS = 5


def at_step(study: Study, step: float) -> Study:
    """Return the study with readings at inner steps of at most ``step`` [s]."""
    return replace(study, factory=Factory(step))


def readings(study: Study, solution: Solution, step: float) -> Array:
    """Whitened simulated readings of all fitted runs at the optimum of ``solution``, over the noise, shape (n_r,)."""
    simulator = Factory(step)(solution.equations)
    rows = [
        whiten(simulator.simulate(solution.theta, run, x0=x0).y / run.sensor_std).ravel()
        for run, x0, whiten in zip(study.fitted, solution.x0, solution.problem.whiteners, strict=True)
    ]
    return np.concatenate(rows)


def visible(study: Study, solution: Solution, step: float) -> float:
    """Return ‖P·(y_h − y_{h/2})/σ‖² at the step h, P off the tangent space of base and initial states alone."""
    Q = tangent_space(solution, without={q.id for e in solution.effects for q in e.parameters})
    e = np.zeros(Q.shape[0])
    change = readings(study, solution, step) - readings(study, solution, step / 2)
    e[: change.size] = change
    e -= Q @ (Q.T @ e)
    return float(e @ e)


def step_for(study: Study, solution: Solution, first: float = COARSE, share: float = 0.0) -> float:
    """Return the longest of the steps ``first``/2ᵏ [s] whose error is invisible; the shortest where none is.

    So is an error of that ``share`` of the squares that ``solution`` leaves beyond noise.
    """
    step, limit = first, max(INVISIBLE, share * (solution.chi2 - solution.residual.size))
    for _ in range(HALVINGS):
        if visible(study, solution, step) < limit:
            break
        step /= 2
    return step
