"""Sensitivities against central differences of the plain run, and of single evaluations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from haptid.model.kernel.compiled import CompiledKernel
from tests.model.kernel_cases import CASES, JOINT, KERNEL, OBSERVED, draw, torque, vector

T = np.arange(0.0, 3.0, 0.01)
START = np.array([0.1, 0.02, 1e-4])


def differences(kernel, u: np.ndarray, p: np.ndarray, x0: np.ndarray) -> np.ndarray:
    """Fourth-order central differences of y along the columns, shape (n_t, n_c)."""
    point = np.concatenate((p, x0))
    floor = np.concatenate((np.full(p.size, 1e-4), [1e-2, 1e-2, 1e-4]))
    columns = []
    for i, value in enumerate(point):
        h = 2e-5 * max(abs(value), floor[i])

        def y(steps: int, i=i, h=h) -> np.ndarray:
            moved = point.copy()
            moved[i] += steps * h
            return kernel.simulate(T, u, moved[: p.size], moved[p.size :])[:, 0]

        columns.append((8 * (y(1) - y(-1)) - (y(2) - y(-2))) / (12 * h))
    return np.array(columns).T


def relative_error(dy: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """RMS error of each column over the RMS of the column."""
    return np.sqrt(np.mean((dy - reference) ** 2, axis=0) / (np.mean(reference**2, axis=0) + 1e-30))


@pytest.mark.parametrize("case", CASES)
def test_all_columns_at_the_nominal_point(case: str):
    parameters, amplitude = CASES[case]
    u = torque(T, amplitude)
    p = vector(parameters)
    dy = KERNEL.simulate_tangent(T, u, p, START)[1][:, 0, :]
    reference = differences(KERNEL, u, p, START)
    error = relative_error(dy, reference)
    assert np.all(np.sqrt(np.mean(reference**2, axis=0)) > 0)
    assert error.max() < 2e-3, dict(zip(KERNEL.kernel.columns, error, strict=True))


def test_over_the_box():
    parameters, amplitude = CASES["tendon"]
    u = torque(T, amplitude)
    worst = []
    for p in draw(parameters, 25, seed=4, decades=0.5):
        dy = KERNEL.simulate_tangent(T, u, p, START)[1][:, 0, :]
        worst.append(relative_error(dy, differences(KERNEL, u, p, START)).max())
    assert np.median(worst) < 1e-3, worst


def test_with_observer():
    parameters, amplitude = CASES["tendon"]
    p = vector(parameters)
    y = KERNEL.simulate(T, torque(T, amplitude), p * 1.05, START)[:, 0]
    u = np.column_stack((torque(T, amplitude), y, np.full(T.size, 20.0)))
    dy = OBSERVED.simulate_tangent(T, u, p, START)[1][:, 0, :]
    assert relative_error(dy, differences(OBSERVED, u, p, START)).max() < 2e-3


def test_without_sensitivities_the_call_is_refused():
    plain = CompiledKernel.of(KERNEL.equations, tangent=False)
    with pytest.raises(ValueError, match="generated without sensitivities"):
        plain.simulate_tangent(T, torque(T, 1e-3), vector(CASES["tendon"][0]), START)


def test_derivatives_see_through_definitions():
    load = sp.Symbol("load", real=True)
    s = {x.id: x.symbol for x in (*JOINT.states, *JOINT.parameters)}
    spring = s["Ks"] * (s["q"] - s["epos"])
    hidden = replace(
        JOINT,
        name="joint4_defined",
        definitions=((load, spring),),
        rhs=(JOINT.rhs[0], JOINT.rhs[1] + (spring - load) / s["inertia"], JOINT.rhs[2]),
        outputs=(replace(JOINT.outputs[0], expression=s["q"] + 0.1 * (load - spring)),),
    )
    parameters, amplitude = CASES["tendon"]
    arguments = T, torque(T, amplitude), vector(parameters), START
    y, dy = CompiledKernel.of(hidden).simulate_tangent(*arguments)
    plain = KERNEL.simulate_tangent(*arguments)
    np.testing.assert_allclose(y, plain[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(dy, plain[1], rtol=1e-6, atol=1e-6 * np.abs(plain[1]).max())
