"""Error rate of the family: how small a p the whole catalogue reaches where nothing is missing, found in two ways.

From the noise model: under white noise the scores of all entries are distributed as their Gram matrix says. Without
one: where nothing is missing, the whitened residual of a stretch is as likely as its negative, whatever its
distribution, so the scores may be had again under random signs of stretches (Hemerik, Goeman, Finos 2020).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.discrepancy.detect.chi_squared import log_tails
from haptid.discrepancy.detect.signatures import Point
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import symmetric_inverse

DRAWS = 2000
STRETCHES = 60
"""Stretches of a run whose signs are flipped, each on its own."""


def independent_tests(G: Array, points: Sequence[Point], seed: int = 0) -> float:
    """Return the number N of independent tests with the same distribution of the smallest p, by draws of Dᵀε ~ N(0, G).

    P(min p > x) = (1 − x)^N; N is the maximum-likelihood estimate from the draws whose smallest p is in the lower tail.
    """
    if not points:
        return 1.0
    rng = np.random.default_rng(seed)
    size = np.sqrt(np.maximum(np.diag(G), 1e-300))
    values, vectors = np.linalg.eigh(G / np.outer(size, size))
    keep = values > 1e-10 * values[-1]
    root = vectors[:, keep] * np.sqrt(values[keep])
    drawn = (root @ rng.standard_normal((int(keep.sum()), DRAWS))) * size[:, None]
    smallest = np.minimum(0.0, np.min([_log_p(point, G, drawn) for point in points], axis=0))
    return max(1.0, -1.0 / float(np.mean(np.log1p(-np.minimum(np.exp(smallest), 1 - 1e-12)))))


def by_sign_flips(
    r: Array, D: Array, G: Array, points: Sequence[Point], runs: Sequence[Run], seed: int = 0
) -> dict[str, float]:
    """Return p of every entry over the whole catalogue: the share of flips in which any entry scores as well as it.

    With signs s of the stretches, scores come from c = Σ s_b·D_bᵀ·r_b, where D is projected off what the model can move
    and G = DᵀD. The smallest p that there is is 1/(`DRAWS` + 1). Single-step minimum of p, Westfall and Young 1993.

    Parameters
    ----------
    r, D
        Whitened residual (n_r,) and projected signatures (n_r, n_columns), the rows of the runs first.
    """
    edges, first = [], 0
    for run in runs:
        ends = np.linspace(0, run.t.size, min(STRETCHES, run.t.size) + 1).astype(int)
        edges.extend(first + run.y.shape[1] * ends[:-1])
        first += run.y.size
    parts = np.add.reduceat(D[:first] * r[:first, None], edges)
    signs = np.random.default_rng(seed).choice((-1.0, 1.0), size=(len(edges), DRAWS))
    c = parts.T @ np.column_stack((np.ones(len(edges)), signs))
    own: dict[str, float] = {}
    smallest: Array = np.zeros(DRAWS)
    for point in points:
        log_p = _log_p(point, G, c)
        own[point.key] = min(own.get(point.key, 0.0), float(log_p[0]))
        smallest = np.minimum(smallest, log_p[1:])
    return {key: (1 + int((smallest <= p).sum())) / (DRAWS + 1) for key, p in own.items()}


def _log_p(point: Point, G: Array, c: Array) -> Array:
    """Return ln p of one shape under χ², for scores c (n_columns, n)."""
    block = c[point.columns]
    inverse = symmetric_inverse(G[point.columns, point.columns], 1e-10)
    return log_tails(np.einsum("id,id->d", block, inverse @ block), len(point.values))
