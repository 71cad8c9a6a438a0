"""FMI 3.0: saved states, several instances, exact derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.fmu_build.fmi3_client import Client3, exchange, fmu3
from tests.fmu_build.fmu_cases import STEP, Client, equations, fmu, names, torques

T = STEP * np.arange(101)


def test_reset_starts_over():
    e, u, client = equations("joint4"), torques(equations("joint4"), T), Client3(fmu3()).start().go()
    first = client.run(e, T, u)
    client.fmi.reset()
    np.testing.assert_array_equal(client.start().go().run(e, T, u), first)


@pytest.mark.parametrize("serialised", [False, True])
def test_a_restored_run_goes_on_as_before_in_another_instance(serialised: bool):
    e, u = equations("joint4"), torques(equations("joint4"), T)
    one, other = (Client3(fmu3(), name=name).start() for name in ("one", "other"))
    one.assign(["joint4.spring.Ks"], [0.02])
    one.go().run(e, T[:51], u[:51])
    state = one.fmi.getFMUState()
    if serialised:
        content = one.fmi.serializeFMUState(state)
        one.fmi.freeFMUState(state)
        state = other.fmi.deserializeFMUState(content)
    first = one.run(e, T[50:], u[50:])
    for client in (other, one):  # the other goes from initialisation into the middle of the run
        client.fmi.setFMUState(state)
        assert client.get("time", "joint4.spring.Ks") == [T[50], 0.02]
        np.testing.assert_array_equal(client.run(e, T[50:], u[50:]), first)
    other.fmi.freeFMUState(state)


def test_foreign_states_are_refused():
    client, other = Client3(fmu3()).start().go(), exchange()
    with pytest.raises(FMICallException):
        other.fmi.setFMUState(client.fmi.getFMUState())
    assert "same interface" in other.messages[-1]
    whole = Client3(fmu3("joints01")).start().go()
    with pytest.raises(FMICallException):
        client.fmi.setFMUState(whole.fmi.getFMUState())
    assert "expected a state of this FMU" in client.messages[-1]


def test_a_model_exchange_state_keeps_its_mode():
    client = exchange()
    state = client.fmi.getFMUState()
    client.fmi.enterEventMode()
    client.fmi.setFMUState(state)
    client.states([0.1, 0.2, 1e-4])  # it was in continuous-time mode, in which alone states may be set
    assert client.rates()[0] == 0.2
    client.fmi.setFMUState(state)
    assert client.states() == [0.0, 0.0, 0.0]


def test_directional_and_adjoint_derivatives_are_exact():
    e, client = equations("joints01"), exchange("joints01")
    client.assign(names(e, e.inputs), torques(e, T)[10])
    client.states(list(np.linspace(0.01, 0.05, len(e.states)) * [1, -2, 3, 1, 1e-3, -1e-3][: len(e.states)]))
    client.fmi.enterEventMode()  # in which parameters may be set
    known = names(e, (*e.inputs, *e.states, *e.parameters))
    unknown = [*(f"der({s})" for s in names(e, e.states)), *names(e, e.outputs)]
    a, b = ([client.vr[x] for x in rows] for rows in (unknown, known))
    J = np.array([client.fmi.getDirectionalDerivative(a, [k], [1.0]) for k in b]).T
    z = client.get(*known)
    for column, name in enumerate(known):
        h, ends = 1e-6 * max(abs(z[column]), 1e-3), []
        for sign in (1, -1):
            moved = _within(client, name, z[column] + sign * h, names(e, e.states))
            ends.append((moved, np.array(client.get(*unknown))))
        _within(client, name, z[column], names(e, e.states))
        difference = (ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0])
        np.testing.assert_allclose(J[:, column], difference, rtol=1e-5, atol=1e-8 * np.abs(J).max())
    rng = np.random.default_rng(0)
    forward, backward = rng.normal(size=len(b)), rng.normal(size=len(a))
    along = client.fmi.getDirectionalDerivative(a, b, list(forward))
    back = client.fmi.getAdjointDerivative(a, b, list(backward), nSensitivity=len(b))
    np.testing.assert_allclose(along, J @ forward, rtol=1e-12, atol=1e-12 * np.abs(J).max())
    np.testing.assert_allclose(back, J.T @ backward, rtol=1e-12, atol=1e-12 * np.abs(J).max())


def _within(client: Client3, name: str, value: float, states: list[str]) -> float:
    """Set the value, or the nearest that the variable may have."""
    if name in states:
        client.fmi.enterContinuousTimeMode()
        client.states(
            [value if state == name else before for state, before in zip(states, client.states(), strict=True)]
        )
        client.fmi.enterEventMode()
        return value
    v = next(v for v in client.description.modelVariables if v.name == name)
    value = max(value, -math.inf if v.min is None else float(v.min))
    value = min(value, math.inf if v.max is None else float(v.max))
    client.assign([name], [value])
    return value


def test_instances_of_both_versions_do_not_mix():
    e, u = equations("joint4"), torques(equations("joint4"), T)
    clients = [Client3(fmu3(), name="a"), Client3(fmu3(), name="b"), Client(fmu("joint4", "native"))]
    alone, together = [], [[], [], []]
    for client, stiffness in zip(clients, (0.01, 0.02, 0.03), strict=True):
        client.start().assign(["joint4.spring.Ks"], [stiffness])
        alone.append(client.go().run(e, T, u))
        client.fmi.reset()
        client.start().assign(["joint4.spring.Ks"], [stiffness])
        client.go()
    for k in range(T.size):
        for client, rows in zip(clients, together, strict=True):
            client.assign(["joint4.torque"], u[k])
            rows.append(client.get("joint4.reading"))
            if k + 1 < T.size:
                client.fmi.doStep(T[k], T[k + 1] - T[k])
    np.testing.assert_array_equal(together, alone)
    assert len(np.unique(np.array(together)[:, -1])) == 3
