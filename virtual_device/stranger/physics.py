"""The stranger's joint: the Python side of ``stranger.c``."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles
from haptid.virtual_device.machine.joint_library import JointLibrary, torque_table

LAWS = ("bristle", "dahl", "generalised_maxwell", "static")
"""Friction laws, in the order of their numbers in ``rubbing.h``."""
MAX_STEP = 5e-5
"""Longest Runge–Kutta step [s]; the integrator takes shorter ones where friction or a contact asks for it."""


STRANGER = JointLibrary("stranger", Path(__file__).parent, "parameters of the stranger's joint")
"""The source ``stranger.c``."""


def integrate(
    parameters: Mapping[str, float], t: Array, torque: Array, start: float, max_step: float = MAX_STEP
) -> tuple[Array, Array, Array]:
    """Integrate the joint from rest, its friction relaxed and the torque held between rows.

    Parameters
    ----------
    parameters
        By name, see `JointLibrary.neutral`; what is absent is neutral.
    t, torque
        Rows of the torque table [s], [N m], shape (n,) each; ``t`` strictly increasing.
    start
        Position at the first row [rad].
    max_step
        Longest Runge–Kutta step [s].

    Returns
    -------
    tuple
        True position [rad], velocity [rad/s] and noise-free encoder reading [rad], shape (n,) each.

    Raises
    ------
    InputError
        Where ``stranger.c`` has no such parameter, or time does not increase or has another length than the torque.
    NumericalError
        Where the motion stops being finite; it names the row.
    """
    t, torque = torque_table(t, torque)
    simulate = STRANGER.function("simulate")
    simulate.argtypes = [Doubles, ctypes.c_int, Doubles, Doubles, *[ctypes.c_double] * 2, *[Doubles] * 3]
    packed, out = STRANGER.pack(parameters), [np.empty_like(t) for _ in range(3)]
    failed = simulate(doubles(packed), t.size, doubles(t), doubles(torque), start, max_step, *map(doubles, out))
    if failed:
        msg = f"the joint's motion stopped being finite at row {failed - 1}"
        raise NumericalError(msg)
    return out[0], out[1], out[2]
