"""Amplitude scatter from cycle to cycle by restricted maximum likelihood (REML): whitened residuals in, s out.

Over all runs r = J·p + M·b + ε with b ~ N(0, s²) and ε ~ N(0, 1). With Q an orthonormal basis of J's columns,
P = I − Q·Qᵀ projects p out (Patterson and Thompson 1971), and up to a constant in s

    −2 ln L(s) = ln det(I + s²·G) − s²·gᵀ·(I + s²·G)⁻¹·g,    G = Mᵀ·P·M,    g = Mᵀ·P·r.

A cycle moves the readings of its own run alone: MᵀM has one block per run, and G = MᵀM − Wᵀ·W with W = Qᵀ·M. In the
basis of the blocks' eigenvectors, with D = 1 + s²·λ and K = I − s²·W·D⁻¹·Wᵀ, the matrix determinant lemma and
Woodbury's identity (Golub and Van Loan 2013, section 2.1.4) give

    ln det(I + s²·G) = Σ ln D + ln det K,    (I + s²·G)⁻¹·g = D⁻¹·g + s²·D⁻¹·Wᵀ·K⁻¹·W·D⁻¹·g.

So no matrix over the cycles of all runs is factored: each run has an eigenproblem, and K is as large as J has columns.

References
----------
Patterson, H. D., and Thompson, R. (1971). Recovery of inter-block information when block sizes are unequal.
Biometrika 58, 545–554.
Golub, G. H., and Van Loan, C. F. (2013). Matrix Computations, fourth edition.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from haptid.measurement.values.run import Array
from haptid.noise.thresholds import THRESHOLDS


def best_scatter(r: Sequence[Array], Q: Sequence[Array], M: Sequence[Array]) -> tuple[float, float]:
    """Maximise the restricted likelihood of the amplitude scatter s ≥ 0.

    Parameters
    ----------
    r
        Whitened residual of every run with Q's columns projected out, shape (n,) each.
    Q
        Rows of every run in the orthonormal basis of J's columns, shape (n, q) each.
    M
        Whitened change of the readings with each cycle's relative amplitude, shape (n, K) each.

    Returns
    -------
    s : float
        Standard deviation of a cycle's relative amplitude [1].
    gain : float
        Twice the gain in restricted log-likelihood over s = 0. Both are 0 where the gain is rounding, or where a
        simulation behind the arguments is not finite.
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
        if sign <= 0.0:  # K is positive definite but for rounding
            return np.inf
        through = W @ (g / D)
        explained = s2 * (g @ (g / D) + s2 * through @ np.linalg.solve(K, through))
        return float(np.log(D).sum() + log_det - explained)

    bounds = np.log(THRESHOLDS.least_scatter), np.log(THRESHOLDS.largest_scatter)
    optimum = minimize_scalar(deviance, bounds=bounds, method="bounded")
    gain = -float(optimum.fun)  # the deviance is 0 at s = 0
    return (float(np.exp(optimum.x)), gain) if gain > THRESHOLDS.twice_gain_of_rounding else (0.0, 0.0)
