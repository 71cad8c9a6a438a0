"""An FMI 3.0 instance by ctypes alone, brought into any mode, and calls with arguments of every kind."""

from __future__ import annotations

import ctypes
import math
import tempfile
from collections.abc import Callable
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any

import fmpy

from haptid.fmu_build.building.packaging import Fmu
from tests.fmu_build.conformance.table3 import CLOCKS, CONTINUOUS_TYPES, DISCRETE_TYPES
from tests.fmu_build.fmu_cases import FOLDER

STOP = 10.0
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
Call = Callable[["Harness3"], int]


class Harness3:
    """One instance of ``co-simulation`` or ``model exchange``."""

    def __init__(self, built: Fmu, interface: str) -> None:
        folder = fmpy.extract(str(built.path), unzipdir=tempfile.mkdtemp(dir=FOLDER))
        about = fmpy.read_model_description(folder)
        self.vr = {v.name: int(v.valueReference) for v in about.modelVariables}
        (self.joint,) = {name.partition(".")[0] for name in self.vr if name.startswith("joint")}
        self.interface, self.messages, self.kept = interface, [], []
        path = next(Path(folder, "binaries").glob(f"*/{about.coSimulation.modelIdentifier}.*"))
        self.library = ctypes.CDLL(str(path))
        self.log = LOGGER(lambda _e, _s, _c, message: self.messages.append(message.decode()))
        token, name = about.guid.encode(), b"harness"
        make = (
            self.library.fmi3InstantiateCoSimulation
            if interface == "co-simulation"
            else self.library.fmi3InstantiateModelExchange
        )
        make.restype = c_void_p
        flags = (c_bool(False), c_bool(True))  # visible, loggingOn
        more = (c_bool(False), c_bool(False), None, c_size_t(0)) if interface == "co-simulation" else ()
        last = (None,) if interface == "co-simulation" else ()
        made = make(name, token, None, *flags, *more, None, self.log, *last)
        assert made, self.messages
        self.component = c_void_p(made)

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function; its status."""
        return int(getattr(self.library, f"fmi3{name}")(self.component, *arguments))

    def free(self) -> None:
        """Free the instance."""
        self.library.fmi3FreeInstance.restype = None
        self.library.fmi3FreeInstance(self.component)

    def reference(self, name: str) -> int:
        """Value reference of a variable of the joint, or of time."""
        return self.vr[name] if name in self.vr else self.vr[f"{self.joint}.{name}"]

    def at(self, *names: str) -> Any:
        """Array of value references."""
        return (c_uint * len(names))(*(self.reference(name) for name in names))

    def set(self, name: str, value: float) -> int:
        """Set one variable."""
        return self.call("SetFloat64", self.at(name), c_size_t(1), doubles(value), c_size_t(1))

    def step(self, t: float, dt: float, *, place: bool = True) -> int:
        """Do a communication step."""
        flags = [c_bool() for _ in range(3)]
        places = [*map(byref, flags), byref(c_double())] if place else [None] * 4
        return self.call("DoStep", c_double(t), c_double(dt), c_bool(True), *places)

    def initialise(self, start: float = 0.0, *, stop: float | None = STOP) -> int:
        """Enter initialization mode."""
        given = c_bool(stop is not None)
        return self.call(
            "EnterInitializationMode", c_bool(False), c_double(0), c_double(start), given, c_double(stop or 0.0)
        )

    def bring(self, mode: str) -> None:
        """Reset the instance and bring it into a mode, at t = 0."""
        assert self.call("Reset") == 0, self.messages
        if mode == "I":
            return
        assert self.initialise() == 0, self.messages
        if mode == "N":
            return
        assert self.call("ExitInitializationMode") == 0, self.messages
        if mode == "C":
            assert self.call("EnterContinuousTimeMode") == 0, self.messages
        elif mode == "T":
            assert self.call("Terminate") == 0, self.messages

    def saved(self) -> c_void_p:
        """A state of the instance."""
        state = c_void_p(None)
        assert self.call("GetFMUState", byref(state)) == 0
        self.kept.append(state)
        return state

    def bytes_of(self, state: c_void_p) -> bytes:
        """The bytes of a state."""
        size = c_size_t()
        assert self.call("SerializedFMUStateSize", state, byref(size)) == 0
        content = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUState", state, content, size) == 0
        return content.raw

    def read(self, content: bytes | None) -> int:
        """Deserialise bytes; the status."""
        state = c_void_p(None)
        status = self.call("DeserializeFMUState", content, c_size_t(len(content or b"")), byref(state))
        assert bool(state) == (status == 0)
        self.kept.append(state)
        return status

    def tidy(self) -> None:
        """Free the states that were saved; each is freed and its pointer taken away."""
        for state in self.kept:
            assert self.call("FreeFMUState", byref(state)) == 0
            assert not state
        self.kept.clear()


def doubles(*x: float) -> Any:
    return (c_double * len(x))(*x)


def plain(name: str, *arguments: Any) -> dict[str, Call]:
    return {"plain": lambda h: h.call(name, *arguments)}


def real(name: str, *pairs: tuple[str, float]) -> Call:
    """A call that sets or gets variables."""
    return lambda h: h.call(
        name, h.at(*(v for v, _ in pairs)), c_size_t(len(pairs)), doubles(*(x for _, x in pairs)), c_size_t(len(pairs))
    )


def by_reference(name: str, reference: int) -> Call:
    return lambda h: h.call(name, (c_uint * 1)(reference), c_size_t(1), doubles(0.0), c_size_t(1))


def of_type(name: str) -> dict[str, Call]:
    """Calls of a function for values that the FMU does not have; binaries have sizes beside them."""
    places = 2 if name.endswith("Binary") else 1
    room = (c_size_t * 8)()
    return {
        "nothing": lambda h: h.call(name, None, c_size_t(0), *[None] * places, c_size_t(0)),
        "one": lambda h: h.call(name, (c_uint * 1)(0), c_size_t(1), *[room] * places, c_size_t(1)),
    }


def of_clock(name: str) -> dict[str, Call]:
    room = (c_size_t * 8)()
    return {
        "nothing": lambda h: h.call(name, None, c_size_t(0), None, None, None),
        "one": lambda h: h.call(name, (c_uint * 1)(0), c_size_t(1), room, room, room),
    }


def states(name: str, n: int, *x: float) -> Call:
    return lambda h: h.call(name, doubles(*x) if x else None, c_size_t(n))


def of_states(name: str) -> dict[str, Call]:
    return {"plain": states(name, 3, *X), "too few": states(name, 2, *X), "no arrays": states(name, 3)}


def derivative(name: str, unknown: str, known: str, *, seeds: int = 1) -> Call:
    one = c_size_t(1)
    return lambda h: h.call(
        name, h.at(unknown), one, h.at(known), one, doubles(*[1.0] * seeds), c_size_t(seeds), doubles(0.0), one
    )


def derivatives(name: str) -> dict[str, Call]:
    one = c_size_t(1)
    return {
        "output by state": derivative(name, "reading", "position"),
        "unknown by output": derivative(name, "reading", "reading"),
        "input as unknown": derivative(name, "torque", "position"),
        "no arrays": lambda h: h.call(name, None, one, None, one, None, one, None, one),
        "other number of seeds": derivative(name, "reading", "position", seeds=2),
    }


def logging(n: int, *categories: bytes) -> Call:
    return lambda h: h.call(
        "SetDebugLogging", c_bool(True), c_size_t(n), (c_char_p * n)(*categories) if categories else None
    )


def begun(start: float, stop: float | None) -> Call:
    return lambda h: h.initialise(start, stop=stop)


def step(t: float, dt: float) -> Call:
    return lambda h: h.step(t, dt)


def own_state(name: str, *more: Any) -> Call:
    return lambda h: h.call(name, h.saved(), *more)


def serialised(short: int = 0, *, place: bool = True) -> Call:
    def run(h: Harness3) -> int:
        state = h.saved()
        size = len(h.bytes_of(state)) - short
        return h.call("SerializeFMUState", state, ctypes.create_string_buffer(size) if place else None, c_size_t(size))

    return run


def foreign(h: Harness3) -> int:
    """Restore a state whose identity is that of another FMU."""
    state = h.saved()
    ctypes.memset(state, ord("x"), 8)
    return h.call("SetFMUState", state)


def new(h: Harness3) -> int:
    h.saved()
    return 0


def freed(h: Harness3) -> int:
    h.saved()
    h.tidy()
    return 0


def past_the_stop(h: Harness3) -> int:
    h.call("SetTime", c_double(STOP + 1))
    return h.call("CompletedIntegratorStep", c_bool(True), byref(c_bool()), byref(c_bool()))


def inconsistent(last: Call) -> Call:
    return lambda h: (h.set("friction.Fs", 1e-4), last(h))[1]


def runs_away(h: Harness3) -> int:
    """Step from a speed that no number can square."""
    if h.interface == "co-simulation" and h.call("DoStep", c_double(0), c_double(0.01), c_bool(True), *PLACES) == 0:
        h.bring("I")
        h.set("velocity", 1e300)
        h.initialise()
        h.call("ExitInitializationMode")
        return h.step(0.0, 0.1)
    return h.step(0.0, 0.1)


PLACES = (byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double()))
ROOM = (c_size_t * 8)()
X = (0.01, 0.02, 1e-5)
"""States of one joint with LuGre friction: position, velocity, bristle."""
UPDATED = tuple(byref(c_bool()) for _ in range(5))

CALLS3: dict[str, dict[str, Call]] = {
    "GetVersion": {"plain": lambda h: int(h.library.fmi3GetVersion() == 0)},
    "SetDebugLogging": {
        "all": logging(0),
        "known category": logging(1, b"logStatusError"),
        "unknown category": logging(1, b"logAll"),
        "no arrays": logging(1),
    },
    "EnterInitializationMode": {
        "plain": begun(0.5, None),
        "with stop time": begun(0.5, 2.0),
        "stop before start": begun(0.5, 0.2),
        "NaN start": begun(math.nan, None),
        "NaN stop": begun(0.5, math.nan),
    },
    "ExitInitializationMode": {
        **plain("ExitInitializationMode"),
        "inconsistent values": inconsistent(lambda h: h.call("ExitInitializationMode")),
    },
    "Terminate": plain("Terminate"),
    "Reset": plain("Reset"),
    "GetFloat64": {
        "nothing": lambda h: h.call("GetFloat64", None, c_size_t(0), None, c_size_t(0)),
        "input": real("GetFloat64", ("torque", 0.0)),
        "state": real("GetFloat64", ("velocity", 0.0)),
        "parameter": real("GetFloat64", ("inertia", 0.0)),
        "time": real("GetFloat64", ("time", 0.0)),
        "output": real("GetFloat64", ("reading", 0.0)),
        "derivative": lambda h: h.call(
            "GetFloat64", (c_uint * 1)(h.vr[f"der({h.joint}.velocity)"]), c_size_t(1), doubles(0.0), c_size_t(1)
        ),
        "unknown": by_reference("GetFloat64", 9999),
        "huge reference": by_reference("GetFloat64", 2**32 - 1),
        "no arrays": lambda h: h.call("GetFloat64", None, c_size_t(1), None, c_size_t(1)),
        "other number of values": lambda h: h.call("GetFloat64", h.at("torque"), c_size_t(1), ROOM, c_size_t(2)),
    },
    "SetFloat64": {
        "nothing": lambda h: h.call("SetFloat64", None, c_size_t(0), None, c_size_t(0)),
        "input": real("SetFloat64", ("torque", 1e-3)),
        "parameter": real("SetFloat64", ("spring.Ks", 0.011)),
        "state": real("SetFloat64", ("velocity", 0.1)),
        "time": real("SetFloat64", ("time", 1.0)),
        "output": real("SetFloat64", ("reading", 0.1)),
        "outside": real("SetFloat64", ("inertia", -1.0)),
        "NaN": real("SetFloat64", ("torque", math.nan)),
        "infinity": real("SetFloat64", ("torque", math.inf)),
        "good and bad": real("SetFloat64", ("torque", 1e-3), ("inertia", -1.0)),
        "unknown": by_reference("SetFloat64", 9999),
        "no arrays": lambda h: h.call("SetFloat64", None, c_size_t(1), None, c_size_t(1)),
        "other number of values": lambda h: h.call(
            "SetFloat64", h.at("torque"), c_size_t(1), doubles(0.0, 0.0), c_size_t(2)
        ),
    },
    **{
        f"{verb}{kind}": of_type(f"{verb}{kind}")
        for verb in ("Get", "Set")
        for kind in (*CONTINUOUS_TYPES, *DISCRETE_TYPES)
    },
    **{name: of_clock(name) for name in CLOCKS},
    "ActivateModelPartition": plain("ActivateModelPartition", c_uint(0), c_double(0)),
    "EnterConfigurationMode": plain("EnterConfigurationMode"),
    "ExitConfigurationMode": plain("ExitConfigurationMode"),
    "EnterStepMode": plain("EnterStepMode"),
    "EvaluateDiscreteStates": plain("EvaluateDiscreteStates"),
    "GetNumberOfVariableDependencies": plain("GetNumberOfVariableDependencies", c_uint(0), ROOM),
    "GetVariableDependencies": plain("GetVariableDependencies", c_uint(0), ROOM, ROOM, ROOM, ROOM, c_size_t(1)),
    "GetFMUState": {
        "new": new,
        "again": lambda h: h.call("GetFMUState", byref(h.saved())),
        "no place": lambda h: h.call("GetFMUState", None),
    },
    "SetFMUState": {
        "own": own_state("SetFMUState"),
        "none": lambda h: h.call("SetFMUState", None),
        "foreign": foreign,
    },
    "FreeFMUState": {
        "own": freed,
        "none": lambda h: h.call("FreeFMUState", byref(c_void_p(None))),
        "no place": lambda h: h.call("FreeFMUState", None),
    },
    "SerializedFMUStateSize": {
        "own": own_state("SerializedFMUStateSize", ROOM),
        "no place": own_state("SerializedFMUStateSize", None),
    },
    "SerializeFMUState": {
        "own": serialised(),
        "none": lambda h: h.call("SerializeFMUState", None, ROOM, c_size_t(64)),
        "short": serialised(1),
        "no place": serialised(place=False),
    },
    "DeserializeFMUState": {
        "own": lambda h: h.read(h.bytes_of(h.saved())),
        "truncated": lambda h: h.read(h.bytes_of(h.saved())[:-1]),
        "nothing": lambda h: h.read(None),
    },
    "GetDirectionalDerivative": derivatives("GetDirectionalDerivative"),
    "GetAdjointDerivative": derivatives("GetAdjointDerivative"),
    "EnterEventMode": plain("EnterEventMode"),
    "UpdateDiscreteStates": {
        **plain("UpdateDiscreteStates", *UPDATED, byref(c_double())),
        "no place": lambda h: h.call("UpdateDiscreteStates", *[None] * 6),
    },
    "EnterContinuousTimeMode": plain("EnterContinuousTimeMode"),
    "CompletedIntegratorStep": {
        **plain("CompletedIntegratorStep", c_bool(True), byref(c_bool()), byref(c_bool())),
        "past the stop time": past_the_stop,
        "no place": lambda h: h.call("CompletedIntegratorStep", c_bool(True), None, None),
    },
    "SetTime": {
        **plain("SetTime", c_double(0.1)),
        "NaN": lambda h: h.call("SetTime", c_double(math.nan)),
        "infinity": lambda h: h.call("SetTime", c_double(math.inf)),
    },
    "SetContinuousStates": {
        **of_states("SetContinuousStates"),
        "NaN": states("SetContinuousStates", 3, math.nan, 0.0, 0.0),
    },
    **{
        name: of_states(name)
        for name in ("GetContinuousStateDerivatives", "GetContinuousStates", "GetNominalsOfContinuousStates")
    },
    "GetEventIndicators": {
        "nothing": states("GetEventIndicators", 0),
        "one": states("GetEventIndicators", 1, 0.0),
    },
    **{
        name: {**plain(name, ROOM), "no place": lambda h, name=name: h.call(name, None)}
        for name in ("GetNumberOfContinuousStates", "GetNumberOfEventIndicators")
    },
    "GetOutputDerivatives": {
        "nothing": lambda h: h.call("GetOutputDerivatives", None, c_size_t(0), None, None, c_size_t(0)),
        "one": lambda h: h.call(
            "GetOutputDerivatives", h.at("reading"), c_size_t(1), (c_int * 1)(1), doubles(0.0), c_size_t(1)
        ),
    },
    "DoStep": {
        "plain": step(0.0, 0.01),
        "up to the stop time": step(0.0, STOP),
        "rounded time": step(1e-12, 0.01),
        "past the stop time": step(0.0, STOP + 0.01),
        "earlier time": step(-0.01, 0.01),
        "later time": step(0.01, 0.01),
        "NaN time": step(math.nan, 0.01),
        "no step": step(0.0, 0.0),
        "step back": step(0.0, -0.01),
        "NaN step": step(0.0, math.nan),
        "infinite step": step(0.0, math.inf),
        "step beyond all counting": step(0.0, 1e300),
        "no place": lambda h: h.step(0.0, 0.01, place=False),
        "inconsistent values": inconsistent(step(0.0, 0.01)),
        "one that leaves the finite numbers": runs_away,
    },
}
"""Calls by function and kind of argument, the keys of `table3.TABLE3`."""
