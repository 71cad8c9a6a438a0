"""The slave inside a Python FMU: one flat buffer, stepped by the compiled kernel beside this file.

This file is copied into the FMU under a name that holds the digest of the FMU's content, so that two FMUs in one
process never share a module, and imported by a module that holds little else. It needs the standard library and
pythonfmu only. `plan.json` tells it everything else.

The guard before pythonfmu's loader answers all calls of FMI by itself. Of this slave it asks for addresses
(`Slave.addresses`): of the buffer and of the kernel's functions. Where no compiled kernel suits the platform, it asks
for steps, outputs and the check of the mass matrix instead. Nothing here raises: pythonfmu would drop the instance.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import platform
import sys
from array import array
from functools import partial
from pathlib import Path
from typing import Any

from pythonfmu import Boolean, Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

HERE = Path(__file__).resolve().parent
PLAN = json.loads((HERE / "plan.json").read_text(encoding="utf-8"))
SIZE = len(PLAN["start"])
HANDOVER, OUTPUT_NOW, PIVOT_NOW = range(0x68617074, 0x68617077)
"""Value references under which the guard asks for the addresses, for new outputs, and for the mass matrix's pivot."""
TIME, TANGENT, PIVOT_JOINT, PIVOT_VALUE = range(4)
"""Places in the array of what the guard asks and the slave answers: time [s], sensitivities on, row, pivot."""
FUNCTIONS = ("hf_step", "hf_step_tangent", "hf_output", "hf_output_tangent", "hf_pivot")
EXACT = 2.0**53
"""Whole numbers below are exact as doubles."""
MACHINES = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}


def load_kernel() -> Any:
    """Load the kernel: the compiled library for this platform, else the same formulas in plain Python.

    Returns
    -------
    ctypes.CDLL or module
        Both have the same functions.
    """
    machine = MACHINES.get(platform.machine().lower(), platform.machine().lower())
    for path in sorted((HERE / f"{PLAN['module']}_kernel").glob(f"{sys.platform}-{machine}*")):
        try:
            library = ctypes.CDLL(str(path))
        except OSError:
            continue
        return library
    return importlib.import_module(f"{PLAN['module']}_fallback")


KERNEL = load_kernel()
COMPILED = isinstance(KERNEL, ctypes.CDLL)


def keep(names: dict[str, Any]) -> None:
    """Add a reference to the names of the entry module.

    pythonfmu 0.7 drops one at each instantiation that it never had, and with the last one the module's names are gone.

    Parameters
    ----------
    names
        Names of the entry module, its ``globals()``.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(names))


def forget_repeated(folder: str) -> None:
    """Leave one entry of a folder in the module search path: pythonfmu 0.7 adds one at each instantiation.

    Parameters
    ----------
    folder
        Folder of the resources, as pythonfmu names it.
    """
    for _ in range(sys.path.count(folder) - 1):
        sys.path.remove(folder)


class Slave(Fmi2Slave):
    """One instance: a buffer, the time, and whether the outputs still hold.

    Parameters
    ----------
    **kwargs
        What pythonfmu hands over, as for `Fmi2Slave`.
    """

    def __init__(self, **kwargs: Any) -> None:
        """Make the buffer with its start values."""
        super().__init__(**kwargs)
        forget_repeated(str(self.resources))
        keep(vars(sys.modules[PLAN["module"]]))
        self.modelName = PLAN["identifier"]
        self._values = array("d", PLAN["start"])
        self._asked = array("d", [0.0] * 4)
        self._register()

    def addresses(self) -> list[float]:
        """Tell the guard where the buffer and the kernel's functions are.

        Returns
        -------
        list of float
            Length of the buffer, addresses of both arrays, and addresses of `FUNCTIONS`, 0 for one that is not compiled
            in. All numbers are 0 where a double holds one of the addresses inexactly.
        """
        arrays = [a.buffer_info()[0] for a in (self._values, self._asked)]
        present = [getattr(KERNEL, name) if COMPILED and name in PLAN["functions"] else None for name in FUNCTIONS]
        functions = [ctypes.cast(f, ctypes.c_void_p).value or 0 if f else 0 for f in present]
        known = all(0 <= address < EXACT for address in (*arrays, *functions))
        return [float(x) if known else 0.0 for x in (SIZE, *arrays, *functions)]

    def _kernel(self, name: str) -> Any:
        return getattr(KERNEL, f"{name}_tangent" if self._asked[TANGENT] else name)

    def _register(self) -> None:
        values = self._values
        for name, vr, causality, variability, initial in PLAN["variables"]:
            variable = Real(
                name,
                causality=Fmi2Causality[causality],
                variability=Fmi2Variability[variability],
                initial=Fmi2Initial[initial] if initial else None,
                getter=partial(values.__getitem__, vr),
                setter=partial(values.__setitem__, vr),
            )
            variable.value_reference = vr
            self.vars[vr] = variable
        if PLAN["switch"]:
            switch = Boolean(
                PLAN["switch"],
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.fixed,
                getter=lambda: bool(self._asked[TANGENT]),
                setter=partial(self._asked.__setitem__, TANGENT),
            )
            switch.value_reference = len(values)
            self.vars[len(values)] = switch

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return what the guard asks for; values where it asks for none of its own.

        Parameters
        ----------
        vrs
            Value references; the first one tells whether the guard asks.

        Returns
        -------
        list of float
            One value a reference. For the guard: addresses, or 1 where the work is done and 0 where not.
        """
        if vrs[0] == HANDOVER:
            return self.addresses()
        if vrs[0] == OUTPUT_NOW:
            return [float(self._kernel("hf_output")(self._values, self._asked[TIME]))]
        if vrs[0] == PIVOT_NOW:
            self._asked[PIVOT_JOINT], self._asked[PIVOT_VALUE] = KERNEL.hf_pivot(self._values, self._asked[TIME])
            return [1.0]
        return [self._values[vr] for vr in vrs]

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the state by the plain-Python kernel.

        Parameters
        ----------
        current_time
            Time at the start of the step [s].
        step_size
            Length of the step [s].

        Returns
        -------
        bool
            Whether the state stayed finite.
        """
        return bool(self._kernel("hf_step")(self._values, current_time, step_size))
