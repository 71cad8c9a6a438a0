"""One locked joint: the Python side of ``joint.c``."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles
from haptid.virtual_device.machine.joint_library import JointLibrary, torque_table

BASE = ("inertia", "gravity_cos", "gravity_sin", "Kp", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""The twelve parameters of the undisturbed joint with LuGre friction, as users name them."""
MAX_STEP = 5e-5
"""Longest Runge–Kutta step [s]; the integrator takes shorter ones where the bristle asks for it."""


JOINT = JointLibrary("joint", Path(__file__).parent, "joint parameters")
"""The source ``joint.c``; its neutral parameters are those of a joint without disturbances."""


def integrate(
    parameters: Mapping[str, float],
    t: Array,
    torque: Array,
    *,
    hold: str = "zero",
    start: tuple[float, float] = (0.0, 0.0),
    max_step: float = MAX_STEP,
) -> tuple[Array, Array, Array]:
    """Integrate the joint, its bristle relaxed at the start.

    Parameters
    ----------
    parameters
        By name, see `JointLibrary.neutral`; what is absent is neutral.
    t, torque
        Rows of the torque table [s], [N m], shape (n,) each; ``t`` strictly increasing.
    hold
        Torque between rows: ``zero`` (constant) or ``linear``.
    start
        Position [rad] and velocity [rad/s] at the first row.
    max_step
        Longest Runge–Kutta step [s].

    Returns
    -------
    tuple
        True position [rad], velocity [rad/s] and noise-free encoder reading [rad], shape (n,) each.

    Raises
    ------
    InputError
        Where ``joint.c`` has no such parameter, time does not increase or has another length than the torque, or
        ``hold`` is unknown.
    NumericalError
        Where the motion stops being finite; it names the row.
    """
    t, torque = torque_table(t, torque)
    if hold not in ("zero", "linear"):
        raise InputError(where="hold", expected="'zero' or 'linear'", got=repr(hold))
    number, integer = ctypes.c_double, ctypes.c_int
    simulate = JOINT.function("simulate")
    simulate.argtypes = [Doubles, integer, Doubles, Doubles, integer, *[number] * 3, *[Doubles] * 3]
    packed, out = JOINT.pack(parameters), [np.empty_like(t) for _ in range(3)]
    failed = simulate(
        doubles(packed), t.size, doubles(t), doubles(torque), hold == "linear", *start, max_step, *map(doubles, out)
    )
    if failed:
        msg = f"the joint's motion stopped being finite at row {failed - 1}"
        raise NumericalError(msg)
    return out[0], out[1], out[2]
