"""A driven joint, a servo by PWM duty with its loop: friction by the passed load is read from its torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from haptid.discrepancy.torque.closed_loop import ClosedLoop, refit_through_controller
from haptid.discrepancy.torque.fit import fit_model
from haptid.discrepancy.torque.study import TorqueStudy, torque_study_of
from haptid.discrepancy.torque_search.candidate import compare_candidates
from haptid.discrepancy.torque_search.scan import promises
from haptid.discrepancy.torque_search.search import refit_candidate
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.values.run import Run
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.equations.drive import Controller, Drive
from haptid.model.joint.drive_terms import drive_inputs
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.linear_algebra import rms

KEY = "load_dependent_friction:transmitted"
DRIVE = Drive(kind="duty", controller=Controller(kind="p", gain=0.6, limit=0.9))
TRUTH = {
    "inertia": 0.012, "gravity_cos": 0.0, "gravity_sin": 0.6, "Kp": 1.0, "Ks": 0.0, "epos": 0.0, "sigma0": 20.0,
    "sigma1": 0.05, "sigma2": 0.01, "vs": 0.1, "Fs": 0.02, "Fc": 0.02, "torque_constant": 0.4, "resistance_ohm": 3.0,
    "controller_limit": 0.9, "friction_of_load": 0.3, "passed_load_lag": 0.004,
}  # fmt: skip
T = np.arange(0.0, 6.0, 0.005)
SPEEDS = {"a": (3.0, 0.9, "fit"), "b": (1.7, 1.3, "fit"), "c": (2.3, 1.1, "validate")}


def effect() -> Effect:
    return catalogue()[KEY].at(Scales())


def recorded(name: str, y: np.ndarray) -> Run:
    rate, size, use = SPEEDS[name]
    # the arm is moved and then held for a second
    reference = size * np.where(T < 5.0, np.sin(rate * T), np.sin(rate * 5.0))
    columns = {
        "reference": reference, "supply": 7.4 + 0.0 * T, "enabled": 1.0 + 0.0 * T, "controller_gain": 0.6 + 0.0 * T,
    }  # fmt: skip
    return Run(
        file=f"{name}.csv", free_joints=(0,), t=T, u=np.zeros((T.size, 1)), y=y, noise=np.zeros(1),
        resolution=np.zeros(1), posture=np.zeros(0), use="fit" if use == "fit" else "validate",
        drive_inputs={x.id: columns[x.id] for x in drive_inputs(DRIVE)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> TorqueStudy:
    folder: Path = tmp_path_factory.mktemp("driven")
    equations, noise = joint_equations(0, drive=DRIVE, effects=[effect()]), np.random.default_rng(4)
    theta, entries = np.array([TRUTH[q.id] for q in equations.parameters]), ""
    for name, (_, _, use) in SPEEDS.items():
        run = recorded(name, np.zeros((T.size, 1)))
        y = KernelSimulator.of(equations).simulate(theta, run).y[:, 0] + noise.normal(0.0, 1e-4, T.size)
        table = np.column_stack((T, run.drive_inputs["reference"], y, run.drive_inputs["supply"]))
        header = "time_s,reference_0_rad,position_0_rad,supply_V"
        np.savetxt(folder / run.file, table, delimiter=",", header=header, comments="")
        entries += f'[[runs]]\nfile = "{run.file}"\nfree_joints = [0]\nuse = "{use}"\n'
    (folder / "campaign.toml").write_text(
        '[campaign]\ndevice = "single_joint"\nmeasured = false\n[sensor]\nnoise_rad = 1e-4\nresolution_rad = 0.0\n'
        "[joint.0.parameters]\nKs = { fixed = 0.0 }\nepos = { fixed = 0.0 }\ngravity_cos = { fixed = 0.0 }\n"
        '[joint.0.drive]\nkind = "duty"\nresistance_ohm = { initial = 3.3, lower = 1.0, upper = 10.0 }\n'
        "torque_constant = { initial = 0.36, lower = 0.05, upper = 3.0 }\n"
        f'[joint.0.controller]\nkind = "p"\ngain = 0.6\nlimit = 0.9\n{entries}',
        encoding="utf-8",
    )
    return torque_study_of(campaign_for_command(folder), 0)


def test_the_load_is_what_inertia_gravity_and_spring_take():
    equations = joint_equations(0, effects=[effect()])
    rng = np.random.default_rng(1)
    drawn = {s.symbol: float(rng.uniform(0.1, 1.0)) for s in (*equations.states, *equations.parameters)}
    drawn[equations.inputs[0].symbol] = 0.4
    value = {name: drawn[sp.Symbol(name, real=True)] for name in (s.name for s in drawn)}
    acceleration, rate = (float(sp.sympify(equations.rhs[k]).subs(drawn)) for k in (1, -1))
    load = value["inertia"] * acceleration + value["Ks"] * (value["q"] - value["epos"])
    load += value["gravity_cos"] * np.cos(value["q"]) + value["gravity_sin"] * np.sin(value["q"])
    assert value["passed_load"] + value["passed_load_lag"] * rate == pytest.approx(load, rel=1e-9)


def test_rows_at_rest_do_not_count(study: TorqueStudy):
    for run, moving in zip(study.runs, study.moving, strict=True):
        assert not moving[run.t > run.t[-1] - 0.3].any()
        assert moving[(run.t > 0.3) & (run.t < 4.0)].mean() > 0.7


def test_friction_by_load_is_found_in_the_torque_of_the_drive(study: TorqueStudy):
    base = fit_model(study, starts=2)
    scales = study.scales(base.values)
    chosen = (KEY, "quadratic_drag", "asymmetric_viscous", "position_dependent_viscous")
    best, *_ = promises(study, base, {key: catalogue()[key].at(scales) for key in chosen})
    assert best.effect.key == KEY
    model = refit_candidate(study, base, best)
    assert compare_candidates(KEY, base, model).acceptable
    assert rms(model.unseen) < 0.5 * rms(base.unseen)
    # The scale of all torques, kt/R, is the stated one; a ratio of torques does not hang on it.
    assert model.values["friction_of_load"] == pytest.approx(TRUTH["friction_of_load"], rel=0.1)
    before, after = (refit_through_controller(one) for one in (base, model))
    assert before is not None
    assert after is not None
    assert after.mean_absolute["validate"] < 0.3 * before.mean_absolute["validate"]
    assert after.as_json()["validate"]["rms"] < 1e-3


@pytest.mark.parametrize(
    ("squares", "better"),
    [((4.0, 5.0, 6.0), True), ((1.1, 5.0, 0.2), False), ((1.0, 2.0, 3.0), False), ((0.5, 1.0, 1.5), False)],
)
@pytest.mark.parametrize("use", ["fit", "validate"])
def test_a_model_is_better_where_the_runs_agree_on_it(squares: tuple[float, ...], better: bool, use: str):
    own, other = (_loop_of({use: some}) for some in ((1.0, 2.0, 3.0), squares))
    assert own.is_better_than(other) is better


@pytest.mark.parametrize(("held_out", "better"), [((4.0, 5.0), True), ((0.5, 0.6), False), ((4.0,), False)])
def test_runs_that_no_model_was_fitted_to_decide_before_the_fitted_ones(held_out: tuple[float, ...], better: bool):
    fitted = (1.0, 2.0, 3.0)
    own = _loop_of({"fit": fitted, "validate": tuple(1.0 for _ in held_out)})
    other = _loop_of({"fit": fitted, "validate": held_out})
    assert own.is_better_than(other) is better


def _loop_of(squares: dict[str, tuple[float, ...]]) -> ClosedLoop:
    arrays = {use: np.array(some) for use, some in squares.items()}
    return ClosedLoop(values={}, mean_absolute={}, rms={}, runs={}, squares=arrays)
