"""Robust loss on request: residuals over the noise in, residuals of the pseudo-Huber loss out.

ρ(r) = 2k²(√(1 + (r/k)²) − 1) = w², w = sign(r)·√ρ: quadratic for |r| ≪ k, linear for |r| ≫ k (Charbonnier et al. 1997).
The loss is written as a residual w, so that every least-squares method can minimise it.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def pseudo_huber(r: Array, k: float = THRESHOLDS.turn_of_loss_in_std) -> tuple[Array, Array]:
    """Transform residuals so that their squares are the pseudo-Huber loss.

    Parameters
    ----------
    r
        Residuals over the noise, any shape.
    k
        Residual at which the loss turns from quadratic to linear, in standard deviations of the noise.

    Returns
    -------
    w : ndarray
        sign(r)·√ρ(r), shape of r.
    slope : ndarray
        dw/dr, shape of r.

    Notes
    -----
    With R = √(1 + (r/k)²), w = r·√(2/(R + 1)) and dw/dr = 1/(R·√(2/(R + 1))).
    """
    # w as r times a factor: R − 1 of the definition would cancel for |r| ≪ k.
    root = np.sqrt(1.0 + (r / k) ** 2)
    half = np.sqrt(2.0 / (root + 1.0))
    return r * half, 1.0 / (root * half)
