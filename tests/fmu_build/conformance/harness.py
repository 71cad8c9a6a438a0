"""An FMI 2.0 instance by ctypes alone, brought into any mode, and calls with arguments of every kind."""

from __future__ import annotations

import ctypes
import struct
import tempfile
from collections.abc import Callable
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any

import fmpy

from haptid.fmu_build.building.packaging import Fmu
from tests.fmu_build.fmu_cases import FOLDER

NAN, INFINITY, STOP = float("nan"), float("inf"), 10.0
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
ALLOCATE, RELEASE = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t), ctypes.CFUNCTYPE(None, c_void_p)
TYPES = {"model exchange": 0, "co-simulation": 1}


class Callbacks(ctypes.Structure):
    """``fmi2CallbackFunctions``."""

    _fields_ = (
        ("logger", LOGGER),
        ("allocate", ALLOCATE),
        ("release", RELEASE),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


class Harness:
    """One instance; memory that it takes from the host is counted.

    Parameters
    ----------
    built
        FMU of one joint.
    interface
        Key of `TYPES`.
    """

    def __init__(self, built: Fmu, interface: str) -> None:
        folder = fmpy.extract(str(built.path), unzipdir=tempfile.mkdtemp(dir=FOLDER))
        about = fmpy.read_model_description(folder)
        kind = about.coSimulation or about.modelExchange
        self.vr = {v.name: int(v.valueReference) for v in about.modelVariables}
        (self.joint,) = {name.partition(".")[0] for name in self.vr if name.startswith("joint")}
        self.starts = {v.name: float(v.start) for v in about.modelVariables if v.start is not None}
        self.messages: list[str] = []
        self.blocks: dict[int, Any] = {}
        self.kept: list[Any] = []
        self.interface = interface
        path = next(Path(folder, "binaries").glob(f"*/{kind.modelIdentifier}.*"))
        self.library = ctypes.CDLL(str(path))
        self.callbacks = Callbacks(LOGGER(self._log), ALLOCATE(self._allocate), RELEASE(self._release), None, None)
        self.library.fmi2Instantiate.restype = c_void_p
        uri = Path(folder, "resources").as_uri().encode()
        made = self.library.fmi2Instantiate(
            b"harness", TYPES[interface], about.guid.encode(), uri, byref(self.callbacks), 0, 1
        )
        assert made, self.messages
        self.component = c_void_p(made)

    def _log(self, _: object, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
        self.messages.append(message.decode())

    def _allocate(self, n: int, size: int) -> int:
        block = ctypes.create_string_buffer(n * size + 16)
        # addresses of doubles are multiples of 8, as those of calloc
        address = (ctypes.addressof(block) + 15) // 16 * 16
        self.blocks[address] = block
        return address

    def _release(self, address: int) -> None:
        if address:
            del self.blocks[address]  # KeyError where it was freed twice, or never given

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function; its status."""
        return int(getattr(self.library, name)(self.component, *arguments))

    def free(self) -> None:
        """Free the instance."""
        self.library.fmi2FreeInstance.restype = None
        self.library.fmi2FreeInstance(self.component)

    def reference(self, name: str) -> int:
        """Value reference of a variable of the joint."""
        return self.vr[f"{self.joint}.{name}"]

    def start(self, name: str) -> float:
        """Start value of a variable of the joint."""
        return self.starts[f"{self.joint}.{name}"]

    def set(self, name: str, value: float) -> int:
        """Set one real variable."""
        return self.call("fmi2SetReal", (c_uint * 1)(self.reference(name)), c_size_t(1), (c_double * 1)(value))

    def get(self, name: str) -> float:
        """Read one real variable."""
        value = (c_double * 1)()
        assert self.call("fmi2GetReal", (c_uint * 1)(self.reference(name)), c_size_t(1), value) == 0, self.messages[-1]
        return value[0]

    def step(self, t: float, dt: float) -> int:
        """Do a communication step."""
        return self.call("fmi2DoStep", c_double(t), c_double(dt), 1)

    def bring(self, mode: str) -> None:
        """Reset the instance and bring it into a mode, at t = 0."""
        assert self.call("fmi2Reset") == 0, self.messages
        self.call("fmi2SetupExperiment", 0, c_double(0), c_double(0), 1, c_double(STOP))
        if mode == "I":
            return
        self.call("fmi2EnterInitializationMode")
        if mode == "N":
            return
        if mode == "F":
            assert self.set("velocity", 1e300) == 0
        assert self.call("fmi2ExitInitializationMode") == 0, self.messages
        if mode == "C":
            assert self.call("fmi2EnterContinuousTimeMode") == 0
        elif mode == "F":
            assert self.step(0.0, 0.1) == 2
        elif mode == "T":
            assert self.call("fmi2Terminate") == 0

    def saved(self) -> c_void_p:
        """A state of the instance."""
        state = c_void_p(None)
        assert self.call("fmi2GetFMUstate", byref(state)) == 0
        self.kept.append(state)
        return state

    def bytes_of(self, state: c_void_p) -> bytes:
        """The bytes of a state."""
        size = c_size_t()
        assert self.call("fmi2SerializedFMUstateSize", state, byref(size)) == 0
        content = ctypes.create_string_buffer(size.value)
        assert self.call("fmi2SerializeFMUstate", state, content, size) == 0
        return content.raw

    def read(self, content: bytes) -> int:
        """Deserialise bytes; the status."""
        state = c_void_p(None)
        status = self.call("fmi2DeSerializeFMUstate", content, c_size_t(len(content)), byref(state))
        assert bool(state) == (status == 0)
        self.kept.append(state)
        return status

    def tidy(self) -> None:
        """Free the states that were saved; each is freed and its pointer taken away."""
        for state in self.kept:
            assert self.call("fmi2FreeFMUstate", byref(state)) == 0
            assert not state
        self.kept.clear()


def values(function: str, kind_of: Callable[[int], Any]) -> dict[str, Callable[[Harness], int]]:
    """Calls of a function for values with nothing, with an unknown reference, and without arrays."""
    return {
        "none": lambda h: h.call(function, None, c_size_t(0), None),
        "unknown": lambda h: h.call(function, (c_uint * 1)(9999), c_size_t(1), kind_of(1)),
        "no arrays": lambda h: h.call(function, None, c_size_t(1), None),
    }


def doubles(*x: float) -> Any:
    return (c_double * len(x))(*x)


def real(name: str, *pairs: tuple[str, float]) -> Callable[[Harness], int]:
    """A call that sets or gets real variables."""
    return lambda h: h.call(
        name,
        (c_uint * len(pairs))(*(h.reference(v) for v, _ in pairs)),
        c_size_t(len(pairs)),
        doubles(*(x for _, x in pairs)),
    )


def plain(name: str, *arguments: Any) -> dict[str, Callable[[Harness], int]]:
    return {"plain": lambda h: h.call(name, *arguments)}


def changed(h: Harness, find: bytes, put: bytes) -> int:
    """Deserialise the present state with some of its bytes replaced."""
    content = h.bytes_of(h.saved())
    assert find in content
    return h.read(content.replace(find, put, 1))


def bad_mode(h: Harness) -> int:
    """Deserialise a state whose mode there is not: the last but one of its integers."""
    content = h.bytes_of(h.saved())
    place = len(content) - 4 * (2 + (len(content) - 3 * 4) % 8 // 4)
    return h.read(content[:place] + struct.pack("i", 4096) + content[place + 4 :])


def own_state(function: str, *more: Any) -> Callable[[Harness], int]:
    return lambda h: h.call(function, h.saved(), *more)


def at(h: Harness, name: str) -> Any:
    return (c_uint * 1)(h.reference(name))


def slope(name: str, order: int, value: float) -> Callable[[Harness], int]:
    return lambda h: h.call("fmi2SetRealInputDerivatives", at(h, name), c_size_t(1), (c_int * 1)(order), doubles(value))


def derivative(unknown: str, known: str) -> Callable[[Harness], int]:
    return lambda h: h.call(
        "fmi2GetDirectionalDerivative",
        at(h, unknown),
        c_size_t(1),
        at(h, known),
        c_size_t(1),
        doubles(1.0),
        doubles(0.0),
    )


def setup(start: float, given: int = 0, stop: float = 0.0) -> Callable[[Harness], int]:
    return lambda h: h.call("fmi2SetupExperiment", 0, c_double(0), c_double(start), given, c_double(stop))


def step(t: float, dt: float) -> Callable[[Harness], int]:
    return lambda h: h.step(t, dt)


def status(name: str, kind: int, *, place: bool = True) -> Callable[[Harness], int]:
    return lambda h: h.call(name, kind, ctypes.create_string_buffer(8) if place else None)


def states(name: str, n: int, *x: float) -> Callable[[Harness], int]:
    return lambda h: h.call(name, doubles(*x) if x else None, c_size_t(n))


def past_the_stop(h: Harness) -> int:
    h.call("fmi2SetTime", c_double(STOP + 1))
    return h.call("fmi2CompletedIntegratorStep", 1, byref(c_int()), byref(c_int()))


def logging(n: int, *categories: bytes) -> Callable[[Harness], int]:
    return lambda h: h.call("fmi2SetDebugLogging", 1, c_size_t(n), (c_char_p * n)(*categories) if categories else None)


def serialised(short: int = 0, *, place: bool = True) -> Callable[[Harness], int]:
    def run(h: Harness) -> int:
        state = h.saved()
        size = len(h.bytes_of(state)) - short
        return h.call(
            "fmi2SerializeFMUstate", state, ctypes.create_string_buffer(size) if place else None, c_size_t(size)
        )

    return run


def foreign(h: Harness) -> int:
    """Restore a state whose identity is that of another FMU."""
    state = h.saved()
    ctypes.memset(state, ord("x"), 8)
    return h.call("fmi2SetFMUstate", state)


def again(h: Harness) -> int:
    """Save into a state that is held already: no memory is taken."""
    state, before = h.saved(), len(h.blocks)
    result = h.call("fmi2GetFMUstate", byref(state))
    assert len(h.blocks) == before
    return result


def new(h: Harness) -> int:
    h.saved()
    return 0


def freed(h: Harness) -> int:
    h.saved()
    h.tidy()
    return 0


PLACE = (c_size_t * 8)()
X = (0.01, 0.02, 1e-5)
"""States of one joint with LuGre friction: position, velocity, bristle."""

CALLS: dict[str, dict[str, Callable[[Harness], int]]] = {
    "fmi2GetTypesPlatform": {"plain": lambda h: int(h.library.fmi2GetTypesPlatform() == 0)},
    "fmi2GetVersion": {"plain": lambda h: int(h.library.fmi2GetVersion() == 0)},
    "fmi2SetDebugLogging": {
        "all": logging(0),
        "known category": logging(1, b"logStatusError"),
        "unknown category": logging(1, b"logAll"),
        "no arrays": logging(1),
    },
    "fmi2SetupExperiment": {
        "plain": setup(0.5),
        "with stop time": setup(0.5, 1, 2.0),
        "stop before start": setup(0.5, 1, 0.2),
        "NaN start": setup(NAN),
        "NaN stop": setup(0.5, 1, NAN),
    },
    "fmi2EnterInitializationMode": {
        **plain("fmi2EnterInitializationMode"),
        "before fmi2SetupExperiment": lambda h: (h.call("fmi2Reset"), h.call("fmi2EnterInitializationMode"))[1],
    },
    "fmi2ExitInitializationMode": {
        **plain("fmi2ExitInitializationMode"),
        "inconsistent values": lambda h: (h.set("friction.Fs", 1e-4), h.call("fmi2ExitInitializationMode"))[1],
    },
    "fmi2Terminate": plain("fmi2Terminate"),
    "fmi2Reset": plain("fmi2Reset"),
    "fmi2GetReal": {
        **values("fmi2GetReal", lambda n: (c_double * n)()),
        "input": real("fmi2GetReal", ("torque", 0.0)),
        "state": real("fmi2GetReal", ("velocity", 0.0)),
        "parameter": real("fmi2GetReal", ("inertia", 0.0)),
        "output": real("fmi2GetReal", ("reading", 0.0)),
        "huge reference": lambda h: h.call("fmi2GetReal", (c_uint * 1)(2**32 - 1), c_size_t(1), doubles(0.0)),
    },
    "fmi2SetReal": {
        **values("fmi2SetReal", lambda n: (c_double * n)()),
        "input": real("fmi2SetReal", ("torque", 1e-3)),
        "parameter": real("fmi2SetReal", ("spring.Ks", 0.011)),
        "state": real("fmi2SetReal", ("velocity", 0.1)),
        "output": real("fmi2SetReal", ("reading", 0.1)),
        "outside": real("fmi2SetReal", ("inertia", -1.0)),
        "NaN": real("fmi2SetReal", ("torque", NAN)),
        "infinity": real("fmi2SetReal", ("torque", INFINITY)),
        "good and bad": real("fmi2SetReal", ("torque", 1e-3), ("inertia", -1.0)),
    },
    "fmi2GetInteger": values("fmi2GetInteger", lambda n: (c_int * n)()),
    "fmi2SetInteger": values("fmi2SetInteger", lambda n: (c_int * n)()),
    "fmi2GetBoolean": values("fmi2GetBoolean", lambda n: (c_int * n)()),
    "fmi2SetBoolean": values("fmi2SetBoolean", lambda n: (c_int * n)()),
    "fmi2GetString": values("fmi2GetString", lambda n: (c_char_p * n)()),
    "fmi2SetString": values("fmi2SetString", lambda n: (c_char_p * n)()),
    "fmi2GetFMUstate": {"new": new, "again": again, "no place": lambda h: h.call("fmi2GetFMUstate", None)},
    "fmi2SetFMUstate": {
        "own": own_state("fmi2SetFMUstate"),
        "none": lambda h: h.call("fmi2SetFMUstate", None),
        "foreign": foreign,
    },
    "fmi2FreeFMUstate": {
        "own": freed,
        "none": lambda h: h.call("fmi2FreeFMUstate", byref(c_void_p(None))),
        "no place": lambda h: h.call("fmi2FreeFMUstate", None),
    },
    "fmi2SerializedFMUstateSize": {
        "own": own_state("fmi2SerializedFMUstateSize", PLACE),
        "no place": own_state("fmi2SerializedFMUstateSize", None),
    },
    "fmi2SerializeFMUstate": {
        "own": serialised(),
        "none": lambda h: h.call("fmi2SerializeFMUstate", None, PLACE, c_size_t(64)),
        "short": serialised(1),
        "no place": serialised(place=False),
    },
    "fmi2DeSerializeFMUstate": {
        "own": lambda h: h.read(h.bytes_of(h.saved())),
        "truncated": lambda h: h.read(h.bytes_of(h.saved())[:-1]),
        "NaN parameter": lambda h: changed(h, struct.pack("d", h.start("spring.Ks")), struct.pack("d", NAN)),
        "bad mode": bad_mode,
        "nothing": lambda h: h.call("fmi2DeSerializeFMUstate", None, c_size_t(0), byref(c_void_p(None))),
    },
    "fmi2GetDirectionalDerivative": {
        "output by state": derivative("reading", "position"),
        "unknown by output": derivative("reading", "reading"),
        "input as unknown": derivative("torque", "position"),
    },
    "fmi2EnterEventMode": plain("fmi2EnterEventMode"),
    "fmi2NewDiscreteStates": {
        **plain("fmi2NewDiscreteStates", PLACE),
        "no place": lambda h: h.call("fmi2NewDiscreteStates", None),
    },
    "fmi2EnterContinuousTimeMode": plain("fmi2EnterContinuousTimeMode"),
    "fmi2CompletedIntegratorStep": {
        "plain": lambda h: h.call("fmi2CompletedIntegratorStep", 1, byref(c_int()), byref(c_int())),
        "past the stop time": past_the_stop,
        "no place": lambda h: h.call("fmi2CompletedIntegratorStep", 1, None, None),
    },
    "fmi2SetTime": {
        **plain("fmi2SetTime", c_double(0.1)),
        "NaN": lambda h: h.call("fmi2SetTime", c_double(NAN)),
        "infinity": lambda h: h.call("fmi2SetTime", c_double(INFINITY)),
    },
    "fmi2SetContinuousStates": {
        "plain": states("fmi2SetContinuousStates", 3, *X),
        "too few": states("fmi2SetContinuousStates", 2, *X),
        "NaN": states("fmi2SetContinuousStates", 3, NAN, 0.0, 0.0),
        "no arrays": states("fmi2SetContinuousStates", 3),
    },
    **{
        name: {"plain": states(name, 3, *X), "too few": states(name, 2, *X), "no arrays": states(name, 3)}
        for name in ("fmi2GetDerivatives", "fmi2GetContinuousStates", "fmi2GetNominalsOfContinuousStates")
    },
    "fmi2GetEventIndicators": {
        "none": states("fmi2GetEventIndicators", 0),
        "one": states("fmi2GetEventIndicators", 1, 0.0),
    },
    "fmi2SetRealInputDerivatives": {
        "input": slope("torque", 1, 0.1),
        "none": lambda h: h.call("fmi2SetRealInputDerivatives", None, c_size_t(0), None, None),
        "second order": slope("torque", 2, 0.1),
        "parameter": slope("inertia", 1, 0.1),
        "NaN": slope("torque", 1, NAN),
        "no arrays": lambda h: h.call("fmi2SetRealInputDerivatives", None, c_size_t(1), None, None),
    },
    "fmi2GetRealOutputDerivatives": {
        "none": lambda h: h.call("fmi2GetRealOutputDerivatives", None, c_size_t(0), None, None),
        "output": lambda h: h.call(
            "fmi2GetRealOutputDerivatives", at(h, "reading"), c_size_t(1), (c_int * 1)(1), doubles(0.0)
        ),
    },
    "fmi2DoStep": {
        "plain": step(0.0, 0.01),
        "up to the stop time": step(0.0, STOP),
        "rounded time": step(1e-12, 0.01),
        "past the stop time": step(0.0, STOP + 0.01),
        "earlier time": step(-0.01, 0.01),
        "later time": step(0.01, 0.01),
        "NaN time": step(NAN, 0.01),
        "no step": step(0.0, 0.0),
        "step back": step(0.0, -0.01),
        "NaN step": step(0.0, NAN),
        "infinite step": step(0.0, INFINITY),
        "step beyond all counting": step(0.0, 1e300),
        "inconsistent values": lambda h: (h.set("friction.Fs", 1e-4), h.step(0.0, 0.01))[1],
    },
    "fmi2CancelStep": plain("fmi2CancelStep"),
    "fmi2GetStatus": {"last step": status("fmi2GetStatus", 0), "no place": status("fmi2GetStatus", 0, place=False)},
    "fmi2GetRealStatus": {
        "last successful time": status("fmi2GetRealStatus", 2),
        "another": status("fmi2GetRealStatus", 0),
        "no place": status("fmi2GetRealStatus", 2, place=False),
    },
    "fmi2GetIntegerStatus": {
        "any": status("fmi2GetIntegerStatus", 0),
        "no place": status("fmi2GetIntegerStatus", 0, place=False),
    },
    "fmi2GetBooleanStatus": {
        "terminated": status("fmi2GetBooleanStatus", 3),
        "another": status("fmi2GetBooleanStatus", 0),
        "no place": status("fmi2GetBooleanStatus", 3, place=False),
    },
    "fmi2GetStringStatus": {
        "any": status("fmi2GetStringStatus", 1),
        "no place": status("fmi2GetStringStatus", 1, place=False),
    },
}
"""Calls by function and kind of argument, the keys of `table.TABLE`."""
