"""The slave inside a Python FMU: FMI calls on one flat buffer, stepped by the compiled kernel beside this file.

This file is copied into the FMU under a name that holds the digest of the FMU's content, so that two FMUs in one
process never share a module, and imported by a module that holds little else. It needs the standard library and
pythonfmu only. `plan.json` tells it everything else.

pythonfmu turns a Python exception into fmi2Fatal and drops the instance. So nothing here raises: what is wrong goes to
the logger as an error, at once, and no step is done until it is put right. The guard around pythonfmu's loader turns a
call during which an error was logged into fmi2Error.

Values, flags and the time stand in arrays whose addresses the guard gets (`Slave.addresses`). Calls in which nothing is
wrong it then answers from them without Python; all others come here. Both keep the same arrays, so that it makes no
difference which of the two answers.
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
from pythonfmu.enums import Fmi2Status

HERE = Path(__file__).resolve().parent
PLAN = json.loads((HERE / "plan.json").read_text(encoding="utf-8"))
SIZE = len(PLAN["start"])
INFINITY = float("inf")
HANDOVER = 0x68617074
"""Value reference under which the guard asks for the addresses."""
EXACT = 2.0**53
"""Whole numbers below are exact as doubles."""
STALE, UNCHECKED, TANGENT, FAULTY = range(4)
"""Places of the flags: outputs to be computed, values to be checked, sensitivities on, values refused."""
MACHINES = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}


def load_kernel() -> Any:
    """Return the kernel: the compiled library for this platform, else the same formulas in plain Python."""
    machine = MACHINES.get(platform.machine().lower(), platform.machine().lower())
    for path in sorted((HERE / "kernel").glob(f"{sys.platform}-{machine}*")):
        try:
            library = ctypes.CDLL(str(path))
        except OSError:
            continue
        for name in PLAN["functions"]:
            getattr(library, name).argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double][
                : 3 if "step" in name else 2
            ]
        return library
    return importlib.import_module(f"{PLAN['module']}_fallback")


KERNEL = load_kernel()
COMPILED = isinstance(KERNEL, ctypes.CDLL)


def keep(names: dict[str, Any]) -> None:
    """Add a reference to the names of the entry module.

    pythonfmu 0.7 drops one at each instantiation that it never had, and with the last one the module's names are gone.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(names))


class Slave(Fmi2Slave):
    """One instance: a buffer, the time, and whether the outputs still hold."""

    def __init__(self, **kwargs: Any) -> None:
        """Make the buffer with its start values."""
        super().__init__(**kwargs)
        keep(vars(sys.modules[PLAN["module"]]))
        self.modelName = PLAN["identifier"]
        self._values = array("d", PLAN["start"])
        self._buffer = ctypes.c_void_p(self._values.buffer_info()[0]) if COMPILED else self._values
        self._clock = array("d", [0.0])
        self._flags = array("i", [1, 1, 0, 0])
        self._faults: dict[int, str] = {}
        self._minimum, self._maximum = array("d", PLAN["minimum"]), array("d", PLAN["maximum"])
        self._stale_from = PLAN["stale_from"]
        self._register()

    def addresses(self) -> list[float]:
        """Return what the guard needs to answer in place of this object; zeros where there is no compiled kernel."""
        names = ("hf_step", "hf_step_tangent", "hf_output", "hf_output_tangent")
        arrays = self._values, self._flags, self._clock, self._minimum, self._maximum
        found = [a.buffer_info()[0] for a in arrays]
        present = [getattr(KERNEL, name) if COMPILED and hasattr(KERNEL, name) else None for name in names]
        found += [ctypes.cast(f, ctypes.c_void_p).value or 0 if f else 0 for f in present]
        known = COMPILED and all(0 <= address < EXACT for address in found)
        counts = SIZE, self._stale_from, len(PLAN["orderings"])
        return [float(x) if known else 0.0 for x in (*counts, *found)]

    def _use_tangent(self, on: bool) -> None:
        self._flags[TANGENT] = bool(on)
        self._flags[STALE] = 1

    def _kernel(self, name: str) -> Any:
        return getattr(KERNEL, f"{name}_tangent" if self._flags[TANGENT] else name)

    def _register(self) -> None:
        values = self._values
        for name, vr, causality, variability, initial in PLAN["variables"]:
            variable = Real(
                name,
                causality=Fmi2Causality[causality],
                variability=Fmi2Variability[variability],
                initial=Fmi2Initial[initial] if initial else None,
                getter=partial(self._get, vr),
                setter=partial(values.__setitem__, vr),
            )
            variable.value_reference = vr
            self.vars[vr] = variable
        if PLAN["switch"]:
            switch = Boolean(
                PLAN["switch"],
                causality=Fmi2Causality.parameter,
                variability=Fmi2Variability.fixed,
                getter=lambda: bool(self._flags[TANGENT]),
                setter=self._use_tangent,
            )
            switch.value_reference = len(values)
            self.vars[len(values)] = switch

    def _get(self, vr: int) -> float:
        return self.get_real([vr])[0]

    def setup_experiment(self, start_time: float, *_: Any) -> None:
        """Take the start time."""
        self._clock[0] = start_time

    def exit_initialization_mode(self) -> None:
        """Say what does not make sense before the first step does."""
        self._consistent()

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return values, the outputs brought up to date."""
        if self._flags[STALE]:
            self._kernel("hf_output")(self._buffer, self._clock[0])
            self._flags[STALE] = 0
        values = self._values
        try:
            return [values[vr] for vr in vrs]
        except IndexError:
            if vrs[0] == HANDOVER:
                return self.addresses()
            self._error(f"value references {vrs}: expected 0..{len(values) - 1}")
            return [values[vr] if 0 <= vr < len(values) else float("nan") for vr in vrs]

    def set_real(self, vrs: list[int], new: list[float]) -> None:
        """Set values that lie within their range; refuse others."""
        values, minimum, maximum = self._values, self._minimum, self._maximum
        for vr, value in zip(vrs, new):  # noqa: B905 # called at every step, and pythonfmu makes both lists
            if not (0 <= vr < SIZE and minimum[vr] <= value <= maximum[vr]):
                self._refuse(vr, value)
                continue
            values[vr] = value
            if vr >= self._stale_from:
                self._flags[STALE] = self._flags[UNCHECKED] = 1
            if self._faults:
                self._faults.pop(vr, None)
                self._flags[FAULTY] = bool(self._faults)

    def set_boolean(self, vrs: list[int], new: list[bool]) -> None:
        """Switch the sensitivities."""
        for vr, value in zip(vrs, new, strict=True):
            if vr in self.vars and isinstance(self.vars[vr], Boolean):
                self._use_tangent(value)
            else:
                self._refuse(vr, value)

    def _refuse(self, vr: int, value: float) -> None:
        if vr in self.vars and vr < len(self._minimum) and self._minimum[vr] <= self._maximum[vr]:
            text = f"{self.vars[vr].name}: expected {self._minimum[vr]} <= value <= {self._maximum[vr]}, got {value}"
        else:
            text = f"value reference {vr}: expected an input, a state or a parameter; got the value {value}"
        self._faults[vr] = text
        self._flags[UNCHECKED] = self._flags[FAULTY] = 1
        self._error(text)

    def _consistent(self) -> bool:
        """Whether all values make sense together; says so in the log where they do not."""
        faults = list(self._faults.values())
        for a, b in PLAN["orderings"]:
            if self._values[a] < self._values[b]:
                names = self.vars[a].name, self.vars[b].name
                faults.append(f"{names[0]} = {self._values[a]}: expected at least {names[1]} = {self._values[b]}")
        for text in faults:
            self._error(f"no step is done: {text}")
        self._flags[UNCHECKED] = bool(faults)
        return not faults

    def _error(self, text: str) -> None:
        self.log(text, Fmi2Status.error)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the state; whether it worked."""
        if self._flags[UNCHECKED] and not self._consistent():
            return False
        if not 0.0 < step_size < INFINITY:
            self._error(f"communication step: expected a positive number of seconds, got {step_size}")
            return False
        self._clock[0] = current_time + step_size
        if self._kernel("hf_step")(self._buffer, current_time, step_size):
            self._flags[STALE] = 0
            return True
        self._error(f"the state left the finite numbers between t = {current_time} s and {self._clock[0]} s")
        return False

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"values": self._values.tolist(), "time": self._clock[0], "tangent": bool(self._flags[TANGENT])}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._values[:] = array("d", state["values"])
        self._clock[0] = state["time"]
        self._use_tangent(state["tangent"])
        self._faults = {}
        self._flags[FAULTY] = 0
