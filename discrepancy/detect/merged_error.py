"""Say how much merged rows change the readings of a model: studies and `Solution` in, squares over the noise out."""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.detect.inner_step import at_step, off_tangent_space
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


def merging_shows(whole: Study, few: Study, solution: Solution) -> bool:
    """Say whether merged rows change the readings of a model by what could pass for missing physics.

    Parameters
    ----------
    whole
        Study with all rows.
    few
        The same study with merged rows.
    solution
        Model that was fitted to ``few``.

    Returns
    -------
    bool
        True where the visible error is above that of an inner step, and above a share of what the model leaves beyond
        noise.
    """
    share = 1.0 / THRESHOLDS.search.least_excess_over_step_error
    limit = max(THRESHOLDS.detect.invisible_step_error_chi2, share * (solution.chi2 - solution.residual.size))
    return merging_error(whole, few, solution) > limit


def merging_error(whole: Study, few: Study, solution: Solution) -> float:
    """Return the visible error of merged rows.

    Parameters
    ----------
    whole
        Study with all rows.
    few
        The same study with merged rows.
    solution
        Model that was fitted to ``few``.

    Returns
    -------
    float
        ‖P·(y_all − y_merged)/σ‖² at the rows that both have, with P off the tangent space of nominal parameters and
        initial states: what merging adds to the χ² of the residual whatever the data.

    Notes
    -----
    Both are simulated at a small part of the rows' spacing. At the inner step of the search the rows that are close
    would be integrated at shorter steps than those that are far apart, and the error of that step, which is judged
    elsewhere (`detect.inner_step`), would pass for one of merging.
    """
    spacing = min(float(np.median(np.diff(run.t))) for run in whole.fitted)
    step = min(few.factory.step, spacing / THRESHOLDS.detect.row_divisor_of_merging)
    simulator = at_step(few, step).factory(solution.equations)
    changes = []
    for run, merged, x0, whiten in zip(whole.fitted, few.fitted, solution.x0, solution.problem.whiteners, strict=True):
        every_row = simulator.simulate(solution.theta, run, x0=x0).y[:: few.rows_merged]
        change = (every_row - simulator.simulate(solution.theta, merged, x0=x0).y) / merged.sensor_std
        change[1 : merged.score_from] = 0.0  # not scored
        changes.append(whiten(change).ravel())
    return off_tangent_space(solution, np.concatenate(changes))
