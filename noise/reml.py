"""How much cycles scatter: the restricted likelihood of their amplitudes' variance over many runs.

r = J·p + M·b + ε with b ~ N(0, s²) and ε ~ N(0, 1). With Q an orthonormal basis of J's columns, P = I − Q·Qᵀ takes p
out (Patterson and Thompson 1971), and up to what does not depend on s

    −2 ln L(s) = ln det(I + s²·G) − s²·gᵀ·(I + s²·G)⁻¹·g,    G = Mᵀ·P·M,    g = Mᵀ·P·r.

A cycle moves the readings of its own run alone: MᵀM has a block for each run, and G is that less Wᵀ·W, W = Qᵀ·M. In the
basis of the blocks' eigenvectors, with D = 1 + s²·λ and K = I − s²·W·D⁻¹·Wᵀ, the matrix determinant lemma and
Woodbury's identity (Golub and Van Loan 2013, section 2.1.4) give

    ln det(I + s²·G) = Σ ln D + ln det K,    (I + s²·G)⁻¹·g = D⁻¹·g + s²·D⁻¹·Wᵀ·K⁻¹·W·D⁻¹·g:

runs of hundreds of cycles cost what each costs alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from haptid.measurement.values.run import Array

LEAST, LARGEST = 1e-7, 0.5
"""Range of s."""
CLEAR = 1e-3
"""Least twice the gain in log-likelihood over s = 0 that is not rounding."""


def best_scatter(r: Sequence[Array], Q: Sequence[Array], M: Sequence[Array]) -> tuple[float, float]:
    """Return s ≥ 0 of largest restricted likelihood, and twice its gain over s = 0.

    ``r`` (n,), ``Q`` (n, q) and ``M`` (n, K) are those of every run, r already without what Q takes out. Nothing where
    the simulations behind them left the finite numbers.
    """
    if not all(np.isfinite(part).all() for part in (*r, *M)):
        return 0.0, 0.0
    blocks = [np.linalg.eigh(m.T @ m) for m in M]
    spread = np.concatenate([np.maximum(values, 0.0) for values, _ in blocks])
    g = np.concatenate([V.T @ (m.T @ part) for part, m, (_, V) in zip(r, M, blocks, strict=True)])
    W = np.concatenate([(q.T @ m) @ V for q, m, (_, V) in zip(Q, M, blocks, strict=True)], axis=1)

    def deviance(log_s: float) -> float:
        s2 = np.exp(2.0 * log_s)
        D = 1.0 + s2 * spread
        K = np.eye(W.shape[0]) - s2 * (W / D) @ W.T
        sign, log_det = np.linalg.slogdet(K)
        if sign <= 0.0:
            return np.inf
        through = W @ (g / D)
        explained = s2 * (g @ (g / D) + s2 * through @ np.linalg.solve(K, through))
        return float(np.log(D).sum() + log_det - explained)

    found = minimize_scalar(deviance, bounds=(np.log(LEAST), np.log(LARGEST)), method="bounded")
    gain = -float(found.fun)
    return (float(np.exp(found.x)), gain) if gain > CLEAR else (0.0, 0.0)
