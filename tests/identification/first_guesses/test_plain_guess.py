"""First guesses of coupled joints whose URDF states no friction: the runs tell it before any simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid import Campaign
from haptid.identification.first_guesses.plain_guess import friction_left_open
from haptid.identification.fit.own_bounds import wider_ranges
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.error_growth import growth
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign as Values
from haptid.model.equations.equations import Equations

LENGTH, DISTAL, COUPLED, PROXIMAL = 0.3, 0.025, 0.04, 0.24
"""Length of the upper link [m]; inertias of the forearm, of its mass at the upper link's end, and of both [kg m²]."""
COULOMB, VISCOUS = (1.1, 0.42), (0.5, 0.2)
URDF = f"""<?xml version="1.0"?><robot name="scara">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0.15 0 0"/><mass value="2"/>
<inertia ixx="0.002" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="fore"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.001" iyy="0.007" izz="0.007" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2.8" upper="2.8" effort="28" velocity="6"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="{LENGTH} 0 0"/>
<axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" effort="14" velocity="9"/></joint>
</robot>"""
T = np.arange(0.0, 12.0, 0.004)


def run(seed: int) -> pd.DataFrame:
    """Return a multisine of both joints with the torque that it needs, dry and viscous friction included."""
    rng = np.random.default_rng(seed)
    w = 2.0 * np.pi * np.array([0.1, 0.3, 0.7])
    size, phase = rng.uniform(0.2, 0.6, (2, 3)), rng.uniform(0.0, 6.0, (2, 3))
    q, v, a = (
        np.stack([np.sum(size[j] * w**n * np.sin(np.outer(T, w) + phase[j] + n * np.pi / 2), axis=1) for j in (0, 1)])
        for n in (0, 1, 2)
    )
    c, s = COUPLED * np.cos(q[1]), COUPLED * np.sin(q[1])
    tau = np.stack([
        (PROXIMAL + DISTAL + 2 * c) * a[0] + (DISTAL + c) * a[1] - s * (2 * v[0] * v[1] + v[1] ** 2),
        (DISTAL + c) * a[0] + DISTAL * a[1] + s * v[0] ** 2,
    ])  # fmt: skip
    columns: dict[str, np.ndarray] = {"time_s": T}
    for j in (0, 1):
        friction = COULOMB[j] * np.sign(v[j]) + VISCOUS[j] * v[j]
        columns[f"torque_{j}_Nm"] = tau[j] + friction + 0.02 * rng.standard_normal(T.size)
        columns[f"position_{j}_rad"] = q[j] + 1e-5 * rng.standard_normal(T.size)
    return pd.DataFrame(columns)


def campaign(folder: Path, **joints: object) -> Values:
    (folder / "scara.urdf").write_text(URDF, encoding="utf-8")
    frames = {"a": run(1), "b": run(2)}
    made = Campaign.from_frames(frames, device=str(folder / "scara.urdf"), measured=False, **joints)
    return prepare_campaign(made.values)


def test_coupled_friction_is_guessed_from_the_runs(tmp_path: Path):
    values = campaign(tmp_path)
    device = device_of(values)
    equations = equations_for(values, device, (0, 1))
    for j in (0, 1):
        assert equations.parameter(f"Fc_{j}").initial == pytest.approx(COULOMB[j], rel=0.05)
        assert equations.parameter(f"sigma2_{j}").initial == pytest.approx(VISCOUS[j], rel=0.05)
    # Without friction of the machine's size an error of the start grows a thousandfold, and an observer is needed.
    simulator = KernelSimulator.of(equations)
    theta = np.array([q.initial for q in equations.parameters])
    assert growth(simulator, theta, values.runs[0]) < 10.0


def test_what_the_user_states_stays(tmp_path: Path):
    values = campaign(tmp_path, joints={1: {"parameters": {"Fc": {"initial": 0.2, "lower": 0.1, "upper": 0.9}}}})
    equations = equations_for(values, device_of(values), (0, 1))
    stated = equations.parameter("Fc_1")
    assert (stated.initial, stated.lower, stated.upper) == (0.2, 0.1, 0.9)
    assert equations.parameter("Fc_0").initial == pytest.approx(COULOMB[0], rel=0.05)


def test_ranges_of_friction_that_nobody_states_are_haptids_own(tmp_path: Path):
    values = campaign(tmp_path, joints={1: {"parameters": {"sigma0": {"initial": 300.0}}}})
    device = device_of(values)
    own = friction_left_open(device, (0, 1), (), ("sigma0_1",))
    assert {"sigma0_0", "Fs_0", "Fc_1", "vs_1"} <= set(own)
    assert "sigma0_1" not in own
    assert not any(id.startswith(("M", "V", "Kp")) for id in own)
    assert friction_left_open(device, (1,), (0.0, 0.0), ()) == tuple(
        id.removesuffix("_1") for id in friction_left_open(device, (0, 1), (), ()) if id.endswith("_1")
    )


class AtUpperEnd:
    """What the widening of ranges reads of a fit whose estimates are the first guesses, with one at its upper end."""

    def __init__(self, equations: Equations, id: str):
        self.equations = equations
        self.theta = np.array([q.upper if q.id == id else q.initial for q in equations.parameters])
        self.values = {q.id: float(value) for q, value in zip(equations.parameters, self.theta, strict=True)}
        self.statuses = dict.fromkeys(self.values, "identified")


def test_range_of_a_coupled_joint_grows_and_stiction_ends_at_a_multiple_of_its_own_torque(tmp_path: Path):
    values = campaign(tmp_path)
    device = device_of(values)
    equations, runs = equations_for(values, device, (0, 1)), values.runs
    own = friction_left_open(device, (0, 1), (), ())
    wider = wider_ranges(AtUpperEnd(equations, "sigma0_0"), own, runs)  # type: ignore[arg-type] # all it reads
    assert wider["sigma0_0"]["upper"] == pytest.approx(100.0 * equations.parameter("sigma0_0").upper)
    # The torque at the elbow is the smaller one.
    equations = equations.with_parameters({"Fs_1": {"upper": 0.6}, "Fc_1": {"upper": 0.6}})
    wider = wider_ranges(AtUpperEnd(equations, "Fs_1"), own, runs)  # type: ignore[arg-type] # all it reads
    largest = [max(float(np.abs(run.u[:, k]).max()) for run in runs) for k in (0, 1)]
    assert wider["Fs_1"]["upper"] == pytest.approx(3.0 * largest[1])
    assert largest[1] < 0.6 * largest[0]
