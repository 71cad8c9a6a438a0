"""Saved states restore a run exactly, z included; instances and FMUs in one process do not mix."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Kind
from tests.fmu_build.fmu_cases import KINDS, STEP, Client, equations, fmu, initial, kernel, names, torques

T = STEP * np.arange(101)


@pytest.mark.parametrize("serialised", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_restored_run_goes_on_as_before(kind: Kind, serialised: bool):
    e, client = equations("joint4"), Client(fmu("joint4", kind)).start().go()
    u = torques(e, T)
    client.run(e, T[:51], u[:51])
    state = client.fmi.getFMUstate()
    if serialised:
        state = client.fmi.deSerializeFMUstate(client.fmi.serializeFMUstate(state))
    first = client.run(e, T[50:], u[50:])
    assert np.ptp(first) > 1e-4
    client.fmi.setFMUstate(state)
    np.testing.assert_array_equal(client.run(e, T[50:], u[50:]), first)
    client.fmi.freeFMUstate(state)


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_moves_to_another_instance(kind: Kind):
    e = equations("joint4")
    one, other = (Client(fmu("joint4", kind), name=name).start().go() for name in ("one", "other"))
    u = torques(e, T)
    one.assign(["joint4.spring.Ks"], [0.02])
    one.run(e, T[:51], u[:51])
    state = one.fmi.serializeFMUstate(one.fmi.getFMUstate())
    other.fmi.setFMUstate(other.fmi.deSerializeFMUstate(state))
    np.testing.assert_array_equal(other.run(e, T[50:], u[50:]), one.run(e, T[50:], u[50:]))
    assert other.get("joint4.spring.Ks") == [0.02]


def test_foreign_bytes_are_refused():
    client, other = (Client(fmu(name, "native")).start().go() for name in ("joint4", "joints01"))
    foreign = other.fmi.serializeFMUstate(other.fmi.getFMUstate())
    with pytest.raises(Exception, match="fmi2DeSerializeFMUstate"):
        client.fmi.deSerializeFMUstate(foreign)


@pytest.mark.parametrize("kind", KINDS)
def test_interleaved_instances_of_different_fmus_do_not_mix(kind: Kind):
    runs = []
    for name, amplitude in (("joint4", 5e-3), ("joints01", 2e-2), ("joint4", 2e-3)):
        e = equations(name)
        runs.append((name, e, torques(e, T, amplitude), Client(fmu(name, kind)).start().go(), []))
    for k in range(T.size):
        for _, e, u, client, rows in runs:
            client.assign(names(e, e.inputs), u[k])
            rows.append(client.get(*names(e, e.outputs)))
            if k + 1 < T.size:
                client.fmi.doStep(T[k], T[k + 1] - T[k])
    for name, e, u, _, rows in runs:
        np.testing.assert_array_equal(rows, kernel(name).simulate(T, u, initial(e), np.zeros(len(e.states))))


@pytest.mark.parametrize("kind", KINDS)
def test_reset_starts_over(kind: Kind):
    e, client = equations("joint4"), Client(fmu("joint4", kind)).start().go()
    u = torques(e, T)
    first = client.run(e, T, u)
    client.fmi.reset()
    np.testing.assert_array_equal(client.start().go().run(e, T, u), first)


def test_many_instantiations_of_a_python_fmu_leave_it_whole():
    """pythonfmu's loader drops a reference to the slave's module each time, and loses the module where nobody minds."""
    built, clients = fmu("joint4", "python"), []
    for k in range(60):
        clients.append(Client(built, name=f"instance{k}").start().go())
        if k % 2:
            clients.pop().fmi.freeInstance()
    for client in clients:
        client.fmi.doStep(0.0, 0.01)
    assert len({client.get("joint4.reading")[0] for client in clients}) == 1
