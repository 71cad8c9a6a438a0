"""Choice of the solver's inner step: the longest one whose error, corrected at the mode, is negligible.

1. Find the mode with the longest of `THRESHOLDS.inner_steps_s`; the data are corrected by the solver's error at that
   mode.
2. Estimate how much the remaining solver error varies over the posterior (`solver_error`).
3. Accept the step where that is at most `THRESHOLDS.largest_std_of_solver_error`; else continue with the next shorter
   step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from haptid.measurement.values.run import Array, Run
from haptid.model.kernel.pieces import inner_steps
from haptid.uq.density.laplace import Laplace, lowest_reached
from haptid.uq.thresholds import THRESHOLDS

T = TypeVar("T")


def solver_error(mode: Laplace, *, draws: int = THRESHOLDS.draws_of_solver_error, seed: int = 0) -> float:
    """Return the standard deviation, over the posterior, of the solver's error in the log density.

    Parameters
    ----------
    mode
        Normal approximation found with the inner step in question.
    draws
        Number of draws of the normal approximation.
    seed
        Seed of the draws.

    Returns
    -------
    float
        Standard deviation of log p_fine − log p_coarse [1]; 0 where fewer than two draws lie in the prior's support.

    Notes
    -----
    The data are corrected by the difference between a fine and the coarse simulation at the mode (`Terms.correction`).
    The error at another η is the change of that difference. With w = exp(log p_fine − log p_coarse), normalised to
    mean 1, every expectation obeys |E_fine[h] − E_coarse[h]| = |cov(h, w)| ≤ std(h)·std(w) (Cauchy and Schwarz). For
    small errors std(w) is the standard deviation that is returned: at `THRESHOLDS.largest_std_of_solver_error` no mean
    moves by more than a tenth of a standard deviation.

    Where the mode lies on a bound, or a valley bends, the normal approximation reaches far beyond the posterior, and
    the error out there says nothing. A correlated model error makes much of it, since the white noise beside it is
    small: under such a model draws move towards the mode first (`_within_reach`).
    """
    density, rng = mode.density, np.random.default_rng([seed, 13])
    drawn = mode.eta + rng.standard_normal((4 * draws, mode.eta.size)) @ mode.lower.T
    kept = drawn[np.isfinite(density.coordinates.log_prior(drawn))][:draws]
    if len(kept) < 2:
        return 0.0
    # Under white noise alone a needlessly short step costs little; with every step that is refused under a correlated
    # error, all noise models are compared again.
    if density.model.correlated:
        kept = _within_reach(mode, kept)
    thetas = density.coordinates.thetas(kept)
    coarse = [density.simulate(kept, terms) for terms in density.terms]
    fine = [
        y + density.forward.shortfall(thetas, terms.run, terms.x0) - terms.correction
        for y, terms in zip(coarse, density.terms, strict=True)
    ]
    change = density.log_likelihoods(kept, fine).sum(axis=1) - density.log_likelihoods(kept, coarse).sum(axis=1)
    return float(np.std(change[np.isfinite(change)], ddof=1))


def _within_reach(mode: Laplace, draws: Array) -> Array:
    """Halve the distance of draws (n_draws, n) from the mode until the posterior reaches them (`lowest_reached`)."""
    reached = np.array(draws)
    least = lowest_reached(mode.log_density, mode.eta.size)
    for _ in range(THRESHOLDS.most_halvings_of_a_draw):
        # Written with `not … >=`: a diverged simulation is out of reach, too.
        outside = ~(mode.density(reached) >= least)
        if not outside.any():
            break
        reached[outside] = (reached[outside] + mode.eta) / 2
    return reached


def distinct_steps(steps: Sequence[float], runs: Sequence[Run]) -> list[float]:
    """Leave out inner steps that divide all intervals between rows as a longer one does: the simulation is the same.

    Parameters
    ----------
    steps
        Inner steps [s], the longest first.
    runs
        Runs that are simulated.

    Returns
    -------
    list of float
        The longest step [s] of each division.
    """
    kept: dict[bytes, float] = {}
    for step in steps:
        parts = np.concatenate([inner_steps(run.t, step) for run in runs])
        kept.setdefault(parts.tobytes(), step)
    return list(kept.values())


def longest_step(
    attempt: Callable[[float], T], mode_of: Callable[[T], Laplace], steps: Sequence[float] = THRESHOLDS.inner_steps_s
) -> tuple[T, float]:
    """Try inner steps, the longest first, until the solver's error is small enough.

    Parameters
    ----------
    attempt
        Computes a result with an inner step [s].
    mode_of
        Returns the normal approximation of such a result.
    steps
        Inner steps [s], the longest first.

    Returns
    -------
    result, step
        Result of ``attempt`` with the longest step [s] that suffices (the shortest where none does), and that step.

    Raises
    ------
    ValueError
        Where ``steps`` is empty.
    """
    for step in steps:
        made = attempt(step)
        # The last step is used whatever its error.
        if step == steps[-1] or solver_error(mode_of(made)) <= THRESHOLDS.largest_std_of_solver_error:
            return made, step
    msg = "no step to try"
    raise ValueError(msg)
