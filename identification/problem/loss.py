"""Robust loss on request: pseudo-Huber, written as a residual so that every least-squares method can minimise it.

ρ(r) = 2k²(√(1 + (r/k)²) − 1) = w², w = sign(r)·√ρ: quadratic for |r| ≪ k, linear for |r| ≫ k (Charbonnier et al. 1997).
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array

TURN = 3.0
"""k, in standard deviations of the noise."""


def pseudo_huber(r: Array, k: float = TURN) -> tuple[Array, Array]:
    """Return w and dw/dr, each of the shape of r."""
    root = np.sqrt(1.0 + (r / k) ** 2)
    half = np.sqrt(2.0 / (root + 1.0))
    return r * half, 1.0 / (root * half)
