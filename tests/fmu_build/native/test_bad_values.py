"""Values and calls that make no sense end in a message and a status, never in a crash, and can be put right."""

from __future__ import annotations

import math

import pytest
from fmpy.fmi1 import FMICallException

from haptid.fmu_build.building.packaging import Kind
from tests.fmu_build.fmu_cases import KINDS, Client, fmu

BAD = {
    "joint4.inertia": (-1.0, "joint4.inertia"),
    "joint4.friction.sigma0": (math.nan, "NaN"),
    "joint4.torque": (math.inf, "joint4.torque"),
    "joint4.reading": (0.0, ""),
    "joint4.friction.Fs": (2.1e-4, "joint4.friction.Fc"),
}


def attempt(client: Client, name: str, value: float) -> str:
    """Set, initialise and step; return what the client saw go wrong."""
    try:
        client.assign([name], [value])
        client.go()
        client.fmi.doStep(0.0, 0.01)
    except FMICallException as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("kind", KINDS)
def test_bad_values_are_refused_with_a_message(kind: Kind, name: str):
    value, expected = BAD[name]
    client = Client(fmu("joint4", kind)).start()
    seen = attempt(client, name, value)
    assert "error" in seen
    assert client.messages
    assert expected.lower() in client.messages[-1].lower()


@pytest.mark.parametrize("kind", KINDS)
def test_a_refused_value_can_be_put_right(kind: Kind):
    client = Client(fmu("joint4", kind)).start()
    attempt(client, "joint4.inertia", -1.0)
    client.assign(["joint4.inertia", "joint4.torque"], [2e-4, 1e-3])
    client.go()
    client.fmi.doStep(0.0, 0.01)
    assert client.get("joint4.reading")[0] > 0


@pytest.mark.parametrize("step", [0.0, -0.01, math.nan, math.inf])
@pytest.mark.parametrize("kind", KINDS)
def test_bad_steps_are_refused(kind: Kind, step: float):
    client = Client(fmu("joint4", kind)).start().go()
    with pytest.raises(FMICallException):
        client.fmi.doStep(0.0, step)
    assert "step" in client.messages[-1]


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_that_runs_away_is_reported(kind: Kind):
    client = Client(fmu("joint4", kind)).start()
    client.assign(["joint4.velocity"], [1e300])
    client.go()
    with pytest.raises(FMICallException):
        client.fmi.doStep(0.0, 0.1)
    assert "finite" in client.messages[-1]


@pytest.mark.parametrize("kind", KINDS)
def test_the_wrong_guid_is_refused(kind: Kind):
    with pytest.raises(Exception, match="instantiate"):
        Client(fmu("joint4", kind), guid="{00000000-0000-0000-0000-000000000000}")


@pytest.mark.parametrize("kind", KINDS)
def test_stepping_before_initialisation_is_refused(kind: Kind):
    client = Client(fmu("joint4", kind))
    with pytest.raises(FMICallException):
        client.fmi.doStep(0.0, 0.01)
    assert "mode" in client.messages[-1].lower()


@pytest.mark.parametrize("kind", KINDS)
def test_unknown_references_are_refused(kind: Kind):
    client = Client(fmu("joint4", kind)).start().go()
    for call in (lambda: client.fmi.getReal([999]), lambda: client.fmi.setReal([999], [0.0])):
        with pytest.raises(FMICallException):
            call()
    with pytest.raises(FMICallException):
        client.fmi.getInteger([0])
