"""How coarse the inner step may be: what is left of the solver's error once its part at the mode is taken off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from haptid.uq.density.laplace import Laplace

STEPS = (5e-3, 2.5e-3, 1.25e-3, 6.25e-4)
SHARE = 0.1
"""Share of its standard deviation by which the solver's error may move anything."""
DRAWS = 16

T = TypeVar("T")


def solver_error(mode: Laplace, *, draws: int = DRAWS, seed: int = 0) -> float:
    """Return the standard deviation over the posterior of the solver's error in its log density.

    Notes
    -----
    The data carry the difference between a fine and the coarse simulation at the mode (`Terms.correction`). What
    remains at another η is the change of that difference. With w = exp(log p_fine − log p_coarse), normalised to mean
    1, every expectation obeys |E_fine[h] − E_coarse[h]| = |cov(h, w)| ≤ std(h)·std(w) (Cauchy and Schwarz): at
    ``SHARE`` no mean moves by more than a tenth of a standard deviation. Draws are those of the normal approximation.
    """
    density, rng = mode.density, np.random.default_rng([seed, 13])
    drawn = mode.eta + rng.standard_normal((4 * draws, mode.eta.size)) @ mode.lower.T
    kept = drawn[np.isfinite(density.coordinates.log_prior(drawn))][:draws]
    if len(kept) < 2:
        return 0.0
    thetas = density.coordinates.thetas(kept)
    coarse = [density.simulated(kept, terms) for terms in density.terms]
    fine = [
        y + density.forward.shortfall(thetas, terms.run, terms.x0) - terms.correction
        for y, terms in zip(coarse, density.terms, strict=True)
    ]
    change = density.log_likelihoods(kept, fine).sum(axis=1) - density.log_likelihoods(kept, coarse).sum(axis=1)
    return float(np.std(change[np.isfinite(change)], ddof=1))


def longest_step(
    attempt: Callable[[float], T], mode_of: Callable[[T], Laplace], steps: Sequence[float] = STEPS
) -> tuple[T, float]:
    """Try inner steps, the longest first, until the solver's error stays below ``SHARE``.

    Returns
    -------
    attempt, step
        What ``attempt`` made with the step [s] that suffices (the shortest where none does).
    """
    for step in steps:
        made = attempt(step)
        if step == steps[-1] or solver_error(mode_of(made)) <= SHARE:
            return made, step
    msg = "no step to try"
    raise ValueError(msg)
