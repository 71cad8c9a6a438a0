"""Control the family-wise error rate over the catalogue: projected signatures in, number of tests or p-values out.

The smallest p over all effects and shapes is judged against its distribution without model discrepancy, which is found
in two ways.

- From the noise model: under white noise the scores of all effects are normal with the Gram matrix of the signatures as
  covariance (`independent_tests`).
- Without a noise model: without discrepancy, the whitened residual of a stretch of a run is as likely as its negative,
  whatever its distribution, so scores under random signs of the stretches are as likely as those found
  (`by_sign_flips`; Hemerik, Goeman, Finos 2020).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.discrepancy.detect.chi_squared import log_tails
from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import symmetric_inverse


def independent_tests(G: Array, points: Sequence[Point], seed: int = 0) -> float:
    """Return the number of independent tests whose smallest p is distributed as that of the catalogue.

    Parameters
    ----------
    G
        Gram matrix of the projected signatures, shape (n_columns, n_columns).
    points
        Shapes that are tested.
    seed
        Seed of the draws.

    Returns
    -------
    float
        N, at least 1.

    Notes
    -----
    Scores Dᵀε ~ N(0, G) are drawn `random_draws` times. With P(min p > x) = (1 − x)^N, the
    maximum-likelihood estimate is N = −1/mean(ln(1 − min p)).
    """
    if not points:
        return 1.0
    rng = np.random.default_rng(seed)
    size = np.sqrt(np.maximum(np.diag(G), 1e-300))
    # Signatures of different units differ by orders of magnitude; with a unit diagonal, the cut on eigenvalues spares
    # the small ones.
    values, vectors = np.linalg.eigh(G / np.outer(size, size))
    keep = values > 1e-10 * values[-1]
    root = vectors[:, keep] * np.sqrt(values[keep])
    drawn = (root @ rng.standard_normal((int(keep.sum()), THRESHOLDS.detect.random_draws))) * size[:, None]
    smallest = np.minimum(0.0, np.min([_log_p(point, G, drawn) for point in points], axis=0))
    return max(1.0, -1.0 / float(np.mean(np.log1p(-np.minimum(np.exp(smallest), 1 - 1e-12)))))


def by_sign_flips(
    r: Array, D: Array, G: Array, points: Sequence[Point], runs: Sequence[Run], seed: int = 0
) -> dict[str, float]:
    """Return the family-wise p-value of every catalogue effect, by random signs of the residual's stretches.

    Parameters
    ----------
    r
        Whitened residual, the rows of the runs first, shape (n_r,).
    D
        Projected signatures, shape (n_r, n_columns).
    G
        Gram matrix DᵀD.
    points
        Shapes that are tested.
    runs
        Fitted runs.
    seed
        Seed of the signs.

    Returns
    -------
    dict
        p-value by key: the share of sign patterns in which any effect scores as well as this one, at least
        1/(`random_draws` + 1).

    Notes
    -----
    With signs s of the stretches b, the scores are c = Σ s_b·D_bᵀ·r_b. The p-values are those of the single-step
    minimum-p procedure.

    References
    ----------
    Westfall and Young 1993.
    """
    edges, first = [], 0
    for run in runs:
        ends = np.linspace(0, run.t.size, min(THRESHOLDS.detect.sign_stretches_per_run, run.t.size) + 1).astype(int)
        edges.extend(first + run.y.shape[1] * ends[:-1])
        first += run.y.size
    parts = np.add.reduceat(D[:first] * r[:first, None], edges)
    signs = np.random.default_rng(seed).choice((-1.0, 1.0), size=(len(edges), THRESHOLDS.detect.random_draws))
    # The first column has all signs positive: it holds the scores as they were found.
    c = parts.T @ np.column_stack((np.ones(len(edges)), signs))
    own: dict[str, float] = {}
    smallest: Array = np.zeros(THRESHOLDS.detect.random_draws)
    for point in points:
        log_p = _log_p(point, G, c)
        own[point.key] = min(own.get(point.key, 0.0), float(log_p[0]))
        smallest = np.minimum(smallest, log_p[1:])
    return {key: (1 + int((smallest <= p).sum())) / (THRESHOLDS.detect.random_draws + 1) for key, p in own.items()}


def _log_p(point: Point, G: Array, c: Array) -> Array:
    """Return ln p of one shape under χ², for scores c (n_columns, n)."""
    block = c[point.columns]
    inverse = symmetric_inverse(G[point.columns, point.columns], 1e-10)
    return log_tails(np.einsum("id,id->d", block, inverse @ block), len(point.values))
