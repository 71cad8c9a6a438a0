"""The page of a search: every number of a known finding stands where its row and its column say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.candidate.candidate import Candidate
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.detect.detectable import Detectable
from haptid.discrepancy.detect.localise import Map, Region
from haptid.discrepancy.detect.omnibus import Omnibus
from haptid.discrepancy.detect.score_tests import Scan, Score
from haptid.discrepancy.finding.finding import Curve, Finding
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.fit.held_out import Prediction
from haptid.discrepancy.fit.nominal_fit import NominalFit
from haptid.discrepancy.job.summary import tell_finding
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.unnamed.missing_torque import Shape
from haptid.discrepancy.verdict.estimate import Estimate
from haptid.discrepancy.verdict.next_experiment import Proposal
from haptid.discrepancy.verdict.verdict import Judgement, NamedEffect
from haptid.report.common.page import Page, Section
from haptid.report.common.style import figure
from haptid.report.discrepancy.glance import position_glance
from haptid.report.discrepancy.page import discrepancy_page
from haptid.report.discrepancy.stage_pictures import gap_picture, scores_picture
from haptid.report.discrepancy.where_pictures import draw_shares, localisation_figure, localisation_picture
from tests.report.known import MAPPED, STIFFNESS, known_equations, known_maps, known_run
from tests.report.reading import Seen, ends_of_band, render, told_in


def trial(keys: tuple[str, ...], bic: float, score: float, values: dict[str, float], *, p: float = 0.3) -> Trial:
    solution = SimpleNamespace(keys=keys, ids=keys, effects=keys, values=values, equations=known_equations())
    prediction = Prediction(score=score, rms=(), y=(), chi2=70.0, rows=100)
    candidate = Candidate(solution=solution, prediction=prediction, parameters=3, bic=bic, calls=1)
    left = Omnibus(energy=1.0, dof=1.0, p=p, parts={}, total=1.0, rows=100)
    return Trial(candidate=candidate, left=left, left_p=p)


PLAIN = trial((), 900.0, 40.0, {"inertia": 1.5e-4, "Ks": 0.0, "Kp": 1.25}, p=3.7e-7)
COGGING = trial(("cogging",), 617.0, 113.0, {"inertia": 1.2e-4, "Ks": 0.027, "Kp": 1.25})
BACKLASH = trial(("backlash",), 838.0, 59.0, {"inertia": 1.4e-4, "Ks": 0.031, "Kp": 1.25}, p=1e-9)
VARYING = replace(trial(("cogging", "drift"), 622.0, 108.0, {}), constant_p=1e-9, varying="sigma2")
SCORES = (
    Score(
        point=SimpleNamespace(key="cogging"), T=412.0, dof=2, log_p=-88.0, family_p=1e-30, flipped_p=0.0041,
        amplitude=(), survives=1.0,
    ),
    Score(
        point=SimpleNamespace(key="drift"), T=23.0, dof=3, log_p=-9.0, family_p=0.017, flipped_p=None, amplitude=(),
        survives=1.0,
    ),
)  # fmt: skip
SCAN = Scan(scores=SCORES, tests=57.0, detectable=(Detectable(key="cogging", parameter="a", size=3.6e-4, unit="N m"),))
SEARCH = Search(
    study=SimpleNamespace(
        title="Joint 4", name="joint4", fitted=(known_run("a.csv"),), unseen=(known_run("b.csv", "validate"),),
        rows_merged=1,
    ),
    base=NominalFit(solution=PLAIN.solution, costs=(1.0, 1.1, 1.2, 1.3, 1.4), reached=3, calls=9),
    plain=PLAIN, scan=SCAN, trials=(BACKLASH, COGGING, VARYING, PLAIN), best=COGGING, simulations=823,
)  # fmt: skip
EFFECT = NamedEffect(
    id="cogging", key="cogging", title="cogging torque", formula="a·sin(n·q)", evidence=146.0,
    parameters={
        "a": Estimate(value=2.345e-3, std=0.067e-3, unit="N m", interval=(2.214e-3, 2.476e-3)),
        "n": Estimate(value=7.12, std=0.13, unit="1", interval=(6.87, 7.38)),
    },
)  # fmt: skip
SHAPE = Shape(
    joint=4, variables=("position_rad",), knots=(np.array([0.1, 0.5]),), torque=np.array([0.0234, -0.0456]),
    std=np.array([0.0017, 0.0023]), gain=31.0, closed=0.372, suggestion="0.02·sin(7q)",
)  # fmt: skip
PROPOSAL = Proposal(
    amplitude=0.063, frequency=2.7, end_frequency=2.7, offset=0.011, duration=14.0, rows=100, evidence=529.0, repeats=1
)
JUDGEMENT = Judgement(
    verdict="named", effects=(EFFECT,), alternatives=(), next_experiment=PROPOSAL, shape=SHAPE,
    sentence="Cogging is missing.",
)  # fmt: skip
GAPS = {
    "fit": Gap(before=4.61e-3, after=0.72e-3, noise=0.21e-3),
    "validate": Gap(before=5.83e-3, after=1.34e-3, noise=0.32e-3),
}
CURVES = (
    Curve(run=known_run("b.csv", "validate"), before=np.full(4, 0.18), after=np.full(4, 0.2)),
    Curve(run=known_run("c.csv", "validate"), before=np.full(4, 0.16), after=np.full(4, 0.22)),
)
FINDING = Finding(
    joints=(4,), search=SEARCH, judgement=JUDGEMENT,
    rebuilt=SimpleNamespace(fmu=SimpleNamespace(path=Path("joint4_cogging.fmu"))),
    gaps=GAPS, curves=CURVES, maps=known_maps(), gap_joint=4,
    regions=(
        Region(variable="position_rad", lower=0.41, upper=0.93, share_of_gap=0.83, share_of_rows=0.29),
        Region(variable="frequency_rad_s", lower=5.2, upper=8.6, share_of_gap=0.64, share_of_rows=0.14),
    ),
    stability={"cogging": 0.94}, wall_s=38.0,
)  # fmt: skip


def page_of(finding: Finding = FINDING) -> Seen:
    return render(discrepancy_page, finding, "A wrist", measured=True)


@pytest.fixture(scope="module")
def page() -> Seen:
    return page_of()


def test_an_effect_has_its_value_its_error_its_interval_and_its_evidence(page):
    table = page.table("What is missing")
    assert table.row("cogging", "a") == {
        "effect": "cogging", "parameter": "a", "value ± std": "0.002345 ± 0.000067 N m",
        "95 % interval": "0.002214 to 0.002476", "evidence for it": "146", "named in bags of runs": "94 %",
    }  # fmt: skip
    row = table.row("cogging", "n")
    assert row["value ± std"] == "7.12 ± 0.13"
    assert row["95 % interval"] == "6.87 to 7.38"


def test_the_formula_of_an_effect_stands_there_once(page):
    assert page.text.count("a·sin(n·q)") == 1
    assert "cogging: a·sin(n·q)" in page.paragraphs


@pytest.mark.parametrize(
    ("proposal", "action"),
    [
        (PROPOSAL, "Make the run that the page proposes, and search again."),
        (replace(PROPOSAL, repeats=99), "Either model serves: choose by what is known of the machine."),
        (None, "Test each of the joints alone, and search again."),
    ],
    ids=["a run tells", "no run tells", "several joints"],
)
def test_between_rivals_the_action_follows_what_the_proposed_run_can_tell(proposal, action):
    ambiguous = replace(JUDGEMENT, verdict="ambiguous", next_experiment=proposal)
    page = page_of(replace(FINDING, judgement=ambiguous))
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.rows[1][7] == action


def test_the_first_screen_has_verdict_gap_and_files(page):
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.header[3:6] == ["missed before", "missed after", "× noise"]
    action = "Use the rebuilt FMU; confirm with a run that no fit saw."
    files = "joint4.json joint4_cogging.fmu"
    assert table.rows[1:] == [
        ["4", "named", "cogging", "5.83 mrad", "1.34 mrad", "4.19", "c.csv (validate)", action, files]
    ]
    assert {"joint4.json", "../fmu/joint4_cogging.fmu", "#word-verdict-named"} <= set(page.links)


def test_where_nothing_is_missing_the_first_screen_has_no_after():
    page = page_of(replace(FINDING, judgement=replace(JUDGEMENT, verdict="nothing_missing"), rebuilt=None))
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.rows[1][1:7] == ["nothing missing", "–", "5.83 mrad", "–", "18.2", "c.csv (validate)"]


def test_an_alarm_below_the_noise_says_what_it_rests_on_and_how_small_it_is():
    left = replace(PLAIN.left, p=3.6e-12, parts={"repeating": 9e-13, "drifting": 0.4, "band": 0.1, "line": 0.2})
    quiet = replace(PLAIN, left=left, left_p=np.nan)
    gaps = {
        "fit": Gap(before=0.205e-3, after=0.205e-3, noise=0.2e-3),
        "validate": Gap(before=0.195e-3, after=0.195e-3, noise=0.2e-3),
    }
    unlisted = replace(JUDGEMENT, verdict="unlisted", effects=(), sentence="Something is missing.")
    search = replace(SEARCH, best=quiet, trials=(quiet,))
    lead = page_of(replace(FINDING, search=search, judgement=unlisted, gaps=gaps, rebuilt=None)).paragraphs[0]
    assert lead == (
        "Something is missing. Runs that no fit saw are missed by no more than the sensor's noise (0.975 × noise): "
        "this rests on a residual that repeats with the drive (p = 4e-12) in the fitted runs, which miss 0.045 mrad "
        "(RMS) beside the noise of 0.2 mrad. A simulation hardly gains by it."
    )
    for other in (replace(unlisted, verdict="named"), unlisted):
        gap = gaps if other.verdict == "named" else GAPS
        page = page_of(replace(FINDING, search=search, judgement=other, gaps=gap, rebuilt=None))
        assert page.paragraphs[0] == "Something is missing."


SCATTER = NamedEffect(
    id="amplitude_scatter", key="amplitude_scatter", title="amplitude that scatters", formula="1 + s·ξ", evidence=41.0,
    parameters={"amplitude_scatter": Estimate(value=0.0123, std=0.0041, unit="1", interval=(0.004, 0.02))},
)  # fmt: skip


def test_what_is_random_alone_is_told_as_random():
    page = page_of(replace(FINDING, judgement=replace(JUDGEMENT, effects=(SCATTER,)), rebuilt=None))
    said = "\n".join(page.paragraphs)
    assert "by 5.83 mrad (RMS), 18 times" in said
    assert "amplitude_scatter 1.2 % ± 0.4 %" in said
    assert "No simulation can follow it" in said
    assert "closes" not in said
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.rows[1][3:5] == ["5.83 mrad", "as before: it is random"]
    assert table.rows[1][7] == "Use the model as it is; haptid posterior gives bands that hold the scatter."


def test_parameters_that_did_not_move_are_not_listed():
    same = replace(SEARCH, best=SEARCH.plain)
    page = page_of(replace(FINDING, search=same))
    assert "No parameter that the runs determine moved by as much as 0.05 %." in page.paragraphs
    assert not [table for table in page.tables if table.section == "Parameters that moved"]


def test_an_effect_without_bags_has_a_dash():
    row = page_of(replace(FINDING, stability={})).table("What is missing").row("cogging", "a")
    assert row["named in bags of runs"] == "–"


def test_the_gap_before_stands_before_that_after(page):
    table = page.table("Before and after")
    assert table.header == ["", "missed before [mrad]", "after [mrad]", "sensor noise [mrad]", "gap closed"]
    assert list(table.row("fitted runs").values())[1:] == ["4.61", "0.72", "0.21", "88.4 %"]
    unseen = table.row("runs that no fit saw, which chose among candidates")
    assert list(unseen.values())[1:] == ["5.83", "1.34", "0.32", "81.5 %"]


def test_the_words_have_the_numbers_of_the_unseen_runs(page):
    said = "\n".join(page.paragraphs)
    assert "misses runs that no fit saw by 5.83 mrad (RMS), 18 times the sensor's noise of 0.32 mrad." in said
    assert "With what was found, it misses them by 1.34 mrad, 4.2 times the noise" in said
    assert "which closes 81.5 % of the gap." in said
    assert "The rebuilt model: fmu/joint4_cogging.fmu." in page.paragraphs


def test_what_is_at_the_noise_is_as_much_as_the_noise():
    gap = Gap(before=5.83e-3, after=0.321e-3, noise=0.32e-3)
    said = "\n".join(page_of(replace(FINDING, gaps={**GAPS, "validate": gap})).paragraphs)
    assert "it misses them by 0.321 mrad, as much as the noise, which closes 100.0 % of the gap." in said


def test_the_words_have_the_numbers_of_the_sealed_runs_where_there_are_any():
    sealed = Gap(before=6.47e-3, after=2.58e-3, noise=0.43e-3, beside=(31.0, 4.0))
    page = page_of(replace(FINDING, gaps={**GAPS, "sealed": sealed}))
    said = "\n".join(page.paragraphs)
    assert "by 6.47 mrad (RMS), 15 times the sensor's noise of 0.43 mrad." in said
    assert "by 2.58 mrad, 6 times the noise, which closes 90.0 % of the gap that is no scatter" in said
    row = page.table("Before and after").row("sealed runs, which took part in no choice")
    assert list(row.values())[1:] == ["6.47", "2.58", "0.43", "90.0 %"]


def test_the_figures_of_a_stand_in_are_those_of_the_terminal_and_say_whose_they_are():
    finding = replace(FINDING, judgement=replace(JUDGEMENT, verdict="unlisted"), rebuilt=None)
    (glance,) = position_glance(finding).rows
    assert "cogging" not in map(str, glance)  # a stand-in is no finding
    page = page_of(finding)
    table = page.table("Before and after")
    assert table.header[2] == "after with the stand-in [mrad]"
    assert table.column("gap closed with the stand-in") == ["88.4 %", "81.5 %"]
    told = "\n".join(str(part) for part in tell_finding(finding, "joint 4", "unlisted"))
    assert all(words in told for words in ("after with the stand-in", "88.4 %", "81.5 %"))
    said = "With the stand-in, it misses them by 1.34 mrad, 4.2 times the noise, which closes 81.5 % of the gap."
    assert said in "\n".join(page.paragraphs)
    assert page.table("What stands in for it").row("cogging", "n")["value ± std"] == "7.12 ± 0.13"


def test_where_nothing_is_missing_only_the_gap_before_is_told():
    page = page_of(replace(FINDING, judgement=replace(JUDGEMENT, verdict="nothing_missing")))
    said = "\n".join(page.paragraphs)
    assert "by 5.83 mrad (RMS)" in said
    assert "1.34" not in said
    assert not [table for table in page.tables if table.section == "What is missing"]


def test_models_are_ranked_with_their_gains_over_the_base(page):
    table = page.table("What was tried")
    assert table.rows[1:] == [
        ["cogging", "283", "146", "yes", "yes"],
        ["cogging + drift", "278", "136", "with other parameters in every run, sigma2 most", ""],
        ["backlash", "62", "38", "no", ""],
        ["noise alone", "0", "0", "no", ""],
    ]
    assert "with p = 3.7e-07" in table.caption


def test_the_model_taken_is_marked_though_it_was_judged_again():
    again = replace(COGGING, refuted=True, least_evidence=17.0)
    table = page_of(replace(FINDING, search=replace(SEARCH, best=again))).table("What was tried")
    assert table.column("taken") == ["yes", "", "", ""]
    other = trial(("cogging", "backlash"), 600.0, 120.0, COGGING.solution.values)
    table = page_of(replace(FINDING, search=replace(SEARCH, best=other))).table("What was tried")
    assert table.rows[1] == ["cogging + backlash", "300", "160", "yes", "yes"]


def test_trials_of_one_model_whose_values_are_arrays_are_told_apart():
    """A search whose end was judged again ended with "the truth value of an array" in place of a page."""

    def with_arrays(one: Trial) -> Trial:
        return replace(
            one, candidate=replace(one.candidate, prediction=replace(one.candidate.prediction, rms=np.ones(2)))
        )

    trials = (with_arrays(COGGING), PLAIN)
    page = page_of(replace(FINDING, search=replace(SEARCH, trials=trials, best=with_arrays(COGGING))))
    assert page.table("What was tried").column("taken") == ["yes", ""]


def test_the_friction_law_of_the_trials_is_named_where_it_is_not_the_one_asked_for():
    study = SimpleNamespace(**vars(SEARCH.study), base=SimpleNamespace(friction=("coulomb",)))
    page = page_of(replace(FINDING, search=replace(SEARCH, study=study, asked=PLAIN)))
    assert (
        "under the friction law coulomb in place of lugre, over the nominal model"
        in page.table("What was tried").caption
    )


def test_scores_have_their_freedom_and_both_their_p(page):
    table = page.table("Scores of the whole catalogue")
    assert list(table.row("cogging").values())[1:] == ["412", "2", "below 1e-12", "0.0041"]
    assert list(table.row("drift").values())[1:] == ["23", "3", "0.017", "–"]
    assert "amounts to 57 independent tests" in table.caption


def test_parameters_that_moved_have_their_values_before_and_after(page):
    table = page.table("Parameters that moved")
    assert table.row("inertia") == {
        "parameter": "inertia", "before": "0.00015", "after": "0.00012", "change": "-3e-05", "unit": "kg m²",
        "change in percent": "-20.0 %",
    }  # fmt: skip
    assert list(table.row("Ks").values())[1:] == ["0", "0.027", "+0.027", "N m/rad", "–"]
    assert table.column("parameter") == ["inertia", "Ks"]


def test_a_parameter_that_the_runs_do_not_determine_has_no_change_in_percent():
    open_ = page_of(replace(FINDING, errors={"inertia": 3e-6, "Ks": 0.019})).table("Parameters that moved")
    assert open_.column("change in percent") == ["-20.0 %", "not known: its error is 0.019"]
    values = COGGING.solution.values | {"Ks": STIFFNESS.lower}
    ended = replace(FINDING, search=replace(SEARCH, best=trial(("cogging",), 617.0, 113.0, values)))
    assert page_of(ended).table("Parameters that moved").row("Ks")["change in percent"] == "not known: at its bound"


def test_where_only_unknown_parameters_moved_there_is_no_table():
    moved = trial(("cogging",), 617.0, 113.0, PLAIN.solution.values | {"Ks": 0.031})
    page = page_of(replace(FINDING, search=replace(SEARCH, best=moved), errors={"Ks": 0.4}))
    assert "No parameter that the runs determine moved by as much as 0.05 %." in page.paragraphs


def test_the_unnamed_torque_has_its_curve_and_its_share(page):
    table = page.table("What is missing, without a name")
    assert table.header == ["position [rad]", "torque ± std [N m]"]
    assert table.rows[1:] == [["0.1", "0.0234 ± 0.0017"], ["0.5", "-0.0456 ± 0.0023"]]
    said = "\n".join(page.paragraphs)
    assert "would close 37.2 % of the gap on runs that no fit saw." in said
    assert "Most of it does not live there" in said
    assert "no finding: 0.02·sin(7q)." in said


def test_a_surface_is_told_beside_its_best_curve():
    surface = replace(
        SHAPE, variables=("position_rad", "velocity_rad_s"), knots=(np.array([0.1, 0.5]), np.array([-1.0, 1.0])),
        torque=np.array([[0.01, 0.02], [0.03, 0.04]]), std=np.full((2, 2), 0.001), closed=0.681, alone=SHAPE,
    )  # fmt: skip
    said = "\n".join(page_of(replace(FINDING, judgement=replace(JUDGEMENT, shape=surface))).paragraphs)
    assert "over position and speed alone, what is missing would close 68.1 % of the gap" in said
    assert "Over position alone it would close 37.2 %." in said
    assert "does not live there" not in said


def test_the_shape_of_what_names_leave_says_so():
    beside = replace(JUDGEMENT, shape=replace(SHAPE, beside=("cogging",)))
    said = page_of(replace(FINDING, judgement=beside))
    assert said.table("What is left, without a name").rows[1:] == [
        ["0.1", "0.0234 ± 0.0017"],
        ["0.5", "-0.0456 ± 0.0023"],
    ]
    lines = "\n".join(said.paragraphs)
    assert "over position alone, what the named effects leave would close 37.2 % of it on runs" in lines


def test_the_run_that_would_settle_it_and_the_smallest_effect_have_their_sizes(page):
    said = "\n".join(page.paragraphs)
    assert "The run that would tell: cosine torque of 0.063 N m at 2.7 rad/s about 0.011 N m, from rest, 14 s" in said
    assert "the rivals still differ by 2.3 times the noise." in said
    row = page.table("How small an effect would have been seen").row("cogging")
    assert row == {"entry": "cogging", "parameter": "a", "smallest size": "0.00036 N m"}


def test_the_regions_have_their_shares_of_gap_and_of_samples(page):
    assert "83 % of the gap lies at a position between 0.41 and 0.93 rad, in 29 % of the samples." in page.paragraphs
    assert "64 % of the gap lies at frequencies between 5.2 and 8.6 rad/s, in 14 % of the spectrum." in page.paragraphs


def test_the_effort_is_told(page):
    assert page.paragraphs[-1] == (
        "3 of 5 starts reached the nominal model's best minimum; 823 runs simulated in the search's fits; 38 s in all."
    )


def test_merged_rows_are_told():
    study = SimpleNamespace(**{**vars(SEARCH.study), "rows_merged": 5})
    page = page_of(replace(FINDING, search=replace(SEARCH, study=study)))
    assert page.paragraphs[-1].startswith("Searched with one row in the place of 5: ")


def lines(axis) -> dict[str, list[float]]:
    return {line.get_label(): [float(f"{y:.6g}") for y in line.get_ydata()] for line in axis.lines}


def test_the_pictures_draw_what_was_found(page):
    shape, where, gap = page.figures
    above, _, below, _ = gap.axes
    assert lines(above) == {
        "measured": [0.21, 0.23, 0.19, 0.17], "simulated before": [0.18] * 4, "simulated after": [0.2] * 4,
    }  # fmt: skip
    assert lines(below) == {"before": [30.0, 50.0, 10.0, -10.0], "after": [10.0, 30.0, -10.0, -30.0]}
    assert ends_of_band(below) == [-0.4, 0.4]
    curve = shape.axes[0].lines[1]
    assert curve.get_ydata().tolist() == SHAPE.torque.tolist()
    (region,) = shape.axes[0].collections
    edges = region.get_paths()[0].vertices[:, 1]
    assert [edges.min(), edges.max()] == pytest.approx([-0.0456 - 0.0046, 0.0234 + 0.0034])
    for axis, (share, rows) in zip(where.axes, MAPPED.values(), strict=True):
        assert [bar.get_height() for bar in axis.containers[0]] == pytest.approx(share)
        assert axis.patches[-1].get_data().values.tolist() == pytest.approx(rows)
        shares = [f"{a:.1f} % of the gap, {b:.1f} % of the samples" for a, b in zip(share, rows, strict=True)]
        assert [told.partition(": ")[2] for told in told_in(axis)] == shares
    assert told_in(where.axes[0])[0].startswith("position [rad] 0 to 0.4: ")


def pictured() -> Page:
    pictures = (gap_picture(CURVES), scores_picture(SCAN))
    return Page(title="t", lead="l", sections=[Section(title="s", pictures=pictures)], synthetic=None)


def test_the_pictures_of_the_stages_draw_the_same():
    gap, scores = render(pictured).figures
    assert [float(f"{y:.6g}") for y in gap.axes[0].lines[0].get_ydata()] == [30.0, 50.0, 10.0, -10.0]
    assert ends_of_band(gap.axes[0]) == [-0.4, 0.4]
    assert [bar.get_width() for bar in scores.axes[0].containers[0]] == pytest.approx([-np.log10(0.017), 16.0])
    assert [told.partition(": ")[2] for told in told_in(scores.axes[0])] == ["p = 0.017", "p = 1e-30"]


def test_a_variable_of_one_bin_is_not_drawn():
    """The panel of the only cycle said nothing, and its ticks stood over each other."""
    only = Map(variable="cycle", edges=np.array([-0.5, 0.5]), excess=np.array([3.0]), rows=np.array([7.0]))
    maps = (*known_maps()[:2], only)
    drawn = localisation_figure(maps, [False])
    assert [axis.get_xlabel() for axis in drawn.axes] == ["position [rad]", "speed [rad/s]"]
    assert localisation_picture(maps, [False]).alt == "residual energy over position, speed"
    axis = figure().subplots()
    draw_shares(axis, only, [False])
    assert [tick for tick in axis.get_xticks() if 0.5 <= tick <= 1.5] == [1.0]


def test_a_large_evidence_is_told_with_three_digits():
    """16184308725 was told: twice the gain of log-likelihoods of thousands of rows by a sensor without noise."""
    effects = [replace(effect, evidence=16184308724.967838) for effect in JUDGEMENT.effects]
    page = page_of(replace(FINDING, judgement=replace(JUDGEMENT, effects=effects)))
    assert page.table("What is missing").row("cogging", "a")["evidence for it"] == "1.62e+10"
