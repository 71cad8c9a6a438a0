"""The search for missing effects in joints after other friction laws than LuGre."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

from haptid.discrepancy.run import main
from haptid.discrepancy.study.study import study_of
from haptid.discrepancy.torque.readable import readable
from haptid.identification.simulators.inverse_dynamics import torque_equations
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.effect import Effect, parameter, v
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import rich
from haptid.virtual_device.recording.sensor import Sensor
from tests.identification.bench_joint import TRUE

LAGGING = ("friction_lag", "stribeck_shape:exponent", "stribeck_shape:tail", "coulomb_drift:kinetic")
"""Entries that Dahl friction has no slots for."""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("dahl")
    truth, sensor = {**TRUE, "Kp": 1.0}, Sensor(noise=2e-4, resolution=1.5e-4)
    make_joint_campaign(folder, 4, truth, rich(4), sensor=sensor, seed=4, friction="dahl")
    return folder


def test_a_study_leaves_out_what_the_law_has_no_slot_for(campaign: Path):
    study = study_of(read_campaign(campaign), 4, catalogue())
    families = {key for key, effect in catalogue().items() if effect.torque_only}
    assert set(catalogue()) - set(study.catalogue) - families == set(LAGGING)
    assert study.base.friction == ("dahl",)
    theta = {q.id: q.initial for q in study.base.parameters}
    for effect in study.in_si(theta).values():
        assert study.equations([effect]).friction == ("dahl",)


def test_an_effect_of_the_users_own_is_refused_in_one_sentence(campaign: Path):
    a = sp.Symbol("a1", real=True)
    own = Effect(
        id="own", title="own", formula="", lives_in="velocity", side="friction",
        parameters=(parameter("a1", "1", "amplitude", 0.1, -1.0, 1.0),), kinetic_level=1 + a * v,
    )  # fmt: skip
    with pytest.raises(InputError, match="effect own: expected a friction law with kinetic_level, got dahl"):
        study_of(read_campaign(campaign), 4, {**catalogue(), "own": own})


@pytest.mark.parametrize("law", ["coulomb", "dahl", "maxwell_slip"])
def test_swept_joints_are_read_from_motion_to_torque(law: str):
    base = joint_equations(4, friction=law)
    found = readable(catalogue(), base, prismatic=False)
    assert "cubic_spring" in found
    assert ("friction_lag" in found) == (law != "dahl")
    inverse = torque_equations(base)
    assert len(inverse.states) == len(base.states) - 2
    assert all(np.isfinite(s.nominal) and s.nominal > 0 for s in inverse.states)


@pytest.mark.long
def test_nothing_is_missing_in_a_joint_with_the_right_law(campaign: Path):
    out = campaign / "out"
    done = CliRunner().invoke(
        main, [str(campaign), "--joint", "4", "--out", str(out), "--seed", "3", "--workers", "1", "--quiet"]
    )
    assert done.exit_code == 0, done.output
    data = json.loads((out / "discrepancy" / "joint4.json").read_text())
    assert data["verdict"] == "nothing_missing"
    assert data["gap"]["validate"]["after"] < 1.1 * data["gap"]["validate"]["noise"]
