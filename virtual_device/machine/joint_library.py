"""A joint in C as Python sees it: its parameters by name, and where it rests; the integrators are their callers'."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.compiled import Array, Doubles, doubles, library


@dataclass(frozen=True, slots=True)
class JointLibrary:
    """A compiled C source of one joint; its functions begin with its name, as ``<name>_parameter_count``.

    Parameters
    ----------
    name
        Name of the source without its suffix, with which its functions begin.
    folder
        Folder of the source.
    title
        What messages call it.
    """

    name: str
    folder: Path
    title: str

    def function(self, suffix: str) -> ctypes._NamedFuncPointer:
        """Return the function ``<name>_<suffix>`` of the library.

        Parameters
        ----------
        suffix
            Rest of the function's name.

        Returns
        -------
        function of ctypes
            The same one at each call.

        Raises
        ------
        NumericalError
            Where the library cannot be compiled.
        """
        return getattr(library(self.name, self.folder), f"{self.name}_{suffix}")

    def neutral(self) -> dict[str, float]:
        """List every parameter that the integrator knows.

        Returns
        -------
        dict
            By name the value at which the parameter does nothing.

        Raises
        ------
        NumericalError
            Where the library cannot be compiled.
        """
        return dict(_neutral(self))

    def pack(self, parameters: Mapping[str, float]) -> Array:
        """Order ``parameters`` as the integrator wants them; what is absent is neutral.

        Parameters
        ----------
        parameters
            Some of the parameters by name, SI units.

        Returns
        -------
        Array
            All parameters in the order of the source, shape (n,).

        Raises
        ------
        InputError
            Where the source has no such parameter.
        """
        known = self.neutral()
        if unknown := sorted(set(parameters) - set(known)):
            raise InputError(where=self.title, expected=f"some of {', '.join(known)}", got=", ".join(unknown))
        return np.array([float(parameters.get(name, value)) for name, value in known.items()])

    def rest_position(self, parameters: Mapping[str, float]) -> float:
        """Return the position near epos at which springs and gravity balance without torque and with relaxed friction.

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
            Where the source has no such parameter.
        NumericalError
            Where there is no stable rest within 1.5 rad of epos.
        """
        static, packed = self.function("static_torque"), self.pack(parameters)
        static.restype = ctypes.c_double
        static.argtypes = [Doubles, ctypes.c_double]

        def torque(q: float) -> float:
            return float(static(doubles(packed), q))

        centre = float(parameters.get("epos", 0.0))
        for half in (0.05, 0.1, 0.2, 0.5, 1.0, 1.5):
            if torque(centre - half) < 0.0 < torque(centre + half):
                return float(brentq(torque, centre - half, centre + half, xtol=1e-14))
        msg = f"the joint has no stable rest within 1.5 rad of its equilibrium position {centre}"
        raise NumericalError(msg)


@functools.cache
def _neutral(joint: JointLibrary) -> dict[str, float]:
    name, default = joint.function("parameter_name"), joint.function("parameter_default")
    name.restype, default.restype = ctypes.c_char_p, ctypes.c_double
    return {name(i).decode(): default(i) for i in range(joint.function("parameter_count")())}


def torque_table(t: Array, torque: Array) -> tuple[Array, Array]:
    """Return the rows of a torque table as the integrators read them.

    Parameters
    ----------
    t, torque
        Times [s] and torques [N m], shape (n,) each.

    Returns
    -------
    tuple
        Both as contiguous arrays of float64.

    Raises
    ------
    InputError
        Where time does not increase, or has another length than the torque.
    """
    t, torque = np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(torque, dtype=float)
    if t.ndim != 1 or t.shape != torque.shape or np.any(np.diff(t) <= 0):
        expected = "two arrays of one length, time increasing"
        raise InputError(where="torque table", expected=expected, got=f"{t.shape}, {torque.shape}")
    return t, torque
