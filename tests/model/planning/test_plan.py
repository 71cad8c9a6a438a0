"""The locking plan: the paper's order and table for the Freedom 6S, ranks exact and numeric, files and exit codes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.model.algebra.echelon import Echelon
from haptid.model.device.device import Guess
from haptid.model.device.reader import load_device
from haptid.model.plan import main
from haptid.model.planning.inertial_belief import LinkBelief
from haptid.model.planning.lock_postures import plan_postures, random_motion
from haptid.model.planning.locking_order import locking_order
from haptid.model.planning.torque_design import plan_excitation
from haptid.model.rigid_body.base_parameters import (
    base_parameters,
    equation_forms,
    full_lagrangian,
    numeric_rank,
    rows,
)
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.regressor import regressor


def test_table_one_of_the_paper_is_derived():
    order = locking_order(load_device("freedom6s"))
    assert [stage.free for stage in order.stages] == [(4,), (5,), (3,), (2,), (1,), (0,), (0, 1)]


def test_serial_part_has_the_known_counts():
    device = load_device("freedom6s")
    links = tuple(replace(link, inertial=None) if link.name == "3" else link for link in device.links)
    order = locking_order(replace(device, links=links))
    assert [len(stage.new) for stage in order.stages] == [4, 8, 10, 10, 4, 14, 4]
    assert order.stages[-1].new == {"link2_I12", "link2_I13", "link4_I12", "link4_I13"}


def test_the_tests_reach_everything_the_full_model_needs():
    order = locking_order(load_device("freedom6s"))
    assert frozenset().union(*(stage.contains for stage in order.stages)) == order.needed
    assert order.reached_any == order.full.rank
    assert order.reached_home < order.full.rank
    assert sum(stage.new_combinations for stage in order.stages) == order.full.rank


@pytest.mark.parametrize("name", ["freedom6s", "arm6", "double_pendulum", "single_joint"])
def test_exact_rank_is_the_numeric_rank(name):
    device = load_device(name)
    joints = tuple(range(len(device.joints)))
    lagrangian = full_lagrangian(device)
    for free in [joints, *((j,) for j in joints)]:
        assert Echelon.of(rows(equation_forms(lagrangian, free))).rank == numeric_rank(device, free)[0]


def test_base_parameters_span_the_equations():
    lagrangian = full_lagrangian(load_device("freedom6s"))
    everything = rows(equation_forms(lagrangian, tuple(range(6))))
    chosen = base_parameters(Echelon.of(everything))
    found = Echelon.of(p.factors for p in chosen)
    assert found.extend(everything).reduced == found.reduced
    assert all(p.factors[p.leading] == 1 for p in chosen)


def test_command_writes_plan_and_page(tmp_path):
    result = CliRunner().invoke(main, ["freedom6s", "--no-design", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    plan = json.loads((tmp_path / "locking_plan.json").read_text())
    assert plan["locking_order"] == [[4], [5], [3], [2], [1], [0], [0, 1]]
    assert plan["base_parameters"]["rank_exact"] == plan["base_parameters"]["rank_numeric"]
    assert plan["largest_stage"] < plan["unknowns_at_once"] / 3
    assert any("Kp" in entry["why"] for entry in plan["unidentifiable"])
    page = (tmp_path / "locking_plan.html").read_text()
    assert "4, 5, 3, 2, 1, 0, 0+1" in page
    assert "link2_I13" in page


def test_command_refuses_an_unknown_device(tmp_path):
    result = CliRunner().invoke(main, ["nope", "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert not list(tmp_path.iterdir())


def test_postures_close_what_home_leaves_open():
    device = load_device("freedom6s")
    plan = plan_postures(device, [stage.free for stage in locking_order(device).stages], extra=8, candidates=16)
    assert plan.error_planned < 0.1 * plan.error_home < 0.1 * plan.error_prior
    limits = [joint.position_limits for joint in device.joints]
    for test in plan.chosen:
        assert all(lower <= x <= upper for x, (lower, upper) in zip(test.dynamics.posture, limits, strict=True))


def test_links_from_planned_tests_give_the_torque_of_the_true_device():
    """Coefficients without noise: one posture leaves errors, the planned postures do not."""
    device = load_device("freedom6s")
    plan = plan_postures(device, [stage.free for stage in locking_order(device).stages], extra=10, candidates=32)
    mean, covariance = pi_prior(device)
    truth = mean + 0.2 * np.sqrt(np.diag(covariance)) * np.random.default_rng(7).normal(size=mean.size)
    belief, errors = LinkBelief.from_device(device), []
    Y = regressor(device, *random_motion(device, 500, 8))
    for tests in (plan.home, plan.chosen):
        for test in tests:
            belief = belief.update(
                test.dynamics.coefficients, test.dynamics.linear_map @ truth, np.diag((1e-6 * test.std) ** 2)
            )
        wrong = np.mean((Y @ (belief.mean - truth)) ** 2, axis=1) / np.mean((Y @ truth) ** 2, axis=1)
        errors.append(np.sqrt(wrong.max()))  # of the worst joint
    assert errors[1] < 0.01 < errors[0]


def test_proposed_runs_beat_the_plain_ones():
    plan = plan_excitation(load_device("freedom6s"), 3, runs=3)
    volume_plain, volume = (np.prod(std / plan.std_plain) for std in (plan.std_plain, plan.std_chosen))
    assert volume < volume_plain / 10
    assert max(run.travel for run in plan.chosen) <= 1.6
    assert not plan.warnings


def test_runs_that_never_leave_presliding_are_named():
    """Stiction far above the drive: every proposed run stays within a bristle's length."""
    device = load_device("freedom6s")
    stiff = dict(device.joints[3].parameters) | {
        "Fs": Guess(initial=0.5),
        "Fc": Guess(initial=0.4),
        "sigma0": Guess(initial=1.0),
    }
    joint = replace(device.joints[3], parameters=stiff)
    device = replace(device, joints=(*device.joints[:3], joint, *device.joints[4:]))
    assert "never leave presliding" in plan_excitation(device, 3, runs=2).warnings[0]
