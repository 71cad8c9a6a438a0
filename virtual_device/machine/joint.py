"""One locked joint: the Python side of ``joint.c``."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping

import numpy as np
from scipy.optimize import brentq

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles, library

BASE = ("inertia", "gravity_cos", "gravity_sin", "Kp", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""The twelve parameters of the undisturbed joint with LuGre friction, as users name them."""
MAX_STEP = 5e-5
"""Longest Runge–Kutta step [s]; the integrator takes shorter ones where the bristle asks for it."""


@functools.cache
def _functions() -> ctypes.CDLL:
    lib = library("joint")
    lib.joint_parameter_name.restype = ctypes.c_char_p
    lib.joint_parameter_default.restype = ctypes.c_double
    lib.joint_static_torque.restype = ctypes.c_double
    lib.joint_static_torque.argtypes = [Doubles, ctypes.c_double]
    number, integer = ctypes.c_double, ctypes.c_int
    lib.joint_simulate.argtypes = [Doubles, integer, Doubles, Doubles, integer, *[number] * 3, *[Doubles] * 3]
    return lib


@functools.cache
def neutral() -> dict[str, float]:
    """List every parameter that the integrator knows.

    Returns
    -------
    dict
        By name the value at which the parameter does nothing.
    """
    lib = _functions()
    count = lib.joint_parameter_count()
    return {lib.joint_parameter_name(i).decode(): lib.joint_parameter_default(i) for i in range(count)}


def pack(parameters: Mapping[str, float]) -> Array:
    """Order ``parameters`` as the integrator wants them; what is absent is neutral.

    Parameters
    ----------
    parameters
        Some of the parameters by name, SI units.

    Returns
    -------
    Array
        All parameters in the order of ``joint.c``, shape (n,).

    Raises
    ------
    InputError
        Where ``joint.c`` has no such parameter.
    """
    known = neutral()
    unknown = sorted(set(parameters) - set(known))
    if unknown:
        raise InputError(where="joint parameters", expected=f"some of {', '.join(known)}", got=", ".join(unknown))
    return np.array([float(parameters.get(name, value)) for name, value in known.items()])


def rest_position(parameters: Mapping[str, float]) -> float:
    """Return the position near epos at which springs and gravity balance without torque and with a relaxed bristle.

    Parameters
    ----------
    parameters
        Some of the parameters by name, SI units.

    Returns
    -------
    float
        Position [rad].

    Raises
    ------
    InputError
        Where ``joint.c`` has no such parameter.
    NumericalError
        Where there is no stable rest within 1.5 rad of epos.
    """
    lib, packed = _functions(), pack(parameters)

    def torque(q: float) -> float:
        return float(lib.joint_static_torque(doubles(packed), q))

    centre = float(parameters.get("epos", 0.0))
    for half in (0.05, 0.1, 0.2, 0.5, 1.0, 1.5):
        if torque(centre - half) < 0.0 < torque(centre + half):
            return float(brentq(torque, centre - half, centre + half, xtol=1e-14))
    msg = f"the joint has no stable rest within 1.5 rad of its equilibrium position {centre}"
    raise NumericalError(msg)


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
        By name, see `neutral`; what is absent is neutral.
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
    t, torque = np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(torque, dtype=float)
    if t.ndim != 1 or t.shape != torque.shape or np.any(np.diff(t) <= 0):
        expected = "two arrays of one length, time increasing"
        raise InputError(where="torque table", expected=expected, got=f"{t.shape}, {torque.shape}")
    if hold not in ("zero", "linear"):
        raise InputError(where="hold", expected="'zero' or 'linear'", got=repr(hold))
    packed, out = pack(parameters), [np.empty_like(t) for _ in range(3)]
    failed = _functions().joint_simulate(
        doubles(packed), t.size, doubles(t), doubles(torque), hold == "linear", *start, max_step, *map(doubles, out)
    )
    if failed:
        msg = f"the joint's motion stopped being finite at row {failed - 1}"
        raise NumericalError(msg)
    return out[0], out[1], out[2]
