"""The stranger's joint: the Python side of ``stranger.c``."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles, library

LAWS = ("bristle", "dahl", "generalised_maxwell", "static")
"""Friction laws, in the order of their numbers in ``rubbing.h``."""
MAX_STEP = 5e-5
"""Longest Runge–Kutta step [s]; the integrator takes shorter ones where friction or a contact asks for it."""


@functools.cache
def _functions() -> ctypes.CDLL:
    lib = library("stranger", Path(__file__).parent)
    lib.stranger_parameter_name.restype = ctypes.c_char_p
    lib.stranger_parameter_default.restype = ctypes.c_double
    lib.stranger_static_torque.restype = ctypes.c_double
    lib.stranger_static_torque.argtypes = [Doubles, ctypes.c_double]
    numbers = [ctypes.c_double] * 2
    lib.stranger_simulate.argtypes = [Doubles, ctypes.c_int, Doubles, Doubles, *numbers, *[Doubles] * 3]
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
    count = lib.stranger_parameter_count()
    return {lib.stranger_parameter_name(i).decode(): lib.stranger_parameter_default(i) for i in range(count)}


def pack(parameters: Mapping[str, float]) -> Array:
    """Order ``parameters`` as the integrator wants them; what is absent is neutral.

    Parameters
    ----------
    parameters
        Some of the parameters by name, SI units.

    Returns
    -------
    Array
        All parameters in the order of ``stranger.c``, shape (n,).

    Raises
    ------
    InputError
        Where ``stranger.c`` has no such parameter.
    """
    known = neutral()
    if unknown := sorted(set(parameters) - set(known)):
        expected = f"some of {', '.join(known)}"
        raise InputError(where="parameters of the stranger's joint", expected=expected, got=", ".join(unknown))
    return np.array([float(parameters.get(name, value)) for name, value in known.items()])


def rest_position(parameters: Mapping[str, float]) -> float:
    """Return the position nearest to epos at which springs and gravity balance without torque and friction.

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
        Where ``stranger.c`` has no such parameter.
    NumericalError
        Where there is no stable rest within 1.5 rad of epos.
    """
    lib, packed = _functions(), pack(parameters)

    def torque(q: float) -> float:
        return float(lib.stranger_static_torque(doubles(packed), q))

    centre = float(parameters.get("epos", 0.0))
    for half in (0.05, 0.1, 0.2, 0.5, 1.0, 1.5):
        if torque(centre - half) < 0.0 < torque(centre + half):
            return float(brentq(torque, centre - half, centre + half, xtol=1e-14))
    msg = f"the joint has no stable rest within 1.5 rad of its equilibrium position {centre}"
    raise NumericalError(msg)


def integrate(
    parameters: Mapping[str, float], t: Array, torque: Array, start: float, max_step: float = MAX_STEP
) -> tuple[Array, Array, Array]:
    """Integrate the joint from rest, its friction relaxed and the torque held between rows.

    Parameters
    ----------
    parameters
        By name, see `neutral`; what is absent is neutral.
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
    t, torque = np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(torque, dtype=float)
    if t.ndim != 1 or t.shape != torque.shape or np.any(np.diff(t) <= 0):
        expected = "two arrays of one length, time increasing"
        raise InputError(where="torque table", expected=expected, got=f"{t.shape}, {torque.shape}")
    packed, out = pack(parameters), [np.empty_like(t) for _ in range(3)]
    failed = _functions().stranger_simulate(
        doubles(packed), t.size, doubles(t), doubles(torque), start, max_step, *map(doubles, out)
    )
    if failed:
        msg = f"the joint's motion stopped being finite at row {failed - 1}"
        raise NumericalError(msg)
    return out[0], out[1], out[2]
