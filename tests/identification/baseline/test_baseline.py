"""The plain model against an independent integration, and the rule that no fit does worse than it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptid.identification.baseline.baseline import Baseline, fit_baseline
from haptid.identification.baseline.compared import compare
from haptid.identification.baseline.figures import figures_of, torque_residual
from haptid.identification.baseline.least_squares import LeastSquares, independent_columns, weighted_least_squares
from haptid.identification.baseline.prediction import predict_unseen
from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.fit.fit_runs import JointTest, fit_runs
from haptid.identification.output.plain_comparison import tell_comparison, tell_over_noise, tell_result
from haptid.identification.output.summary import attention, parameter_rows, tell_summary
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.signals.filtered_motion import FilteredMotion, common_width, filter_run
from haptid.measurement.values.run import Run
from haptid.model.equations.drive import Controller, Drive
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.numbers import plain
from haptid.support.tables import text_of
from tests.identification.plain_joint import TRUE, plain_run


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    return [plain_run(1), plain_run(2), plain_run(3, use="validate")]


def test_the_plain_model_finds_the_truth_within_its_intervals(runs):
    found = fit_baseline(runs, None, (), [1.0])
    rows = found.as_json()["parameters"]
    for id, true in TRUE.items():
        assert abs(rows[id]["value"] - true) < 4 * rows[id]["std"] + 0.01 * abs(true), id
        assert abs(rows[id]["value"] - true) < 0.05 * abs(true), id


def test_the_gain_scales_all_parameters_and_no_prediction(runs):
    one, two = (fit_baseline(runs, None, (), [gain]) for gain in (1.0, 2.0))
    motion = filter_run(runs[0])
    assert two.values["inertia"] == pytest.approx(2 * one.values["inertia"])
    assert two.torque(motion) == pytest.approx(one.torque(motion), abs=1e-9)


def test_a_held_torque_belongs_to_the_middle_of_its_step(runs):
    held = [run.but(hold="zero", u=np.interp(run.t + 1e-3, run.t, run.u[:, 0])[:, None]) for run in runs]
    early, late = (fit_baseline(some, None, (), [1.0]).values["Fv"] for some in (held, runs))
    assert early == pytest.approx(late, rel=1e-3)


def test_figures_of_the_plain_model_are_small_on_an_unseen_run(runs):
    equations = guess(joint_equations(0), runs, given={})
    theta = np.array([q.initial for q in equations.parameters])
    figures = compare(equations, theta, runs, None, ()).figures["run_3.csv", "validate"]["baseline"]
    # Where the joint sticks, the friction of the plain model is not that of the joint.
    assert figures.torque_error[0] < 0.08
    assert figures.free_rmse[0] < 0.05 * np.std(runs[2].y)
    assert figures.horizon_rmse["0.1"][0] < figures.horizon_rmse["10"][0] < 0.05 * np.std(runs[2].y)
    assert set(figures.as_json()) == {"free_rmse", "torque_rmse", "torque_error", "horizon_rmse"}


def test_a_plain_model_with_a_negative_mass_is_not_simulated(runs):
    found, motion = fit_baseline(runs, None, (), [1.0]), filter_run(runs[2])
    assert found.has_positive_masses(motion)
    theta = found.estimate.theta.copy()
    theta[found.regressor.ids.index("inertia")] *= -1.0
    negative = replace(found, estimate=replace(found.estimate, theta=theta))
    assert not negative.has_positive_masses(motion)
    equations = guess(joint_equations(0), runs, given={})
    compared = compare(equations, np.array([q.initial for q in equations.parameters]), runs, None, ())
    model = replace(compared.models["baseline"], baseline=negative)
    figures = figures_of(model, runs[2], motion, torque_residual(model, motion)).as_json()
    assert figures["free_rmse"] is None
    assert set(figures["horizon_rmse"].values()) == {None}
    assert figures["torque_rmse"] > 0.0


@pytest.mark.parametrize(("coupling", "positive"), [(1.0, True), (3.0, False)])
def test_masses_of_coupled_joints_are_positive_together(coupling, positive):
    mass = np.array([[2.0, coupling], [coupling, 2.0]])

    class Masses:
        """A regressor of one parameter, the factor of a mass matrix."""

        def columns(self, motion: FilteredMotion) -> np.ndarray:
            return (motion.a @ mass.T)[:, :, None]

    t, still = np.arange(40) * 0.005, np.zeros((40, 2))
    motion = FilteredMotion(
        t=t, q=still, v=still, a=still, torque=still, width=0.01, edge=4, interior=slice(4, -4)
    )  # fmt: skip
    estimate = LeastSquares(theta=np.ones(1), covariance=np.eye(1))
    assert Baseline(regressor=Masses(), estimate=estimate, gain=np.ones(2)).has_positive_masses(motion) is positive


def test_figures_do_not_depend_on_the_number_of_threads(runs):
    equations = guess(joint_equations(0), runs, given={})
    theta = np.array([q.initial for q in equations.parameters])
    alone, together = (compare(equations, theta, runs, None, (), threads=threads) for threads in (1, 3))
    assert list(together.figures) == [(run.file, run.use) for run in runs]
    assert {key: [one.as_json() for one in both.values()] for key, both in alone.figures.items()} == {
        key: [one.as_json() for one in both.values()] for key, both in together.figures.items()
    }


def test_a_run_shorter_than_a_horizon_leaves_it_out(runs):
    equations = joint_equations(0)
    theta = np.array([q.initial for q in equations.parameters])
    short = runs[0].but(t=runs[0].t[:800], u=runs[0].u[:800], y=runs[0].y[:800])
    figures = compare(equations, theta, [short], None, ()).figures["run_1.csv", "fit"]["model"]
    assert set(figures.horizon_rmse) == {"0.1", "1"}


def test_a_fit_that_predicts_worse_than_the_plain_model_is_replaced(runs):
    # Friction held far from the truth: the fit cannot follow, and the plain model can.
    equations = guess(joint_equations(0), runs, given={})
    held = {id: {"initial": 1.0, "fixed": True} for id in ("Fc", "Fs")}
    test = JointTest(equations=equations.with_parameters(held), build=KernelSimulator.of, runs=runs)
    made = fit_runs(test, options=FitOptions(method="gauss_newton", starts=1))
    assert made.fit.outcome is Outcome.PLAIN
    assert not made.torque_scored
    assert made.fit.values["inertia"] == pytest.approx(TRUE["inertia"], rel=0.05)
    assert made.fit.statuses["sigma0"] == "fixed"
    spring = made.fit.values["Ks"] * made.fit.values["epos"]
    assert -spring == pytest.approx(TRUE["offset"], rel=0.2)
    unseen = next(score for score in made.fit.runs if score.use == "validate")
    assert unseen.rmse_rad < 0.1 * np.std(runs[2].y)
    configuration = Configuration(free_joints=(0,), posture=(), runs=tuple(runs))
    step = Step(configuration=configuration, fit=made.fit, compared=made.compared)
    id, value, std, unit, status = parameter_rows(step)[-1]
    assert (id, unit, status) == ("offset", "N m", "uncertain")
    assert float(value) == pytest.approx(-spring, rel=1e-5)
    assert 0.0 < float(std) < 0.2 * TRUE["offset"]
    (said,) = [sentence for sentence in attention(step) if sentence.startswith("Ks and epos stand for")]
    assert "constant torque offset = -Ks·epos = " in said
    assert "no place of the joint" in said


def test_curves_of_a_run_pass_through_the_filter_of_all_runs(runs):
    equations = guess(joint_equations(0), runs, given={})
    theta = np.array([q.initial for q in equations.parameters])
    noisier = plain_run(2, noise=1e-2)
    machine = [runs[0], noisier, runs[2]]
    prediction = predict_unseen(compare(equations, theta, machine, None, ()))
    width = common_width(machine)
    assert width > filter_run(runs[2]).width
    motion = filter_run(runs[2], width)
    assert np.array_equal(prediction.torque, motion.torque[motion.interior])


def test_the_summary_tells_both_models_where_the_fit_is_above_the_noise(runs):
    equations = guess(joint_equations(0), runs, given={})
    held = {id: {"initial": 1.0, "fixed": True} for id in ("Fc", "Fs")}
    test = JointTest(equations=equations.with_parameters(held), build=KernelSimulator.of, runs=runs)
    made = fit_runs(test, options=FitOptions(method="gauss_newton", starts=1))
    configuration = Configuration(free_joints=(0,), posture=(), runs=tuple(runs))
    step = Step(configuration=configuration, fit=made.fit, compared=made.compared)
    (unseen,) = [both for (_, use), both in made.compared.figures.items() if use == "validate"]
    errors = {name: 100 * float(figures.torque_error[0]) for name, figures in unseen.items()}
    told = tell_comparison(step)
    assert f"torque error {plain(errors['model'])} % (plain model {plain(errors['baseline'])} %)" in told
    assert told.endswith("on unseen runs")
    # A free swing beside it has no torque that an error is a share of.
    (at,) = [key for key in made.compared.figures if key[1] == "validate"]
    swing = {name: replace(one, torque_error=np.array([np.nan])) for name, one in unseen.items()}
    also = replace(made.compared, figures={**made.compared.figures, ("swing.csv", "validate"): swing})
    assert at[0] != "swing.csv"
    assert tell_comparison(replace(step, compared=also)) == told
    summary = text_of(tell_summary([step], {}))
    assert f"joint 0: {told}" in summary
    (inertia,) = [line.split() for line in summary.splitlines() if line.startswith("inertia ")]
    assert inertia == [
        "inertia",
        f"{made.fit.values['inertia']:.6g}",
        f"{made.fit.std[0]:.2g}",
        "kg",
        "m^2",
        "uncertain",  # of a model above the noise, though the runs determine it
    ]
    (fixed,) = [line.split() for line in summary.splitlines() if line.startswith("sigma0 ")]
    assert fixed[2] == "-"
    assert "inertia " not in text_of(tell_summary([step, step], {}))
    assert tell_result(step).startswith("The plain model is the result")
    for farther in ("model", "baseline"):
        strayed = {
            name: replace(one, free_rmse=np.array([2.0 if name == farther else 1.0])) for name, one in unseen.items()
        }
        compared = replace(made.compared, figures={**made.compared.figures, at: strayed})
        assert ("freely over whole runs it strays farther" in tell_result(replace(step, compared=compared))) is (
            farther == "baseline"
        )
    drive = Drive(kind="voltage")  # its torque is that of the fit, so that the plain model cannot take its place
    driven = made.fit.but(outcome=Outcome.ABOVE_NOISE, equations=replace(made.fit.equations, drive=drive))
    told = tell_result(replace(step, fit=driven))
    assert "cannot replace it" in told
    assert "sensor's noise" not in told
    # The torque of a controller whose command it is hangs on no fit: at the noise, the fit stays for its noise.
    loop = Drive(kind="torque", controller=Controller(kind="p", gain=1.0, limit=1.0))
    closed = made.fit.but(outcome=Outcome.ABOVE_NOISE, equations=replace(made.fit.equations, drive=loop))
    assert "cannot replace it" not in tell_result(replace(step, fit=closed))
    prediction = predict_unseen(made.compared)
    for name, figures in unseen.items():
        error = prediction.position - prediction.simulated[name]
        assert np.sqrt(np.mean(error**2)) == pytest.approx(figures.free_rmse[0])


def test_a_residual_far_above_the_noise_is_told_as_a_quantity_and_a_share():
    score = RunScore(file="a.csv", use="fit", rmse=np.array([0.249]), over_noise=17862.0, nrmse=1.03, x0=np.zeros(3))
    assert tell_over_noise(score, "m") == "17862 (250 mm, 100 % of the range)"
    assert tell_over_noise(replace(score, over_noise=1.02), "m") == "1.020"


def test_friction_and_inertia_are_never_negative(runs):
    driving = [run.but(u=-run.u) for run in runs]
    found = fit_baseline(driving, None, (), [1.0])
    assert all(found.values[id] >= 0 for id in ("inertia", "Fv", "Fc"))
    assert found.as_json()["parameters"]["Fc"]["std"] is None


def test_too_few_rows_have_no_plain_model(runs):
    few = runs[0].but(t=runs[0].t[:40], u=runs[0].u[:40], y=runs[0].y[:40])
    assert fit_baseline([few], None, (), [1.0]) is None


def test_the_filter_grows_with_the_noise():
    quiet, loud = (filter_run(plain_run(1, noise=noise, seconds=5.0)).width for noise in (1e-6, 1e-2))
    assert quiet < loud


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), joints=st.integers(1, 3))
def test_least_squares_gives_back_the_parameters_of_exact_rows(seed, joints):
    rng = np.random.default_rng(seed)
    theta = rng.standard_normal(4)
    scale = 10.0 ** rng.integers(-3, 3, 4)
    columns = [rng.standard_normal((60, joints, 4)) * scale for _ in range(2)]
    torques = [W @ theta for W in columns]
    found = weighted_least_squares(columns, torques, np.zeros(4, dtype=bool))
    assert found.theta == pytest.approx(theta, rel=1e-6)


def test_a_column_that_others_explain_is_left_out():
    W = np.random.default_rng(0).standard_normal((80, 1, 3))
    W[:, :, 2] = W[:, :, 0] + W[:, :, 1]
    found = weighted_least_squares([W], [W @ np.array([1.0, 2.0, 0.0])], np.zeros(3, dtype=bool))
    assert found.theta == pytest.approx([1.0, 2.0, 0.0])
    assert np.isnan(found.std[2])


def test_of_more_columns_than_rows_the_first_are_independent():
    A = np.random.default_rng(0).standard_normal((3, 5))
    assert independent_columns(A).tolist() == [True, True, True, False, False]


def test_noise_in_blocks_widens_the_standard_deviation():
    rng = np.random.default_rng(3)
    W = np.ones((4000, 1, 1))
    slow = np.repeat(rng.standard_normal(40), 100)[:, None]
    white = rng.standard_normal((4000, 1))
    free = np.zeros(1, dtype=bool)
    wide, narrow = (weighted_least_squares([W], [W[:, :, 0] + e], free).std[0] for e in (slow, white))
    assert wide == pytest.approx(1 / np.sqrt(40), rel=0.6)
    assert narrow == pytest.approx(1 / np.sqrt(4000), rel=0.6)


def test_runs_are_left_as_they_were(runs):
    before = replace(runs[0])
    filter_run(runs[0])
    assert np.array_equal(before.y, runs[0].y)
