"""The regressor Y of the torques, τ = Y(q, v, a)·π, in floating point.

Torques are linear in π: a column of Y is the Newton-Euler torque of one parameter set to 1 and all others to 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.device.device import Device
from haptid.model.rigid_body.inertial_parameters import pi_ids
from haptid.model.rigid_body.newton_euler import inverse_dynamics

Array = NDArray[np.float64]


def regressor(device: Device, q: Array, v: Array, a: Array) -> Array:
    """Compute the regressor of the joint torques at n states.

    Parameters
    ----------
    device
        Device with n_q joints.
    q, v, a
        Positions [rad], velocities [rad/s] and accelerations [rad/s²], or in m for a prismatic joint, shape (n_q, n).

    Returns
    -------
    Array
        Y, shape (n_q, n, n_pi): torque of joint i at state k per unit of π. A rotor with inertia J adds
        J·ratio_i·Σ_j ratio_j·a_j.
    """
    n_q, n = q.shape
    Y = np.zeros((n_q, n, len(pi_ids(device))))
    speeds, accelerations = dict(enumerate(v)), dict(enumerate(a))
    for number, link in enumerate(device.massive):
        for k in range(10):
            unit = tuple(np.array(float(k == other)) for other in range(10))
            torques = inverse_dynamics(device, Numbers(q), {link.name: unit}, speeds, accelerations)
            Y[:, :, 10 * number + k] = np.array([np.broadcast_to(torque, n) for torque in torques])
    for number, motor in enumerate(device.motors, start=10 * len(device.massive)):
        ratios = np.array([float(motor.ratios.get(j, 0)) for j in range(n_q)])
        Y[:, :, number] = np.outer(ratios, ratios @ a)
    return Y
