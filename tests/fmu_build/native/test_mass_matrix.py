"""Inertias that no machine has: the mass matrix is not positive definite, and the FMU says so and names parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from fmpy.fmi1 import FMICallException

from haptid.fmu_build.building.packaging import Kind, interface_for
from haptid.fmu_build.native.mass_matrix import checked_matrix, inertial_parameters
from haptid.model.equations.equations import Equations
from tests.fmu_build.fmu_cases import KINDS, Client, equations, fmu, initial, names

NAME = "freedom6s"


@cache
def compiled() -> Callable[..., list[list[float]]]:
    """The mass matrix as a function of parameters and states, by SymPy's Python printer alone."""
    e = equations(NAME)
    lines = [f"    {symbol.name} = {sp.pycode(formula)}" for symbol, formula in e.definitions]
    rows = ", ".join(f"[{', '.join(sp.pycode(entry) for entry in row)}]" for row in checked_matrix(e))
    arguments = ", ".join(x.id for x in (*e.parameters, *e.states, *e.inputs))
    scope: dict[str, Any] = {"math": math}
    exec("\n".join((f"def mass({arguments}):", *lines, f"    return [{rows}]")), scope)  # SymPy's own text
    return scope["mass"]


def smallest(p: np.ndarray, q: float = 0.0) -> float:
    """The smallest eigenvalue of the mass matrix with all joints at q [rad]."""
    e = equations(NAME)
    n = len(e.joints)
    x = np.zeros(len(e.states) + len(e.inputs))
    x[:n] = q
    return float(np.linalg.eigvalsh(np.array(compiled()(*p, *x)))[0])


def drawn(e: Equations, rng: np.random.Generator) -> np.ndarray:
    """Parameters within their bounds: those of the mass matrix random, the others at their first guess."""
    interface = interface_for(e, kind="native")
    inertial, at = {v for row in inertial_parameters(interface) for v in row}, interface.offsets["p"]
    p = initial(e)
    for i, q in enumerate(e.parameters):
        if at + i in inertial and math.isfinite(q.lower) and math.isfinite(q.upper):
            p[i] = rng.uniform(q.lower, q.upper)
    return p


def on_the_verge(rng: np.random.Generator) -> np.ndarray:
    """Parameters whose mass matrix is barely positive definite at 0 rad, and is not at another position."""
    good = initial(equations(NAME))
    while True:
        bad, share = drawn(equations(NAME), rng), 1.0
        while smallest(good + share * (bad - good)) <= 0:
            share *= 0.97
        p = good + share * (bad - good)
        if share < 1.0 and smallest(p, 0.3) < 0:
            return p


@pytest.mark.parametrize("kind", KINDS)
def test_initialisation_ends_where_the_mass_matrix_is_positive_definite_alone(kind: Kind):
    e, rng, counts = equations(NAME), np.random.default_rng(3), {True: 0, False: 0}
    client = Client(fmu(NAME, kind))
    for share in np.linspace(0.9, 1.0, 60):
        p = initial(e) + share * (drawn(e, rng) - initial(e))
        counts[smallest(p) > 0] += 1
        client.fmi.reset()
        client.start().assign(names(e, e.parameters), p)
        client.messages.clear()
        if smallest(p) > 0:
            client.go()
            continue
        with pytest.raises(FMICallException, match="fmi2ExitInitializationMode"):
            client.go()
        (message,) = client.messages
        assert message.startswith("mass matrix: expected to be positive definite, got the pivot -")
        said = message.partition(" s, from ")[2].removesuffix(" and others").split(", ")
        assert {one.partition(" = ")[0] for one in said} <= set(names(e, e.parameters))
        client.assign(names(e, e.parameters), initial(e))
        client.go()
    assert min(counts.values()) >= 3, counts


@pytest.mark.parametrize("kind", KINDS)
def test_a_parameter_that_is_tuned_during_the_run_is_checked(kind: Kind):
    e, client, rng = equations(NAME), Client(fmu(NAME, kind)).start().go(), np.random.default_rng(3)
    client.fmi.doStep(0.0, 0.01)
    p = next(p for p in (drawn(e, rng) for _ in range(100)) if smallest(p) < 0)
    client.assign(names(e, e.parameters), p)
    with pytest.raises(FMICallException, match="error"):
        client.fmi.doStep(0.01, 0.01)
    assert "positive definite" in client.messages[-1]
    client.assign(names(e, e.parameters), initial(e))
    client.fmi.doStep(0.01, 0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_into_such_a_position_is_discarded_and_names_parameters(kind: Kind):
    e, p = equations(NAME), on_the_verge(np.random.default_rng(5))
    n = len(e.joints)
    client = Client(fmu(NAME, kind)).start()
    client.assign(names(e, e.parameters), p)
    client.assign(names(e, e.states[n : 2 * n]), [20.0] * n)
    client.go()
    with pytest.raises(FMICallException, match="discard"):
        client.fmi.doStep(0.0, 0.1)
    assert client.messages[-1].startswith("mass matrix: expected to be positive definite")
    assert " s, from link" in client.messages[-1]
    assert client.get(*names(e, e.states[: 2 * n])) == [0.0] * n + [20.0] * n
