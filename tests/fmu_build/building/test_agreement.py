"""Python FMU, native FMU and the in-process kernel, sample by sample; the kernel's FMU against SciPy's Radau."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model
from scipy.integrate import solve_ivp

from haptid.fmu_build.building.packaging import Kind
from tests.fmu_build.fmu_cases import KINDS, NAMES, STEP, Client, equations, fmu, initial, kernel, names, torques

T = STEP * np.arange(201)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", NAMES)
def test_equals_the_kernel(name: str, kind: Kind):
    e = equations(name)
    u = torques(e, T)
    expected = kernel(name).simulate(T, u, initial(e), np.zeros(len(e.states)))
    got = Client(fmu(name, kind)).start().go().run(e, T, u)
    np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("kind", KINDS)
def test_equals_the_kernel_at_random_parameters(kind: Kind):
    e, rng = equations("joint4"), np.random.default_rng(1)
    client, u = Client(fmu("joint4", kind)), torques(e, T)
    for _ in range(10):
        p = np.array([q.initial if q.fixed else rng.uniform(q.lower, q.upper) for q in e.parameters])
        index = {q.id: i for i, q in enumerate(e.parameters)}
        p[index["Fs"]], p[index["Fc"]] = max(p[index["Fs"]], p[index["Fc"]]), min(p[index["Fs"]], p[index["Fc"]])
        x0 = rng.normal(0, 0.05, 3) * [1, 1, 1e-2]
        client.fmi.reset()
        client.start()
        client.assign(names(e, e.parameters), p)
        client.assign(names(e, e.states), x0)
        got = client.go().run(e, T, u)
        np.testing.assert_array_equal(got, kernel("joint4").simulate(T, u, p, x0))


def test_the_handle_force_moves_the_device():
    e = equations("freedom6s")
    u = torques(e, T)
    u[:, [x.id for x in e.inputs].index("handle_force_x")] = 0.2
    pushed = Client(fmu("freedom6s", "native")).start().go().run(e, T, u)
    expected = kernel("freedom6s").simulate(T, u, initial(e), np.zeros(len(e.states)))
    np.testing.assert_array_equal(pushed, expected)
    free = kernel("freedom6s").simulate(T, torques(e, T), initial(e), np.zeros(len(e.states)))
    column = [o.id for o in e.outputs].index("handle_x")
    assert pushed[-1, column] - free[-1, column] > 1e-3
    quaternion = pushed[:, [i for i, o in enumerate(e.outputs) if o.id.startswith("handle_q")]]
    np.testing.assert_allclose(np.sum(quaternion**2, axis=1), 1.0, atol=1e-12)


def test_linear_inputs_by_their_derivatives_equal_the_kernel():
    e, client = equations("joint4"), Client(fmu("joint4", "native")).start().go()
    u = torques(e, T)
    expected = kernel("joint4").simulate(T, u, initial(e), np.zeros(3), linear=True)[:, 0]
    got = []
    for k in range(T.size):
        client.assign(["joint4.torque"], u[k])
        got += client.get("joint4.reading")
        if k + 1 < T.size:
            client.fmi.setRealInputDerivatives([client.vr["joint4.torque"]], [1], [(u[k + 1, 0] - u[k, 0]) / STEP])
            client.fmi.doStep(T[k], STEP)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13)


def test_model_exchange_integrated_by_radau_equals_co_simulation():
    e, model = equations("joint4"), Client(fmu("joint4", "native"), FMU2Model).start().go()
    model.fmi.enterContinuousTimeMode()
    model.assign(["joint4.torque"], [5e-3])

    def rates(t: float, x: np.ndarray) -> list[float]:
        model.fmi.setTime(t)
        for i, value in enumerate(x):
            buffer[i] = value
        model.fmi.setContinuousStates(buffer, 3)
        model.fmi.getDerivatives(result, 3)
        return list(result)

    buffer, result = (np.ctypeslib.as_ctypes(np.zeros(3)) for _ in range(2))
    x = solve_ivp(rates, (0, 1.0), np.zeros(3), method="Radau", rtol=1e-10, atol=1e-12, t_eval=T, max_step=1e-2).y
    u = np.full((T.size, 1), 5e-3)
    slave = Client(fmu("joint4", "native")).start().go().run(e, T, u)
    np.testing.assert_allclose(slave[:, 0], x[0], rtol=0, atol=2e-7)


def test_directional_derivatives_are_exact():
    e, client = equations("joints01"), Client(fmu("joints01", "native")).start().go()
    client.run(e, T[:40], torques(e, T)[:40])
    known = names(e, (*e.inputs, *e.states, *e.parameters))
    unknown = [*(f"der({s})" for s in names(e, e.states)), *names(e, e.outputs)]
    z = np.array(client.get(*known))
    J = np.array(
        [
            [client.fmi.getDirectionalDerivative([client.vr[a]], [client.vr[b]], [1.0])[0] for b in known]
            for a in unknown
        ]
    )
    nu, nx, k = len(e.inputs), len(e.states), kernel("joints01")

    def f(z: np.ndarray) -> np.ndarray:
        u, x, p = z[:nu], z[nu : nu + nx], z[nu + nx :]
        return np.r_[k.derivatives(0.2, x, u, p), k.output(0.2, x, u, p)]

    for column in range(z.size):
        h = 1e-6 * max(abs(z[column]), 1e-3)
        step = h * np.eye(z.size)[column]
        difference = (f(z + step) - f(z - step)) / (2 * h)
        np.testing.assert_allclose(J[:, column], difference, rtol=1e-5, atol=1e-5 * np.abs(J).max() * 1e-3)
    seed = np.random.default_rng(0).normal(size=z.size)
    along = client.fmi.getDirectionalDerivative(
        [client.vr[a] for a in unknown], [client.vr[b] for b in known], list(seed)
    )
    np.testing.assert_allclose(along, J @ seed, rtol=1e-12, atol=1e-12 * np.abs(J).max())
