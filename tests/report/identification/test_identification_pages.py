"""Pages of an identification and of a calibrated FMU: the numbers of known fits stand at their places."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.delay import Delay
from haptid.identification.baseline.figures import Figures
from haptid.identification.baseline.friction_loop import friction_loop
from haptid.identification.baseline.prediction import Prediction
from haptid.identification.calibration.calibrate import Calibration
from haptid.identification.calibration.words import parameter_rows as variable_rows
from haptid.identification.links.consistency import Agreement
from haptid.identification.output.priors import tell_device_inertia, tell_priors, tell_unused_priors
from haptid.identification.output.summary import attention, parameter_rows, tell_summary
from haptid.identification.output.traces import Trace
from haptid.identification.result.fit import Basin, Combination, Fit, Interval, RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.result_json import parameter_json
from haptid.identification.sequence.step import Step
from haptid.identification.verification.result import JointCheck, RunCheck, Verification
from haptid.measurement.signals.filtered_motion import state_width
from haptid.model.equations.quantity import Normal
from haptid.report.calibration.page import calibration_page
from haptid.report.common.page import Page
from haptid.report.common.words import word_of
from haptid.report.identification import configuration_sections as configuration_sections_module
from haptid.report.identification.configuration_sections import NOT_DRAWN_AGAIN, configuration_sections
from haptid.report.identification.drawings import Drawings
from haptid.report.identification.friction_figures import friction_figure
from haptid.report.identification.glance import glance_table
from haptid.report.identification.page import Beside, identification_page
from haptid.report.identification.parameter_figures import half_widths, interval_figure
from haptid.support.listener import Listener
from haptid.support.numbers import plain
from haptid.support.tables import text_of
from tests.report.known import STIFFNESS, T, known_equations, known_run
from tests.report.reading import Seen, ends_of_band, heights, render, told_in


def score(file: str, use: str, rmse: float, over_noise: float, nrmse: float) -> RunScore:
    return RunScore(file=file, use=use, rmse=np.array([rmse]), over_noise=over_noise, nrmse=nrmse, x0=np.zeros(1))


SCORES = (score("a.csv", "fit", 2.31e-4, 1.012, 3.4e-3), score("b.csv", "validate", 2.47e-4, 1.034, 5.6e-3))
POOR = (
    score("c.csv", "fit", 3.19e-3, 14.6, 0.041),
    score("d.csv", "validate", 4.28e-3, 23.7, 0.067),
    score("e.csv", "validate", 3.64e-3, 17.2, 0.052),
)
FIT = Fit(
    equations=known_equations(), theta=np.array([1.234e-4, 0.0278, 1.25]), free=("inertia", "Ks"),
    covariance=np.diag([3.2e-6**2, 0.0011**2]), information=np.eye(2), cost=1.0, outcome=Outcome.CONVERGED,
    basins=(
        Basin(over_noise=1.0123, starts=(0, 2, 5), theta=np.zeros(3), simulations=61),
        Basin(over_noise=4.5678, starts=(1,), theta=np.zeros(3), simulations=27),
    ),
    starts=6, x0={}, sigma={}, correlation_time=1.0, simulations=88, wall_s=9.4,
    statuses={"inertia": "identified", "Ks": "prior", "Kp": "fixed"},
    combinations=(Combination(coefficients={"Ks": 1.0, "inertia": -0.37}, value=0.0432, std=0.0019),),
    runs=SCORES, profiles={"Ks": Interval(lower=0.0249, upper=None)},
)  # fmt: skip
FIGURES = {
    "model": Figures(
        free_rmse=np.array([0.0123]), torque_rmse=np.array([0.00456]), torque_error=np.array([0.0789]),
        away_rmse=np.array([0.00412]),
        horizon_rmse={"0.1": np.array([1.61e-4]), "1": np.array([0.00372]), "10": np.array([0.0583])},
    ),
    "baseline": Figures(
        free_rmse=np.array([0.0214]), torque_rmse=np.array([0.00657]), torque_error=np.array([0.0918]),
        away_rmse=np.array([0.00611]),
        horizon_rmse={"0.1": np.array([2.94e-4]), "1": np.array([np.inf])},
    ),
}  # fmt: skip
BASELINE = SimpleNamespace(
    regressor=SimpleNamespace(
        ids=("inertia", "Fc", "offset"), units=("kg m²", "N m", "N m"), n_rigid=1, joints=(4,)
    ),
    estimate=SimpleNamespace(theta=np.array([1.42e-4, 0.0613, 0.0087]), std=np.array([5.1e-6, 0.0024, 0.0])),
    delay=Delay(value=-0.00432, std=0.00037, rows=-2.1, held_out_gain=0.13),
)  # fmt: skip
COMPARED = Compared(
    baseline=BASELINE, figures={("b.csv", "validate"): FIGURES},
    models={"model": SimpleNamespace(simulator=SimpleNamespace(equations=known_equations()), theta=FIT.theta)},
    floor=np.zeros(1), runs=(), width=0.01, width_of_states=0.01,
)  # fmt: skip
AGREEMENTS = (
    Agreement(
        name="mass of link 2", chi2=7.31, dof=2, p=0.026, earlier=(1.31, 0.12), later=(1.58, 0.23), pooled=(1.37, 0.11)
    ),
    Agreement(name="inertia of link 3", chi2=58.4, dof=5, p=2.6e-11),
)
STEP = Step(
    configuration=Configuration(
        free_joints=(4,), posture=(0.31, 0.0, -0.47, 0.0, 0.0),
        runs=(known_run("a.csv"), known_run("b.csv", "validate"), known_run("x.csv", "excluded")),
    ),
    fit=FIT, agreements=AGREEMENTS, compared=COMPARED,
)  # fmt: skip
POOR_STEP = Step(
    configuration=Configuration(
        free_joints=(2,),
        posture=(),
        runs=(
            known_run("c.csv", joint=2),
            known_run("d.csv", "validate", joint=2),
            known_run("e.csv", "validate", joint=2),
        ),
    ),
    fit=FIT.but(runs=POOR, outcome=Outcome.ABOVE_NOISE, profiles={}, combinations=(), wall_s=7.2, starts=4),
)


def trace(one: RunScore) -> Trace:
    return Trace(
        score=one, joints=(4,), t=T, measured=np.array([[0.5], [0.6], [0.7], [0.8]]), simulated=np.full((4, 1), 0.4),
        spread=np.zeros((4, 1)), sigma=np.array([0.023]), unit="rad", scored_from=0.0,
    )  # fmt: skip


def signals(*values: float) -> np.ndarray:
    return np.array(values)[:, None]


PREDICTION = Prediction(
    file="b.csv", use="validate", joints=(4,), prismatic=(False,), torque_t=T, torque=signals(1, 2, 3, 4),
    computed={"model": signals(1.1, 2.1, 3.1, 4.1), "baseline": signals(1.3, 2.3, 3.3, 4.3)}, position_t=T,
    position=signals(5, 6, 7, 8), simulated={"model": signals(5.2, 6, 7, 8), "baseline": signals(5.4, 6, 7, 8)},
)  # fmt: skip


def joint_check(joint: int, rmse: float, over_noise: float, spread: float) -> JointCheck:
    return JointCheck(
        joint=joint, prismatic=False, rmse_rad=rmse, rmse_over_noise=over_noise, nrmse=0.05, torque_difference_Nm=0.0,
        torque_rms_Nm=1.0, spread_rad=spread,
    )  # fmt: skip


VERIFICATION = Verification(
    runs=(
        RunCheck(
            file="all.csv", use="validate", mode="closed_loop",
            joints=(joint_check(2, 2.4e-3, 12.0, 3.2e-3), joint_check(4, 7.8e-3, 26.0, 0.4e-3)), draws=40, t=T,
            measured=np.array([[0.1, 0.5]] * 4), simulated=np.array([[0.2, 0.7]] * 4), spread=np.zeros((4, 2)),
        ),
    ),
    law="PD with 3 N m/rad",
)  # fmt: skip
DATA = {
    "remarks": ["a.csv: 3 rows are missing"], "measured": False, "command": "haptid identify arm",
    "software": {"haptid": "0.1.0", "NumPy": "2.4.1"},
    "links": {"link2": {"mass": {"value": 1.43, "std": 0.17, "unit": "kg", "status": "identified"}}},
}  # fmt: skip


def whole_page(title, steps, traces, predictions, data, verification, *beside) -> Page:
    drawn = [configuration_sections(*one) for one in zip(steps, traces, predictions, strict=True)]
    return identification_page(title, steps, drawn, data, verification, *beside)


@pytest.fixture(scope="module")
def page() -> Seen:
    traces = [[trace(one) for one in step.fit.runs] for step in (STEP, POOR_STEP)]
    return render(whole_page, "An arm", (STEP, POOR_STEP), traces, (PREDICTION, None), DATA, VERIFICATION)


def test_the_lead_has_the_worst_unseen_run_and_the_worst_joint(page):
    lead = page.paragraphs[0]
    assert "what is left is the sensor's noise: joint 4." in lead
    assert "stays above the noise: joint 2 (23.7 × noise) (4.3 mrad, 6.7 % of the range)." in lead
    assert "within 26 × noise on the worst joint, 15.6 × what noise and the spread of the parameters explain" in lead


@pytest.mark.parametrize(
    ("outcome", "said"),
    [
        (Outcome.CONVERGED, "On runs that no fit saw, what is left is the sensor's noise: joint 4 (1.24 × noise)."),
        (Outcome.OBSERVED, "The residual stays above the noise: joint 4 (1.24 × noise)."),
    ],
)
def test_the_lead_agrees_with_the_outcome(outcome, said):
    step = replace(STEP, fit=FIT.but(outcome=outcome, runs=(SCORES[0], replace(SCORES[1], over_noise=1.24))))
    seen = render(whole_page, "A joint", (step,), [[]], (None,), {**DATA, "links": {}}, Verification(runs=()))
    assert seen.paragraphs[0] == said


def test_the_lead_does_not_tell_noise_of_a_model_that_leaves_more_on_the_fitted_runs():
    """The first sentence said that the noise was left, and the outcome below it that the model lacks something."""
    scores = (SCORES[0], replace(SCORES[1], over_noise=1.03))
    basins = (replace(FIT.basins[0], over_noise=1.14), *FIT.basins[1:])
    step = replace(STEP, fit=FIT.but(outcome=Outcome.ABOVE_NOISE, runs=scores, basins=basins))
    seen = render(whole_page, "A joint", (step,), [[]], (None,), {**DATA, "links": {}}, Verification(runs=()))
    assert seen.paragraphs[0] == "The residual stays above the noise: joint 4 (1.14 × noise on the fitted runs)."


def test_the_lead_does_not_tell_structure_as_noise():
    scores = (SCORES[0], replace(SCORES[1], over_noise=1.12, rows=2500, correlation_time=7.0))
    step = replace(STEP, fit=FIT.but(outcome=Outcome.CONVERGED, runs=scores))
    seen = render(whole_page, "A joint", (step,), [[]], (None,), {**DATA, "links": {}}, Verification(runs=()))
    assert seen.paragraphs[0] == "What is left is little more than the noise, but not white: joint 4 (1.12 × noise)."
    (outcome,) = [text for text in seen.paragraphs if "not white: haptid missing" in text]
    assert outcome.startswith("Outcome: converged")


@pytest.mark.parametrize(
    ("posture", "combinations", "said"),
    [
        ((0.0, 0.0), FIT.combinations, "Use the combination that the page lists, or run haptid plan for tests that"),
        ((0.0, 0.0), (), "Run haptid plan for tests that tell them apart."),
        ((), FIT.combinations, "Use the combination that the page lists, or make runs that tell them apart."),
        ((), (), "Make runs that tell them apart."),
    ],
)
def test_what_is_open_is_advised_on_by_what_the_page_and_the_device_have(posture, combinations, said):
    fit = FIT.but(statuses={**FIT.statuses, "Ks": "unidentifiable"}, combinations=combinations)
    step = replace(STEP, configuration=replace(STEP.configuration, posture=posture), fit=fit)
    action = glance_table([step], Verification(runs=()), ()).rows[0][5]
    assert f"Ks: unidentifiable (not known from these runs alone). {said}" in action


def test_what_is_absent_is_not_to_be_told_by_further_runs():
    """Beside "no spring is seen" stood: Ks, epos unidentifiable, make runs that tell them apart."""
    fit = FIT.but(statuses={**FIT.statuses, "Ks": "unidentifiable"}, warnings=("no spring is seen: |Ks| < 3 N m/rad",))
    assert "Ks" not in glance_table([replace(STEP, fit=fit)], Verification(runs=()), ()).rows[0][5]


def test_advice_on_open_parameters_is_given_once():
    fit = FIT.but(statuses={**FIT.statuses, "Ks": "unidentifiable"})
    other = replace(STEP, configuration=replace(STEP.configuration, free_joints=(3,)), fit=fit)
    first, second, third = (
        row[5] for row in glance_table([replace(STEP, fit=fit), other, STEP], Verification(runs=()), ()).rows[:3]
    )
    assert first.count("Ks: unidentifiable (not known from these runs alone). Use the combination") == 1
    assert second == "Use the values. haptid export writes the FMU. Ks: unidentifiable, as for joint 4."
    assert third == "Use the values. haptid export writes the FMU."


@pytest.mark.parametrize(("home", "which"), [(True, "tests in the lock"), (False, "more tests in lock")])
def test_the_lead_tells_the_closed_loop_apart_and_which_tests_would_help(home, which):
    (closed,) = VERIFICATION.runs
    quiet = tuple(replace(one, rmse_over_noise=1.27, rmse_rad=1e-3, spread_rad=2e-3) for one in closed.joints)
    open_loop = tuple(replace(one, rmse_over_noise=2.48) for one in quiet)
    runs = (replace(closed, joints=quiet), replace(closed, joints=open_loop, mode="open_loop"))
    posture = (0.0,) * 5 if home else STEP.configuration.posture
    step = replace(STEP, configuration=replace(STEP.configuration, posture=posture))
    seen = render(whole_page, "An arm", (step,), [[]], (None,), DATA, replace(VERIFICATION, runs=runs))
    said = "within 2.48 × noise on the worst joint, through the stated controller within 1.27 × noise; what these tests"
    assert said in seen.paragraphs[0]
    assert which in seen.paragraphs[0]


def test_a_whole_model_whose_parameters_would_explain_anything_is_uncertain_on_page_and_terminal():
    """214 times the noise had a green tick, because the parameters spread by fifty times as much."""
    (closed,) = VERIFICATION.runs
    verification = replace(VERIFICATION, runs=(replace(closed, joints=(joint_check(1, 0.028, 214.0, 1.4),)),))
    page = render(whole_page, "An arm", (STEP,), [[]], (None,), DATA, verification)
    assert "to 28 mrad (joint 1), within 214 × noise on the worst joint. That is uncertain" in page.paragraphs[0]
    assert "spreads by 11000 × noise" in page.paragraphs[0]
    verdict = glance_table([STEP], verification, ()).rows[1][1]
    assert verdict.text == "uncertain"
    assert word_of(verdict.word).level == "look"
    assert "Whole model: uncertain" in text_of(tell_summary([STEP], verification.as_json()))
    assert "Whole model: uncertain" not in text_of(tell_summary([STEP], VERIFICATION.as_json()))


@pytest.mark.parametrize(("number", "step", "again"), [(1, STEP, True), (2, STEP, False), (2, POOR_STEP, True)])
def test_a_later_posture_is_drawn_in_full_where_it_leaves_more_than_noise(number, step, again):
    later = replace(step, configuration=replace(step.configuration, number=number))
    traces = [trace(one) for one in step.fit.runs]
    (diagnosis,) = [one for one in configuration_sections(later, traces, None) if "diagnosis" in one.anchor]
    alts = [picture.alt for picture in diagnosis.pictures]
    name = later.configuration.name
    for drawn in ("correlation of the residuals", "width of each parameter's interval"):
        assert (f"{name}, {drawn}" in alts) == again
    assert (NOT_DRAWN_AGAIN in diagnosis.paragraphs) != again
    assert diagnosis.tables


def test_a_single_joint_s_report_moves_while_it_is_drawn(monkeypatch):
    """The bar of the report stood at 0 % for several seconds."""
    traces = [trace(one) for one in STEP.fit.runs]
    monkeypatch.setattr(configuration_sections_module, "traces_of", lambda *_: traces)
    monkeypatch.setattr(configuration_sections_module, "predict_unseen", lambda _: PREDICTION)
    told: list[tuple[str, float, int | None, str]] = []
    listener = Listener(progress=lambda title, done, total, part="": told.append((title, done, total, part)))
    with Drawings() as drawings:
        (sections,) = drawings.sections([STEP], lambda _: None, listener)
    assert [one.title for one in sections] == [one.title for one in configuration_sections(STEP, traces, PREDICTION)]
    titles, done, totals, parts = zip(*told, strict=True)
    assert set(titles) == {"report: joint 4"}
    assert set(totals) == {1}
    assert list(done[1:]) == sorted(set(done))
    assert len(done) > 5
    assert max(done) < 1
    assert parts[1:3] == ("simulating the runs", "predicting an unseen run")


def test_the_overview_has_fit_and_validation(page):
    table = page.table("Overview", heading="outcome")
    assert table.header[1:6] == ["fit/noise", "validate/noise", "starts", "best basin", "fit [s]"]
    assert table.rows[1:] == [
        ["joint 4", "1.012", "1.034", "6", "3 of 6", "9.4", "converged"],
        ["joint 2", "15 (3.2 mrad, 4.1 % of the range)", "24 (4.3 mrad, 6.7 % of the range)", "4", "3 of 4", "7.2",
         "above_noise"],
    ]  # fmt: skip
    assert page.table("Remarks on the data").rows[1:] == [["a.csv: 3 rows are missing"]]


def test_a_parameter_has_its_value_its_error_its_guess_and_its_bounds(page):
    table = page.table("Joint 4", "Parameters")
    assert table.row("inertia") == {
        "parameter": "inertia", "value ± std": "(1.234 ± 0.032)e-04", "unit": "kg m²", "status": "identified",
        "first guess": "0.00017", "bounds": "[1e-06, 0.3]", "meaning": "moment of inertia",
    }  # fmt: skip
    row = table.row("Ks")
    assert [row[name] for name in ("value ± std", "status", "first guess", "bounds")] == [
        "0.0278 ± 0.0011", "prior", "0.019", "[-0.4, 0.6]",
    ]  # fmt: skip
    row = table.row("Kp")
    assert [row[name] for name in ("value ± std", "status", "bounds")] == ["1.25", "fixed", ""]


def test_no_value_of_a_model_above_the_noise_is_told_as_identified(page):
    """Its status in the file stays; pages and terminal say by how much the model does not fit."""
    status = dict(zip(page.table("Joint 2", "Parameters").column("parameter"),
                      page.table("Joint 2", "Parameters").column("status"), strict=True))  # fmt: skip
    assert status == {
        "inertia": "uncertain: the model leaves 24 times the noise in its worst run",
        "Ks": "prior",
        "Kp": "fixed",
    }
    assert "#word-unfit-uncertain" in page.links
    assert [row[-1] for row in parameter_rows(POOR_STEP)] == ["uncertain", "prior", "fixed"]
    assert [row[-1] for row in parameter_rows(STEP)] == ["identified", "prior", "fixed"]
    assert f"{status['inertia']}, and what the model lacks may have moved inertia" in attention(POOR_STEP)
    assert not any("uncertain" in sentence for sentence in attention(STEP))


def spread_far(status: str) -> Step:
    """Return a step whose stiffness has an error far beyond its range, and next to no value."""
    fit = FIT.but(
        theta=np.array([1.234e-4, 1e-300, 1.25]), covariance=np.diag([3.2e-6**2, 3.7e12**2]),
        statuses={**FIT.statuses, "Ks": status},
    )  # fmt: skip
    return replace(STEP, fit=fit)


@pytest.mark.parametrize(("status", "told"), [("unidentifiable", "–"), ("prior", "1e-300")])
def test_an_error_far_beyond_the_range_is_not_shown(status, told):
    step = spread_far(status)
    (table,) = [
        t for section in configuration_sections(step, [], None) for t in section.tables if t.caption == "Parameters"
    ]
    assert table.rows[1][1] == told
    assert parameter_rows(step)[1][2] == "-"


def test_the_half_width_of_a_value_next_to_zero_is_infinite_without_a_warning():
    ids, widths = half_widths(spread_far("unidentifiable").fit)
    assert dict(zip(ids, np.isfinite(widths), strict=True)) == {"inertia": True, "Ks": False}
    drawn = interval_figure(ids, widths, [True, False])
    assert [text.get_text() for text in drawn.axes[0].texts] == ["± 5.1 %", "> 100000 %"]
    assert told_in(drawn.axes[0]) == [
        "inertia: ± 5.1 % of the value",
        "Ks: > 100000 % of the value (not identified, or the model does not fit)",
    ]


def with_prior(prior: Normal, status: str) -> Fit:
    equations = known_equations()
    equations.parameters = (equations.parameters[0], STIFFNESS.but(prior=prior), equations.parameters[2])
    return FIT.but(equations=equations, statuses={**FIT.statuses, "Ks": status})


@pytest.mark.parametrize(
    ("prior", "status", "told"),
    [
        (Normal(mean=0.02, std=0.01), "prior", ["known from the prior more than from these runs: Ks"]),
        (Normal(mean=0.02, std=0.01), "identified", []),
        (
            Normal(mean=0.02, std=0.01, source="restraint"),
            "prior",
            ["left open by these runs and held near a usual value, though no prior was stated: Ks"],
        ),
        *(
            (
                Normal(mean=0.02, std=0.001),
                status,
                [
                    "these runs contradict the stated prior of Ks: 0.0278 ± 0.0011 N m/rad lies 7.8 of the prior's "
                    "standard deviations from 0.02 ± 0.001 N m/rad; look whether the prior is right, else what the "
                    "model lacks"
                ],
            )
            for status in ("prior", "identified")
        ),
        # What earlier tests say is compared with this one elsewhere.
        (Normal(mean=0.02, std=0.001, source="earlier"), "identified", []),
    ],
)
def test_a_prior_is_told_as_what_holds_or_as_what_the_runs_contradict(prior, status, told):
    fit = with_prior(prior, status)
    assert tell_priors(fit) == told
    assert [sentence for sentence in attention(replace(STEP, fit=fit)) if "prior" in sentence] == told


@pytest.mark.parametrize(
    ("outcome", "source", "told"),
    [
        (
            Outcome.PLAIN,
            "stated",
            ["the plain model knows the runs alone: its values do not use the stated prior of Ks"],
        ),
        (Outcome.PLAIN, "earlier", []),
        (Outcome.CONVERGED, "stated", []),
    ],
)
def test_a_plain_model_that_does_not_use_a_stated_prior_says_so(outcome: Outcome, source: str, told: list[str]):
    fit = with_prior(Normal(mean=0.0278, std=0.01, source=source), "identified").but(outcome=outcome)
    fit.equations.parameters = fit.equations.parameters[1:]  # without the prior of the inertia
    assert tell_unused_priors(fit) == told


@pytest.mark.parametrize(
    ("ratio", "status", "told"),
    [(0.5, "identified", True), (2.0, "identified", True), (0.9, "identified", False), (0.5, "unidentifiable", False)],
)
def test_an_inertia_unlike_that_of_the_device_file_is_told(ratio: float, status: str, *, told: bool):
    """A URDF with half the inertia of the machine passed without a word."""
    fit = FIT.but(statuses={**FIT.statuses, "inertia": status})
    device = ratio * fit.values["inertia"]
    said = [
        sentence for sentence in attention(replace(STEP, fit=fit, device_inertia=device)) if "device file" in sentence
    ]
    assert bool(said) is told
    if told:
        assert said[0].startswith(f"inertia {plain(fit.values['inertia'], 3)} ± ")
        assert f" kg m² from the data, {plain(device, 3)} kg m² in the device file" in said[0]
    assert tell_device_inertia(fit, None) == []


def test_the_word_for_an_observer_agrees_with_the_status_of_its_values():
    step = replace(POOR_STEP, fit=POOR_STEP.fit.but(outcome=Outcome.OBSERVED))
    assert [row[-1] for row in parameter_rows(step)] == ["uncertain", "prior", "fixed"]
    told = glance_table([step], Verification(runs=()), ()).rows[0][5]
    assert told.startswith("Use identified values, but none that is told as uncertain")
    assert word_of("unfit-uncertain").action.startswith("Do not take it")


def test_an_end_of_a_range_is_not_told_as_one_that_was_given():
    fit = FIT.but(statuses={**FIT.statuses, "Ks": "at_bound"})
    assert "at the end of the range: Ks" in attention(replace(STEP, fit=fit))
    assert "stated or chosen by haptid" in word_of("status-at_bound").meaning


def test_the_file_has_the_status_and_the_word_that_is_told():
    for step, told in ((STEP, "identified"), (POOR_STEP, "uncertain")):
        quantity = step.fit.equations.parameter("inertia")
        entry = parameter_json(quantity, 1e-4, 1e-6, step.fit.statuses["inertia"], step.fit.outcome)
        assert (entry["status"], entry["told_status"]) == ("identified", told)


def test_profiles_and_combinations_have_their_ends_and_errors(page):
    assert page.table("Joint 4", "95 % intervals").rows == [
        ["parameter", "from", "to", "value ± 1.96 std", "unit"],
        ["Ks", "0.0249", "open", "0.025644 to 0.029956", "N m/rad"],
    ]
    assert page.table("Joint 4", "What the data alone know").rows[1:] == [["1·Ks + -0.37·inertia", "0.0432 ± 0.0019"]]


def test_runs_and_minima_have_their_scores(page):
    table = page.table("Joint 4", "Runs")
    assert table.header == ["run", "use", "RMS [rad]", "RMS / noise", "RMS / range"]
    assert table.rows[1:] == [
        ["a.csv", "fit", "0.000231", "1.012", "3.40e-03"],
        ["b.csv", "validate", "0.000247", "1.034", "5.60e-03"],
        ["x.csv", "excluded", "", "", "a cable hung in the way"],
    ]
    minima = page.table("Joint 4", "Minima")
    assert minima.header == ["minimum", "RMS / noise", "reached by starts", "simulations"]
    assert minima.rows[1:] == [["1", "1.0123", "0, 2, 5", "61"], ["2", "4.5678", "1", "27"]]
    assert "Locked joints: 0 at +0.31, 1 at +0, 2 at -0.47, 3 at +0 rad." in page.paragraphs


PLAIN = "Against the plain model: joint 4"


def test_both_models_have_their_errors_by_run(page):
    table = page.table(PLAIN, "Errors of both models")
    assert table.header[3:] == [
        "free simulation [rad]", "torque [N m]", "torque [%]", "0.1 s [rad]", "1 s [rad]", "10 s [rad]",
    ]  # fmt: skip
    assert table.rows[1:] == [
        ["b.csv", "validate", "fit", "0.0123", "0.00456", "7.89", "0.000161", "0.00372", "0.0583"],
        ["b.csv", "validate", "plain", "0.0214", "0.00657", "9.18", "0.000294", "diverged", ""],
    ]


def test_both_models_have_their_parameters_with_both_ends(page):
    table = page.table(PLAIN, "Parameters of the plain model")
    assert table.row("inertia") == {
        "parameter": "inertia", "plain model ± std": "(1.420 ± 0.051)e-04", "95 % interval": "0.000132 to 0.000152",
        "in the fit": "inertia", "fit ± std": "(1.234 ± 0.032)e-04", "95 % interval'": "0.0001171 to 0.0001297",
        "unit": "kg m²",
    }  # fmt: skip
    row = table.row("Fc")
    assert [row["plain model ± std"], row["95 % interval"]] == ["0.0613 ± 0.0024", "0.0566 to 0.066"]
    assert list(table.row("offset").values())[1:] == ["0.0087", "", "", "", "", "N m"]


def test_the_delay_of_the_torque_has_its_size_error_rows_and_sign(page):
    (told,) = [text for text in page.paragraphs if "The torque acts" in text]
    assert told.startswith("The torque acts 4.3 ms ± 370 µs (2.1 rows) before it is recorded")
    assert "the plain model has this delay, the fit has none" in told


def held(step: Step, rows: float, hold: str = "zero") -> Step:
    """Return a step whose torque acts at another time than it was recorded."""
    delay = Delay(value=rows * 2e-3, std=1.7e-5, rows=rows, held_out_gain=0.2)
    baseline = SimpleNamespace(**{**vars(BASELINE), "delay": delay})
    runs = tuple(run.but(hold=hold) for run in step.configuration.runs)
    return replace(
        step, configuration=replace(step.configuration, runs=runs), compared=replace(COMPARED, baseline=baseline)
    )


@pytest.mark.parametrize("outcome", [Outcome.LONELY, Outcome.ABOVE_NOISE])
def test_a_torque_that_acts_half_a_row_early_was_held_by_mistake(outcome):
    """Columns, units and more starts were what to look at, beside a delay of half a row."""
    step = held(replace(POOR_STEP, fit=POOR_STEP.fit.but(outcome=outcome)), -0.49)
    ended, delay, *_ = attention(step)
    assert delay.startswith(
        "the torque acts 980 µs ± 17 µs (0.49 rows) before it is recorded, as one that runs smoothly"
    )
    assert delay.endswith('state hold = "linear" in campaign.toml (or haptid init --hold linear)')
    assert ended.startswith(outcome.value.partition(";")[0])
    assert ended.endswith('; first state hold = "linear" in campaign.toml (or haptid init --hold linear)')
    row = glance_table([step], Verification(runs=()), ()).rows[0]
    assert row[5].startswith('State hold = "linear" in campaign.toml')


@pytest.mark.parametrize(("rows", "told"), [(-0.34, True), (-0.7, True), (-0.258, False), (-0.742, False)])
def test_a_held_torque_that_acts_nearer_to_half_a_row_early_may_run_linearly(rows, told):
    """A third of a row early at 200 Hz was told without the key that takes it away; the error is 0.0085 rows."""
    said = attention(held(POOR_STEP, rows))
    assert said[0] == Outcome.ABOVE_NOISE.value  # what else there is of a delay leaves the remedy of the outcome
    assert said[1].endswith(': try hold = "linear" in campaign.toml (or haptid init --hold linear)') is told
    assert "the plain model has this delay, the fit has none" in said[1]


@pytest.mark.parametrize(("rows", "hold"), [(-0.49, "linear"), (-0.34, "linear"), (-0.8, "zero"), (0.49, "zero")])
def test_another_delay_is_no_held_torque(rows, hold):
    said = attention(held(POOR_STEP, rows, hold))
    assert said[0] == Outcome.ABOVE_NOISE.value
    assert said[1].startswith("the torque acts ")
    assert not any("hold" in sentence for sentence in said)


def test_the_delay_is_worth_a_second_look(page):
    (told,) = [row[0] for row in page.table("Overview", heading="worth a second look").rows if "torque acts" in row[0]]
    assert told.startswith("Joint 4: the torque acts 4.3 ms ± 370 µs (2.1 rows) before it is recorded: ")


def test_a_plain_model_that_is_the_result_leaves_the_fit_without_errors():
    step = replace(STEP, fit=FIT.but(outcome=Outcome.PLAIN))
    data = {**DATA, "links": {}}
    page = render(whole_page, "An arm", (step,), [[]], (None,), data, Verification(runs=()))
    row = page.table(PLAIN, "Parameters of the plain model").row("inertia")
    assert [row["fit ± std"], row["95 % interval'"]] == ["0.0001234", ""]
    meaning = page.table("Joint 4", "Parameters").row("offset")["meaning"]
    assert meaning == "constant torque, which Ks and epos hold"


def test_the_whole_model_has_residual_spread_and_ratio(page):
    table = page.table("Whole model")
    assert table.header[3:] == ["RMS [rad]", "RMS / noise", "parameter spread [rad]", "RMS / expected"]
    assert table.rows[1:] == [
        ["all.csv", "closed loop", "2", "0.0024", "12.00", "0.0032", "0.75"],
        ["all.csv", "closed loop", "4", "0.0078", "26.00", "0.0004", "15.60"],
    ]
    assert "Controller: PD with 3 N m/rad." in page.paragraphs


def test_links_and_agreements_have_their_values_and_errors(page):
    assert page.table("Links").rows[1:] == [["link2", "mass", "1.43 ± 0.17", "kg", "identified"]]
    table = page.table("Agreement between tests")
    assert table.header == ["quantity", "earlier test", "later test", "pooled", "χ² (degrees)", "p", "contradicts"]
    assert table.rows[1:] == [
        ["mass of link 2", "1.31 ± 0.12", "1.58 ± 0.23", "1.37 ± 0.11", "7.31 (2)", "0.026", "no"],
        ["inertia of link 3", "", "", "", "58.40 (5)", "2.6e-11", "yes"],
    ]


def test_the_pictures_draw_runs_models_and_joints(page):
    runs, correlation, intervals, intervals_for_phones, plain, *_, whole = page.figures
    above, other, below, _ = runs.axes
    assert above.get_title() == "a.csv\nfit: RMS = 1.01 × noise"
    assert other.get_title() == "b.csv\nvalidate: RMS = 1.03 × noise"
    assert [heights(line) for line in above.lines] == [[0.5, 0.6, 0.7, 0.8], [0.4] * 4]
    assert heights(below.lines[0]) == [100.0, 200.0, 300.0, 400.0]
    (band,) = below.patches
    assert [band.get_y(), band.get_height()] == pytest.approx([-46.0, 92.0])
    torque, position, torque_left, position_left = plain.axes
    drawn = {line.get_label(): heights(line)[0] for line in torque.lines}
    assert drawn == {"measured": 1.0, "fit": 1.1, "plain model": 1.3}
    assert [heights(line)[0] for line in position.lines] == [5.0, 5.2, 5.4]
    assert [heights(line)[0] for line in torque_left.lines] == [-0.1, -0.3]
    assert [heights(line)[0] for line in position_left.lines] == [-0.2, -0.4]
    assert [line.get_label() for line in correlation.axes[0].lines[:2]] == ["a.csv (fit)", "b.csv (validate)"]
    assert [text.get_text() for text in intervals.axes[0].texts] == ["± 5.1 %", "± 7.8 %"]
    for one in (intervals, intervals_for_phones):
        assert [label.get_text() for label in one.axes[0].get_yticklabels()] == ["inertia", "Ks"]
    assert intervals_for_phones.get_figwidth() == 4.0
    first, second, left_of_first, left_of_second = whole.axes
    assert [axis.get_title() for axis in (first, second)] == ["joint 2: RMS = 0.0024 rad", "joint 4: RMS = 0.0078 rad"]
    assert [heights(line)[0] for line in second.lines] == [0.5, 0.7]
    assert heights(left_of_first.lines[0]) == [-100.0] * 4
    assert heights(left_of_second.lines[0]) == [-200.0] * 4
    assert ends_of_band(left_of_first) == [-0.4, 0.4]
    assert ends_of_band(left_of_second) == [-0.6, 0.6]


def test_the_first_screen_has_a_line_for_each_joint(page):
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.header == [
        "joint", "verdict", "RMS, worst unseen run", "× noise", "worst unseen run", "what to do next", "files",
    ]  # fmt: skip
    assert table.rows[1:] == [
        ["joint 4", "converged", "0.247 mrad", "1.03", "b.csv (validate)",
         "Use the values. haptid export writes the FMU.", "identification.json"],
        ["joint 2", "above noise the model lacks something", "4.28 mrad", "23.7", "d.csv (validate)",
         "Run haptid missing on this joint.", "identification.json"],
        ["all joints", "unexplained more is left than the parameters leave open", "7.8 mrad (joint 4)", "26",
         "all.csv (closed loop)", "Run haptid missing with all joints.", "identification.json"],
    ]  # fmt: skip


def test_each_joint_links_to_its_own_files_and_the_rest_to_the_device():
    files = ("joint4.fmu", "joint4_native.fmu", "arm.fmu", "parameters.ssv")
    data = {**DATA, "links": {}}
    page = render(whole_page, "An arm", (STEP,), [[]], (None,), data, Verification(runs=()), Beside(files=tuple(files)))
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.column("what to do next")[0] == "Use the values."
    assert table.column("files") == [
        "joint4.fmu joint4_native.fmu identification.json", "arm.fmu parameters.ssv identification.json",
    ]  # fmt: skip
    assert set(files) <= set(page.links)


def test_correlations_stand_in_their_row_and_column():
    std = np.array([3.2e-6, 0.0011])
    covariance = np.outer(std, std) * np.array([[1.0, -0.83], [-0.83, 1.0]])
    step = replace(STEP, fit=FIT.but(covariance=covariance))
    data = {**DATA, "links": {}}
    page = render(whole_page, "An arm", (step,), [[]], (None,), data, Verification(runs=()))
    table = page.table("Joint 4: friction, residual, intervals", "Correlations")
    assert table.rows == [["", "inertia", "Ks"], ["inertia", "+1.00", "-0.83"], ["Ks", "-0.83", "+1.00"]]


def test_the_friction_of_the_page_is_that_of_the_worst_unseen_run():
    inverse = SimpleNamespace(
        filtered_friction=lambda _theta, motion, _k: np.full(motion.t.size, 0.3),
        value=lambda _theta, id, _k: {"Kp": 2.0}[id],
    )
    model = SimpleNamespace(inverse=inverse, theta=np.zeros(3), torque=lambda motion: motion.torque - 0.05, delay=0.0)
    t = np.linspace(0.0, 2.0, 201)
    run = replace(known_run("b.csv", "validate"), t=t, u=np.sin(t)[:, None], y=np.cos(3 * t)[:, None])
    loop = friction_loop(SimpleNamespace(models={"model": model}, width=state_width((run,))), run, 0)
    assert (loop.file, loop.use, loop.joint, loop.prismatic) == ("b.csv", "validate", 4, False)
    (axis, _) = friction_figure([loop]).axes
    measured, modelled = axis.lines
    # What the model leaves of the torque, 0.05 N m times the gain, stands between both curves.
    assert set(heights(measured)) == {0.4}
    assert set(heights(modelled)) == {0.3}
    assert axis.get_title() == "joint 4, b.csv (validate)"
    assert np.allclose(
        measured.get_xdata(), -3 * np.sin(3 * t[(t.size - loop.speed.size) // 2 :][: loop.speed.size]), atol=0.05
    )


CALIBRATION = Calibration(
    campaign=SimpleNamespace(
        title="A bench", measured=True, outputs=("arm.q",), model=SimpleNamespace(name="Arm"),
        runs=(known_run("a.csv"), known_run("b.csv", "validate", noise=2.6e-4)),
    ),
    fit=FIT, simulated={"b.csv": np.full((4, 1), 0.2)}, units=("rad",), simulation_s=0.1,
)  # fmt: skip


@pytest.fixture(scope="module")
def calibrated() -> Seen:
    return render(calibration_page, CALIBRATION, DATA)


def test_a_calibrated_variable_has_its_value_its_error_its_guess_and_its_bounds(calibrated):
    table = calibrated.table("Parameters", heading="variable")
    assert table.row("mechanics.inertia") == {
        "variable": "mechanics.inertia", "value ± std": "(1.234 ± 0.032)e-04", "unit": "kg m²",
        "status": "identified", "first guess": "0.00017", "bounds": "[1e-06, 0.3]", "meaning": "moment of inertia",
    }  # fmt: skip
    row = table.row("drive.Kp")
    assert [row["value ± std"], row["bounds"]] == ["1.25", ""]
    combinations = calibrated.table("Parameters", heading="combination")
    assert combinations.rows[1:] == [["1·spring.Ks + -0.37·mechanics.inertia", "0.0432 ± 0.0019"]]


def test_a_value_of_an_fmu_that_does_not_fit_is_uncertain():
    poor = replace(CALIBRATION, fit=FIT.but(outcome=Outcome.ABOVE_NOISE))
    told = render(calibration_page, poor, DATA).table("Parameters", heading="variable").column("status")
    assert told == [row[-1] for row in variable_rows(poor)] == ["uncertain", "prior", "fixed"]


def test_a_calibration_has_the_scores_of_its_runs_and_minima(calibrated):
    assert calibrated.table("Runs").rows[1:] == [
        ["a.csv", "fit", "arm.q", "0.000231", "1.16"], ["b.csv", "validate", "arm.q", "0.000247", "0.95"],
    ]  # fmt: skip
    assert calibrated.table("The FMU").rows[1:] == [["1", "1.0123", "0, 2, 5"], ["2", "4.5678", "1"]]


def test_a_calibration_s_picture_draws_output_residual_and_noise(calibrated):
    above, below = calibrated.figures[0].axes
    assert [heights(line) for line in above.lines] == [[0.21, 0.23, 0.19, 0.17], [0.2] * 4]
    assert heights(below.lines[0]) == [0.01, 0.03, -0.01, -0.03]
    (band,) = below.patches
    assert [band.get_y(), band.get_height()] == pytest.approx([-5.2e-4, 10.4e-4])
