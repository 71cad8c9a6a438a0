"""FMI 3.0: values and calls that make no sense end in a message and a status, and can be put right."""

from __future__ import annotations

import ctypes
import math

import pytest
from fmpy.fmi1 import FMICallException

from tests.fmu_build.fmi3_client import Client3, exchange, fmu3
from tests.fmu_build.native.test_bad_values import BAD


def refusal(client: Client3, name: str, value: float) -> str:
    try:
        client.assign([name], [value])
        client.go()
        client.fmi.doStep(0.0, 0.01)
    except FMICallException as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", BAD)
def test_bad_values_are_refused_with_a_message_and_can_be_put_right(name: str):
    value, expected = BAD[name]
    client = Client3(fmu3()).start()
    before = client.get("joint4.friction.Fs")
    assert "error" in refusal(client, name, value)
    assert expected.lower() in client.messages[-1].lower()
    client.assign(["joint4.friction.Fs", "joint4.torque"], [*before, 3e-3])
    client.go()
    client.fmi.doStep(0.0, 0.01)
    assert client.get("joint4.reading")[0] > 0
    assert client.get("time") == [0.01]


@pytest.mark.parametrize("step", [0.0, -0.01, math.nan, math.inf])
def test_bad_steps_are_refused(step: float):
    client = Client3(fmu3()).start().go()
    with pytest.raises(FMICallException):
        client.fmi.doStep(0.0, step)
    assert client.messages[-1].startswith("fmi3DoStep: expected a finite time and a positive step")


def test_a_state_that_runs_away_is_reported():
    client = Client3(fmu3()).start()
    client.assign(["joint4.velocity"], [1e300])
    client.go()
    with pytest.raises(FMICallException):
        client.fmi.doStep(0.0, 0.1)
    assert "finite" in client.messages[-1]


FLAGS, TIME = [ctypes.c_bool() for _ in range(3)], ctypes.c_double()
CALLS = {
    "fmi3DoStep": lambda c: c.call("fmi3DoStep", 0.0, 0.01, True, *map(ctypes.byref, FLAGS), ctypes.byref(TIME)),
    "fmi3SetTime": lambda c: c.call("fmi3SetTime", 0.1),
    "fmi3EnterEventMode": lambda c: c.fmi.enterEventMode(),
    "fmi3UpdateDiscreteStates": lambda c: c.call(
        "fmi3UpdateDiscreteStates", *map(ctypes.byref, (*FLAGS, *FLAGS[:2], TIME))
    ),
    "fmi3EnterContinuousTimeMode": lambda c: c.call("fmi3EnterContinuousTimeMode"),
    "fmi3EnterInitializationMode": lambda c: c.fmi.enterInitializationMode(),
    "fmi3ExitInitializationMode": lambda c: c.fmi.exitInitializationMode(),
    "fmi3Terminate": lambda c: c.fmi.terminate(),
    "fmi3EnterConfigurationMode": lambda c: c.fmi.enterConfigurationMode(),
    "fmi3GetFloat64": lambda c: c.fmi.getFloat64([999]),
    "fmi3SetFloat64": lambda c: c.fmi.setFloat64([c.vr["time"]], [1.0]),
    "fmi3GetInt32": lambda c: c.fmi.getInt32([0]),
    "fmi3SetBoolean": lambda c: c.fmi.setBoolean([0], [True]),
    "fmi3GetDirectionalDerivative": lambda c: c.fmi.getDirectionalDerivative([999], [0], [1.0]),
    "fmi3GetAdjointDerivative": lambda c: c.fmi.getAdjointDerivative([c.vr["joint4.reading"]], [999], [1.0], 1),
    "fmi3SetFMUState": lambda c: c.fmi.setFMUState(None),
    "fmi3SerializeFMUState": lambda c: c.fmi.serializeFMUState(None),
    "fmi3DeserializeFMUState": lambda c: c.fmi.deserializeFMUState(b"nothing"),
}
ALLOWED = {
    "instantiated": ["fmi3EnterInitializationMode"],
    "step": ["fmi3DoStep", "fmi3Terminate"],
    "continuous": ["fmi3SetTime", "fmi3EnterEventMode", "fmi3Terminate"],
    "terminated": [],
}


@pytest.mark.parametrize("when", ALLOWED)
def test_calls_out_of_place_are_refused_by_name(when: str):
    client = within(when)
    for name in CALLS.keys() - set(ALLOWED[when]):
        with pytest.raises(FMICallException, match=name):
            CALLS[name](client)
        assert client.messages[-1].startswith(f"{name}: ")
    client.messages.clear()
    for name in ALLOWED[when]:
        CALLS[name](client)
    assert not client.messages


def within(when: str) -> Client3:
    """An instance in that mode."""
    if when == "continuous":
        return exchange()
    client = Client3(fmu3())
    if when != "instantiated":
        client.start().go()
    if when == "terminated":
        client.fmi.terminate()
    return client


def test_the_wrong_token_and_event_mode_are_refused():
    for options in ({"token": "{00000000-0000-0000-0000-000000000000}"}, {"eventModeUsed": True}):
        with pytest.raises(Exception, match="instantiate"):
            Client3(fmu3(), **options)


def test_without_logging_nothing_is_logged():
    client = Client3(fmu3(), logging=False).start()
    assert refusal(client, "joint4.inertia", -1.0)
    assert client.messages == []
    client.fmi.fmi3SetDebugLogging(client.fmi.component, True, 1, (ctypes.c_char_p * 1)(b"logStatusError"))
    assert refusal(client, "joint4.inertia", -1.0)
    assert len(client.messages) == 1
    with pytest.raises(FMICallException):
        client.fmi.fmi3SetDebugLogging(client.fmi.component, True, 1, (ctypes.c_char_p * 1)(b"logAll"))
