"""What a rigid body leaves of the torque along the measured motion: `Run`s in, positions and residual torques out.

A free simulation hides a ripple of gear teeth or motor poles: what it adds to the position falls with the square of its
frequency. In the torque it stands as it is. So torque and motion are filtered alike, and

    τ = M a + d v + Fc sgn v + c0 + c1 q + c2 q² + c3 q³ + g_c cos q + g_s sin q + r

is fitted by least squares: smooth springs and gravity go into the polynomial, and waves stay in r.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Array, Run

DEGREE = 3
"""Degree of the polynomial of the position."""


def residual_over_position(runs: Sequence[Run]) -> tuple[Array, Array]:
    """Return what a rigid body with dry and viscous friction and a smooth spring leaves of the torque.

    Parameters
    ----------
    runs
        Runs of one joint.

    Returns
    -------
    q, signals
        Positions [rad] or [m], shape (n,); the residual r [N m] or [N] there, and r·sgn v, shape (n, 2).
    """
    q, v, a, torque = (np.concatenate(parts) for parts in zip(*(_interior(run) for run in runs), strict=True))
    W = np.column_stack((a, v, np.sign(v), *(q**power for power in range(DEGREE + 1))))
    if not runs[0].prismatic[0]:
        W = np.column_stack((W, np.cos(q), np.sin(q)))
    # Columns of one length: what is cut off as dependent does not hang on units.
    W = W / np.maximum(np.linalg.norm(W, axis=0), np.finfo(float).tiny)
    left = torque - W @ np.linalg.lstsq(W, torque, rcond=None)[0]
    return q, left[:, None] * np.column_stack((np.ones(q.size), np.sign(v)))


def _interior(run: Run) -> tuple[Array, Array, Array, Array]:
    """Return position, speed, acceleration and torque of the rows whose surroundings the filter saw whole."""
    motion = filter_run(run)
    rows = motion.interior
    return motion.q[rows, 0], motion.v[rows, 0], motion.a[rows, 0], motion.torque[rows, 0]
