"""The plain-Python kernel: within rounding of the compiled one, and what the FMU runs where it carries no binary."""

from __future__ import annotations

import zipfile
from array import array
from types import ModuleType

import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Kind, build_fmu, interface_for
from haptid.fmu_build.python.fallback import fallback_source
from haptid.fmu_build.python.fallback_stepper import phi, solve, weigh
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from tests.fmu_build.fmu_cases import STEP, Client, equations, fmu, initial, kernel, torques

KIND: Kind = "python"


def fallback(name: str, *, identification: bool = False) -> tuple[ModuleType, array, dict[str, int]]:
    interface = interface_for(equations(name), kind=KIND, identification=identification)
    module = ModuleType(f"fallback_{name}")
    exec(compile(fallback_source(interface), module.__name__, "exec"), module.__dict__)  # the text under test
    return module, array("d", interface.start), interface.offsets


def run(module: ModuleType, values: array, at: dict[str, int], t: np.ndarray, u: np.ndarray, n_y: int) -> np.ndarray:
    rows = []
    for k in range(t.size):
        for j, value in enumerate(u[k]):
            values[at["u"] + j] = value
        assert module.hf_output(values, t[k])
        rows.append(list(values[at["y"] : at["y"] + n_y]))
        if k + 1 < t.size:
            assert module.hf_step(values, t[k], t[k + 1] - t[k])
    return np.array(rows)


@pytest.mark.parametrize(("name", "rows"), [("joint4", 101), ("joints01", 41), ("freedom6s", 5)])
def test_equals_the_compiled_kernel_to_rounding(name: str, rows: int):
    e, t = equations(name), STEP * np.arange(rows)
    u = torques(e, t)
    got = run(*fallback(name), t, u, len(e.outputs))
    expected = kernel(name).simulate(t, u, initial(e), np.zeros(len(e.states)))
    np.testing.assert_allclose(got, expected, rtol=1e-10, atol=1e-13)


@pytest.mark.parametrize(
    "key", ["amplifier_saturation:hard", "backlash:encoder", "cogging", "coulomb_drift", "time_delay", "end_stop:both"]
)
def test_effects_equal_the_compiled_kernel(key: str):
    e, t = joint_equations(3, effects=[catalogue()[key]]), STEP * np.arange(61)
    interface = interface_for(e, kind=KIND)
    module = ModuleType("fallback_effect")
    exec(compile(fallback_source(interface), "fallback", "exec"), module.__dict__)  # the text under test
    u, x0 = 1e-2 * np.cos(3 * t)[:, None], [s.start for s in e.states]
    got = run(module, array("d", interface.start), interface.offsets, t, u, 1)
    expected = CompiledKernel.of(e).simulate(t, u, initial(e), x0)
    np.testing.assert_allclose(got, expected, rtol=1e-10, atol=1e-13)


def test_sensitivities_equal_those_of_the_compiled_kernel():
    e = equations("joint4")
    module, values, at = fallback("joint4", identification=True)
    t, columns = STEP * np.arange(21), len(e.parameters) + 3
    u = torques(e, t)[:, 0]
    _, expected = kernel("joint4").simulate_tangent(t, u[:, None], initial(e), np.zeros(3))
    for k in range(t.size - 1):
        values[at["u"]] = u[k]
        assert module.hf_step_tangent(values, t[k], STEP)
    got = np.array(values[at["dy"] : at["dy"] + columns])
    np.testing.assert_allclose(got, expected[-1, 0], rtol=1e-9, atol=1e-12)


def test_leaving_the_numbers_is_reported_not_raised():
    module, values, at = fallback("joint4")
    values[at["x"] + 1] = 1e300
    assert not module.hf_step(values, 0.0, 0.1)


def test_the_fmu_runs_it_where_it_has_no_binary(tmp_path):
    e, t = equations("joint4"), STEP * np.arange(41)
    bare = build_fmu(e, tmp_path / "bare.fmu", kind=KIND, platforms=(), values={"Ks": 0.011})
    with zipfile.ZipFile(bare.path) as archive:
        assert not [name for name in archive.namelist() if "_kernel/" in name]
    u, p = torques(e, t), initial(e)
    p[[q.id for q in e.parameters].index("Ks")] = 0.011
    got = Client(bare).start().go().run(e, t, u)
    np.testing.assert_allclose(got, kernel("joint4").simulate(t, u, p, np.zeros(3)), rtol=1e-10, atol=1e-13)
    np.testing.assert_array_equal(
        Client(fmu("joint4", KIND)).start().go().run(e, t, u), kernel("joint4").simulate(t, u, initial(e), np.zeros(3))
    )


def test_phi_functions_and_weights():
    for L in (-40.0, -1.0, -0.999, -1e-3, 0.0):
        e, p1, p2, p3 = phi(L)
        assert e == pytest.approx(np.exp(L), rel=1e-14)
        if L:
            assert [p1, p2, p3] == pytest.approx(
                [(np.exp(L) - 1) / L, (np.exp(L) - 1 - L) / L**2, (np.exp(L) - 1 - L - L * L / 2) / L**3], rel=1e-6
            )
    assert weigh(0.0, 0.1) == pytest.approx((1, 0.05, 1, 0.1 / 6, 0.1 / 3, 0.1 / 6))


def test_cholesky():
    rng = np.random.default_rng(2)
    A = rng.normal(size=(5, 5))
    M, h = A @ A.T + np.eye(5), rng.normal(size=5)
    np.testing.assert_allclose(solve(M.tolist(), h.tolist()), np.linalg.solve(M, h), rtol=1e-10)
