"""URDF and MJCF in MuJoCo and Pinocchio: the same bodies as haptid's, and the motion of the kernel."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from haptid.fmu_build.multibody.bodies import Multibody
from haptid.fmu_build.multibody.mjcf import FrictionOf, mjcf_bytes
from haptid.fmu_build.multibody.write import Form, write_multibody
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.support.installing.environment import ROOT
from tests.fmu_build.multibody.machines import NAMES, device, machine, values_of

mujoco = pytest.importorskip("mujoco", reason="mujoco is a development package for x86-64 alone")
from benchmarks.simulators.in_bodies import (  # noqa: E402 # it imports mujoco
    Motion,
    motion,
    mujoco_terms,
    own_terms,
    pinocchio_terms,
)

NOISE = 2e-4  # rad, of the embedded campaign's sensor
T = 0.005 * np.arange(201)
SOFT = 1e-9  # stiffness and damping of a bristle that pulls at nothing


def without_rotors(m: Multibody) -> Multibody:
    return replace(m, rotors=tuple(replace(rotor, inertia=0.0) for rotor in m.rotors))


def states(m: Multibody, n: int = 50) -> np.ndarray:
    """Positions within ±1 and speeds within ±3, shape (n, 2, n_q)."""
    return np.random.default_rng(3).uniform(-1, 1, (n, 2, len(m.axes))) * np.array([1.0, 3.0])[None, :, None]


def assert_same(theirs: tuple[np.ndarray, np.ndarray], ours: tuple[np.ndarray, np.ndarray]) -> None:
    for a, b in zip(theirs, ours, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max())


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_and_bias_of_the_mjcf_are_haptids(name: str, tmp_path: Path):
    m = machine(name)
    model = mujoco.MjModel.from_xml_path(str(write_multibody(m, tmp_path / "m.xml", "mjcf").path))
    for q, v in states(m):
        assert_same(mujoco_terms(model, m, q, v), own_terms(device(name), m, q, v))


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_and_bias_of_the_urdf_are_haptids_but_for_rotors(name: str, tmp_path: Path):
    m = machine(name)
    urdf = write_multibody(m, tmp_path / "m.urdf", "urdf").path
    model = mujoco.MjModel.from_xml_path(str(urdf))
    model.opt.gravity[:] = m.gravity
    for q, v in states(m):
        assert_same(mujoco_terms(model, m, q, v), own_terms(device(name), without_rotors(m), q, v))


@pytest.mark.parametrize("name", ["freedom6s", "double_pendulum", "arm6"])
def test_pinocchio_reads_the_urdf_alike(name: str, tmp_path: Path):
    pytest.importorskip("pinocchio")
    m = machine(name)
    urdf = write_multibody(m, tmp_path / "m.urdf", "urdf").path
    for q, v in states(m, 20):
        assert_same(pinocchio_terms(urdf, q, v), own_terms(device(name), without_rotors(m), q, v))


def torques(n: int) -> np.ndarray:
    """Cosines well above the stiction of each joint, shape (n_t, n)."""
    amplitudes = np.array([0.03, 0.04, 0.03, 6e-3, 5e-3, 6e-3])[:n]
    return amplitudes * np.cos(2 * np.pi * (0.4 + 0.17 * np.arange(n)) * T[:, None])


def of_kernel(values: dict[str, float]) -> np.ndarray:
    """Positions (n_t, 6) and control point (n_t, 3) side by side."""
    e = full_equations(device("freedom6s"))
    u = np.zeros((T.size, len(e.inputs)))
    u[:, :6] = torques(6)
    p = np.array([values[q.id] for q in e.parameters])
    y = CompiledKernel.of(e).simulate(T, u, p, np.zeros(len(e.states)))
    handle = [i for i, o in enumerate(e.outputs) if o.id in {"handle_x", "handle_y", "handle_z"}]
    return np.column_stack((y[:, :6], y[:, handle]))


def in_mujoco(m: Multibody, friction: FrictionOf, step: float = 5e-4) -> Motion:
    model = mujoco.MjModel.from_xml_string(mjcf_bytes(m, friction).decode())
    model.opt.timestep = step
    return motion(model, m, T, torques(6), np.zeros(6))


def rms(moved: Motion, expected: np.ndarray) -> float:
    """RMS of the worst joint."""
    return float(np.sqrt(np.mean((moved.positions - expected[:, :6]) ** 2, axis=0)).max())


def test_with_viscous_friction_alone_mujoco_moves_as_the_kernel():
    m = machine("freedom6s")
    viscous = replace(m, axes=tuple(replace(axis, coulomb=0.0) for axis in m.axes))
    soft = {id: SOFT for id in values_of("freedom6s") if id.startswith(("sigma0_", "sigma1_"))}
    expected = of_kernel(values_of("freedom6s") | soft)
    moved = in_mujoco(viscous, "frictionloss")
    assert np.ptp(expected[:, :6], axis=0).min() > 0.1
    assert rms(moved, expected) < 1e-6
    assert np.abs(moved.handle - expected[:, 6:]).max() < 1e-6
    assert moved.slip < 1e-6


def test_with_its_bristle_mujoco_converges_to_the_kernel():
    expected = of_kernel(values_of("freedom6s"))
    gaps = [rms(in_mujoco(machine("freedom6s"), "lugre", step), expected) for step in (1e-3, 5e-4, 2.5e-4)]
    assert gaps[1] < 0.5 * NOISE
    assert gaps[1] < 0.6 * gaps[0]
    assert gaps[2] < 0.6 * gaps[1]


def test_a_link_that_two_joints_turn_stays_at_their_sum():
    m = machine("odd")
    free = replace(m, gravity=(0.0, 0.0, 0.0))
    model = mujoco.MjModel.from_xml_string(mjcf_bytes(free).decode())
    moved = motion(model, m, T, 1e-2 * np.cos(5 * T)[:, None] * np.array([1.0, 0.5, 2.0]), np.zeros(3))
    assert np.ptp(moved.positions, axis=0).min() > 1e-3
    assert moved.slip < 1e-6


def test_coulomb_friction_alone_leaves_a_gap_that_no_step_closes():
    expected = of_kernel(values_of("freedom6s"))
    gaps = [rms(in_mujoco(machine("freedom6s"), "frictionloss", step), expected) for step in (5e-4, 2.5e-4)]
    assert min(gaps) > 5 * NOISE
    assert max(gaps) < 2e-2
    assert gaps[1] == pytest.approx(gaps[0], rel=0.05)


@pytest.mark.parametrize("form", ["urdf", "mjcf"])
def test_joints_and_controls_are_in_the_order_of_the_fmu(form: Form, tmp_path: Path):
    m = machine("freedom6s")
    model = mujoco.MjModel.from_xml_path(str(write_multibody(m, tmp_path / "m", form).path))
    assert {f"joint{j}" for j in range(6)} <= {model.joint(i).name for i in range(model.njnt)}
    if form == "mjcf":
        assert [model.actuator(j).name for j in range(6)] == [f"joint{j}" for j in range(6)]
        assert model.nu == 6


def test_the_programs_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture):
    pytest.importorskip("pinocchio")
    page = (ROOT / "docs" / "how-to" / "rigid_body_simulators.md").read_text(encoding="utf-8")
    programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    m = machine("freedom6s")
    write_multibody(m, tmp_path / "freedom6s.xml", "mjcf")
    write_multibody(m, tmp_path / "freedom6s.urdf", "urdf")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for program in programs:
        exec(program, names)
    assert len(programs) == 2
    assert names["model"].nv == 6
    assert "[" in capsys.readouterr().out
