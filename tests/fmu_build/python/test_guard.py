"""The guard of a Python FMU answers plain calls from the slave's arrays, and it cannot be told apart from the slave."""

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
def slave() -> Any:
    """The class inside the FMU, which pythonfmu has imported into this process."""
    made = fmu("joint4", "python")
    Client(made).start()
    with ZipFile(made.path) as archive:
        module = archive.read("resources/slavemodule.txt").decode().strip()
    return sys.modules[f"{module}_slave"].Slave


@pytest.fixture
def through_python(slave, monkeypatch) -> list[str]:
    """Names of the calls that reached the slave."""
    seen: list[str] = []

    def counted(name: str) -> Any:
        real = getattr(slave, name)
        return lambda self, *arguments: (seen.append(name), real(self, *arguments))[1]

    for name in ("set_real", "do_step", "exit_initialization_mode"):
        monkeypatch.setattr(slave, name, counted(name))
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


def saved_or_restored(client: Client, choice: str, kept: Any) -> Any:
    if choice == "save":
        return client.fmi.getFMUState()
    if kept is not None:
        client.fmi.setFMUState(kept)
    return kept


def played(seed: int, calls: int = 150) -> tuple[list[Any], list[str]]:
    """Play a random script of calls, many of them wrong; return what they gave, and the messages."""
    rng = np.random.default_rng(seed)
    client = Client(fmu("joint4", "python"))
    fmi, kept, seen, running, t = client.fmi, None, [], False, 0.0
    for _ in range(calls):
        choice = rng.choice(["set", "get", "step", "reset", "save", "restore"], p=[0.3, 0.2, 0.4, 0.04, 0.03, 0.03])
        if not running:
            seen += begun(client, rng)
            running, t = True, 0.0
        if choice == "set":
            chosen = rng.choice(len(NAMES), size=2, replace=False, p=[0.6, 0.1, 0.1, 0.1, 0.1])
            seen.append(called(fmi.setReal, [client.vr[NAMES[k]] for k in chosen], list(rng.choice(VALUES, size=2))))
        elif choice == "get":
            seen.append(client.get("joint4.reading", *NAMES))
        elif choice == "step":
            dt = float(rng.choice((0.005, 0.01, -0.01), p=[0.6, 0.3, 0.1]))
            seen.append(called(fmi.doStep, t, dt))
            t += abs(dt)
        elif choice == "reset":
            seen.append(called(fmi.reset))
            running = False
        else:
            kept = saved_or_restored(client, choice, kept)
    return seen, client.messages


def test_plain_calls_do_without_python(through_python):
    client = Client(fmu("joint4", "python")).start().go()
    for k in range(100):
        client.assign(["joint4.torque"], [5e-3 * np.cos(0.02 * k)])
        client.fmi.doStep(0.005 * k, 0.005)
    assert client.get("joint4.reading")[0] != 0.0
    assert through_python == ["exit_initialization_mode"]
    with pytest.raises(FMICallException):
        client.assign(["joint4.torque"], [np.inf])
    assert through_python[1:] == ["set_real"]


@pytest.mark.parametrize("seed", range(6))
def test_it_cannot_be_told_apart_from_python(seed, slave, through_python, monkeypatch):
    fast = played(seed)
    few = through_python.count("do_step")
    monkeypatch.setattr(slave, "addresses", lambda _: [0.0] * 12)
    through_python.clear()
    slow = played(seed)
    assert through_python.count("do_step") > few
    np.testing.assert_equal(fast, slow)
    assert any("error" in one for one in fast[0] if isinstance(one, str))
