"""The plain model in the parameters of the equations: what a result may state, whatever least squares give."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.identification.baseline.plain_parameters import plain_theta, with_constant_torque
from haptid.model.device.stated_parameters import possible_range
from haptid.model.joint.locked_joint import joint_equations
from tests.identification.bench_joint import runs


def test_neither_friction_of_zero_nor_a_far_end_of_the_spring_is_beyond_what_a_result_may_state() -> None:
    equations = joint_equations(0)
    long = [run.but(y=run.y * (40.0 / np.ptp(run.y)), u=run.u / np.abs(run.u).max()) for run in runs()[:2]]
    found = {"inertia": 1e-3, "Fv": 0.0, "Fc": 0.0, "offset": 0.9}
    plain: Any = SimpleNamespace(
        values={"inertia": 1e-3},
        regressor=SimpleNamespace(joints=(0,)),
        of_joint=lambda id, _: found[id],
    )
    theta = with_constant_torque(plain_theta(plain, equations, long), plain, equations, long)
    values = dict(zip((q.id for q in equations.parameters), theta.tolist(), strict=True))
    for id, value in values.items():
        least, most = possible_range(id)
        assert least <= value <= most, id
    assert -values["Ks"] * values["epos"] == pytest.approx(0.9)
