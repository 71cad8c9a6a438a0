"""The guard of a Python FMU steps the compiled kernel without Python, and the slave's own steps are no different."""

from __future__ import annotations

import sys
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.fmu_build.fmu_cases import Client, fmu

NAMES = ("joint4.torque", "joint4.inertia", "joint4.friction.Fs", "joint4.friction.Fc", "joint4.reading")
VALUES = (-1.0, 0.0, 2e-4, 1e-3, 5e-3, np.nan, np.inf)


@pytest.fixture
def implementation() -> Any:
    """The slave's module inside the FMU, which pythonfmu has imported into this process."""
    made = fmu("joint4", "python")
    Client(made).start()
    with ZipFile(made.path) as archive:
        module = archive.read("resources/slavemodule.txt").decode().strip()
    return sys.modules[f"{module}_slave"]


@pytest.fixture
def through_python(implementation, monkeypatch) -> list[str]:
    """Names of the calls that reached the slave."""
    seen: list[str] = []

    def counted(name: str) -> Any:
        real = getattr(implementation.Slave, name)
        return lambda self, *arguments: (seen.append(name), real(self, *arguments))[1]

    for name in ("get_real", "set_real", "do_step"):
        monkeypatch.setattr(implementation.Slave, name, counted(name))
    return seen


def called(function: Any, *arguments: Any) -> str | list[float]:
    try:
        return list(function(*arguments) or ())
    except FMICallException as error:
        return str(error)


def begun(client: Client, rng: np.random.Generator) -> list[Any]:
    client.start()
    inertia = rng.choice((2e-4, 3e-4, -1.0), p=[0.4, 0.4, 0.2])
    return [called(client.fmi.setReal, [client.vr[NAMES[1]]], [inertia]), called(client.fmi.exitInitializationMode)]


def saved_or_restored(fmi: Any, choice: str, t: float, kept: Any) -> tuple[float, Any]:
    """The time and what is kept after saving, or after restoring what was kept."""
    if choice == "save":
        return t, (t, fmi.serializeFMUstate(fmi.getFMUstate()))
    if kept:
        fmi.setFMUstate(fmi.deSerializeFMUstate(kept[1]))
    return (kept[0] if kept else t), kept


def played(seed: int, calls: int = 120) -> tuple[list[Any], list[str]]:
    """What a client sees and hears of random calls."""
    rng, client = np.random.default_rng(seed), Client(fmu("joint4", "python"))
    fmi, seen, running, t, kept = client.fmi, [], False, 0.0, None
    for _ in range(calls):
        choice = rng.choice(["set", "get", "step", "reset", "save", "restore"], p=[0.3, 0.2, 0.4, 0.04, 0.03, 0.03])
        if not running:
            seen, running, t, kept = seen + begun(client, rng), True, 0.0, None
        if choice == "set":
            chosen = rng.choice(len(NAMES), size=2, replace=False, p=[0.6, 0.1, 0.1, 0.1, 0.1])
            seen.append(called(fmi.setReal, [client.vr[NAMES[k]] for k in chosen], list(rng.choice(VALUES, size=2))))
        elif choice == "get":
            seen.append(client.get("joint4.reading", *NAMES))
        elif choice == "step":
            seen.append(called(fmi.doStep, t, dt := float(rng.choice((0.005, 0.01, -0.01), p=[0.6, 0.3, 0.1]))))
            t += dt * (seen[-1] == [])
        elif choice == "reset":
            seen.append(called(fmi.reset))
            running = False
        else:
            t, kept = saved_or_restored(fmi, choice, t, kept)
    return seen, client.messages


def test_the_module_search_path_does_not_grow_with_every_instance():
    """Pythonfmu's loader adds the folder each time, and a host that steps 200 draws makes 200 instances."""
    client = Client(fmu("joint4", "python"))
    before = sorted(sys.path)
    client.fmi.instantiate()
    assert sorted(sys.path) == before


def test_plain_calls_do_without_python(through_python):
    client = Client(fmu("joint4", "python")).start().go()
    through_python.clear()
    for k in range(100):
        client.assign(["joint4.torque"], [5e-3 * np.cos(0.02 * k)])
        client.fmi.doStep(0.005 * k, 0.005)
    with pytest.raises(FMICallException):
        client.assign(["joint4.torque"], [np.inf])
    assert client.get("joint4.reading")[0] != 0.0
    assert through_python == []


@pytest.mark.parametrize("seed", range(6))
def test_it_cannot_be_told_apart_from_python(seed, implementation, through_python, monkeypatch):
    fast = played(seed)
    assert "do_step" not in through_python
    library = implementation.KERNEL

    class Wrapped:
        """The kernel's functions, called by Python."""

        def hf_step(self, values: Any, t: float, dt: float) -> int:
            return library.hf_step(implementation.ctypes.c_void_p(values.buffer_info()[0]), *doubles(t, dt))

        def hf_output(self, values: Any, t: float) -> int:
            return library.hf_output(implementation.ctypes.c_void_p(values.buffer_info()[0]), *doubles(t))

    def doubles(*values: float) -> list[Any]:
        return [implementation.ctypes.c_double(value) for value in values]

    monkeypatch.setattr(implementation, "KERNEL", Wrapped())
    monkeypatch.setattr(implementation, "COMPILED", False)
    slow = played(seed)
    assert through_python.count("do_step") > 20
    np.testing.assert_equal(fast, slow)
    assert any("error" in one for one in fast[0] if isinstance(one, str))
