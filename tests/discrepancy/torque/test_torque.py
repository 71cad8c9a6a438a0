"""Joints whose torque is scored: the inverse equation, a synthetic sweep, and the real joint of a surgical arm."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner
from fmpy import simulate_fmu

from haptid.discrepancy.run import main
from haptid.discrepancy.torque.fit import fit_model
from haptid.discrepancy.torque.readable import delays_torque, readable, with_measured_load
from haptid.discrepancy.torque.rows import alternating
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.candidate import compare_candidates
from haptid.discrepancy.torque_search.scan import promises
from haptid.discrepancy.torque_search.search import refit_candidate
from haptid.identification.simulators.inverse_dynamics import torque_equations, torque_run
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.equations.equations import TIME
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.linear_algebra import rms
from tests.real_data import DATA

UNIT = Scales()
BASE = joint_equations(4)
READABLE = readable({k: e.at(UNIT) for k, e in catalogue().items()}, BASE, prismatic=False)


@pytest.mark.parametrize("key", READABLE)
def test_the_inverse_gives_back_the_torque_that_made_the_acceleration(key: str):
    equations = joint_equations(4, effects=[READABLE[key]])
    late = delays_torque(READABLE[key])
    inverse = torque_equations(equations, BASE) if late else torque_equations(with_measured_load(equations))
    rng = np.random.default_rng(1)
    for _ in range(3):
        drawn = {s.symbol: float(rng.uniform(0.1, 1.0)) for s in (*equations.states, *equations.parameters)}
        drawn |= {TIME: 0.7, equations.inputs[0].symbol: 0.3}
        motion = drawn | {sp.Symbol("a", real=True): float(sp.sympify(equations.rhs[1]).subs(drawn))}
        assert float(sp.sympify(inverse.outputs[0].expression).subs(motion)) == pytest.approx(0.3, rel=1e-9)


def test_what_acts_on_torque_or_reading_cannot_be_read_back():
    ids = {e.id for e in READABLE.values()}
    assert {"cogging", "position_dependent_friction", "cubic_spring", "cable_hysteresis"} <= ids
    # A late torque is followed forward from the recorded one; what changes its size or the reading is left out.
    assert {"time_delay", "amplifier_lag"} <= ids
    assert not ids & {"tendon_elasticity", "amplifier_saturation", "amplifier_nonlinear_gain", "gain_drift"}
    assert not ids & {"encoder_ripple", "backlash", "clock_error", "amplitude_scatter"}


def cogging(phase: np.ndarray, harmonics: tuple[float, ...]) -> np.ndarray:
    return sum(size * np.sin(h * phase + 0.6) for h, size in enumerate(harmonics, 1))


def sweep(
    left: float, waves: float = 9.0, harmonics: tuple[float, ...] = (1.0,), *, slides: bool = False
) -> TorqueStudy:
    """A triangle sweep there and back, twice, with cogging of so many waves a radian and white noise in the torque."""
    t = np.arange(0.0, 20.0, 0.01)
    q = 1.0 - np.abs((t / 5.0) % 2.0 - 1.0)
    q = np.convolve(np.pad(q, 20, mode="edge"), np.ones(41) / 41, mode="valid")
    rng = np.random.default_rng(5)
    v = np.gradient(q, t)
    tau = 0.04 * (q - 0.3) + 0.03 * np.tanh(v / 0.005) + 0.02 * v + left * cogging(waves * q, harmonics)
    y = tau + 1e-3 * rng.standard_normal(t.size)
    run = torque_run(
        Run(
            t=t, u=y[:, None], y=q[:, None], noise=np.array([1e-6]), resolution=np.array([0.0]), free_joints=(4,),
            use="fit", file="sweep.csv", posture=np.zeros(1), hold="linear", prismatic=(slides,),
        )
    )  # fmt: skip
    known = {"gravity_cos": {"fixed": True}, "gravity_sin": {"fixed": True}, "Kp": {"fixed": True}}
    guesses = {"Ks": {"initial": 0.03}, "sigma0": {"initial": 3.0}, "Fc": {"initial": 0.02}, "Fs": {"initial": 0.03}}
    base = BASE.with_parameters(known | guesses)
    return TorqueStudy(joint=4, runs=(run,), seen=(alternating(run.t.size),), base=base, prismatic=slides)


def test_cogging_in_a_sweep_is_the_most_promising_and_closes_the_gap():
    study = sweep(0.01)
    base = fit_model(study, starts=2)
    scales = study.scales(base.values)
    chosen = ("cogging", "cubic_spring", "position_dependent_friction:wave", "quadratic_drag")
    best, *_ = promises(study, base, {key: catalogue()[key].at(scales) for key in chosen})
    assert best.effect.key == "cogging"
    model = refit_candidate(study, base, best)
    assert compare_candidates("cogging", base, model).acceptable
    assert rms(base.unseen) > 3e-3
    assert rms(model.unseen) < 1.3e-3
    assert model.values["cogging_number"] == pytest.approx(9.0, abs=0.1)
    size = np.hypot(model.values["cogging_sin"], model.values["cogging_cos"])
    assert size == pytest.approx(0.01, rel=0.05)


def test_a_parameter_that_moves_no_torque_leaves_the_errors_of_the_others_finite():
    fitted = fit_model(sweep(0.01))
    place = fitted.problem.parametrisation.ids.index("sigma1")
    jacobian = fitted.jacobian.copy()
    jacobian[:, place] = 0.0
    blind = replace(fitted, jacobian=jacobian)
    assert np.isfinite(blind.covariance).all()
    assert blind.std["sigma1"] == 0.0
    assert blind.std["Fc"] > 0.0


def test_every_held_out_stretch_lies_between_fitted_ones():
    seen = alternating(4885)
    assert 0.6 < seen.mean() < 0.7
    assert seen[0]
    edges = np.flatnonzero(np.diff(seen.astype(int)))
    assert np.diff(edges).max() < 4885 / 20


@pytest.mark.long
@pytest.mark.real("dvrk_mtm_joint4")
def test_the_real_joint_gets_a_story_and_its_gap_shrinks(tmp_path: Path):
    done = CliRunner().invoke(
        main, [str(DATA / "dvrk_mtm_joint4"), "--out", str(tmp_path), "--starts", "1", "--fmu", "native", "--quiet"]
    )
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "discrepancy" / "joint4.json").read_text())
    gap = found["gap"]["validate"]
    assert found["scored"] == "torque"
    assert found["verdict"] in ("named", "partly_named", "ambiguous")
    assert found["residual"] == "torque"
    assert "position_dependent_friction" in {e["id"] for e in found["effects"]}
    stiffness = [e["parameters"]["hysteresis_stiffness"] for e in found["effects"] if e["id"] == "cable_hysteresis"]
    assert all(one["value"] > 0 for one in stiffness)
    assert gap["after"] < 3.7e-3 < gap["before"]
    assert 0 < gap["floor"] < gap["after"]
    assert gap["black_box"] < gap["before"]
    assert gap["after"] > 2 * gap["noise"]
    assert "held-out" in (tmp_path / "discrepancy" / "joint4.html").read_text()
    result = simulate_fmu(str(tmp_path / found["fmu"]), stop_time=0.1, output_interval=0.01)
    assert np.isfinite(result["joint4.reading"]).all()


def test_a_single_sweep_does_not_tell_time_from_place():
    twice = sweep(0.0)
    (run,) = twice.runs
    rows = run.t <= 9.5
    extra = {name: column[rows] for name, column in run.extra.items()}
    once = run.but(t=run.t[rows], u=run.u[rows], y=run.y[rows], extra=extra)
    assert twice.repeats
    assert not replace(twice, runs=(once,), seen=(twice.seen[0][rows],)).repeats
