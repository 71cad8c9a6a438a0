"""Pages of a torque's search and of all joints together: the numbers of known findings stand at their places."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from haptid.discrepancy.finding.drawn import TorqueLeft
from haptid.discrepancy.finding.full_model import Missed, WholeFinding
from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.torque_finding import Remaining, TorqueFinding
from haptid.discrepancy.torque_search.candidate import TorqueCandidate
from haptid.discrepancy.torque_search.search import TorqueSearch, TorqueStep
from haptid.identification.verification.result import JointCheck, RunCheck, Verification
from haptid.model.equations.quantity import Quantity
from haptid.report.common.page import Page
from haptid.report.discrepancy.full_model_section import full_model_sections
from haptid.report.discrepancy.torque_gap_page import draw_torque_left, torque_gap_page, torque_picture
from haptid.report.discrepancy.whole_gap_page import whole_gap_page
from tests.report.known import T, known_maps, known_run
from tests.report.reading import Seen, ends_of_band, heights, render

AMPLITUDE = Quantity(id="a", unit="N m", description="amplitude", initial=1e-3)
WAVES = Quantity(id="n", unit="1", description="waves a turn", initial=4.0, fixed=True)
EFFECT = SimpleNamespace(
    id="cogging", key="cogging:harmonics", title="cogging torque", formula="a·sin(n·q)", parameters=(AMPLITUDE, WAVES)
)
INERTIA = Quantity(id="inertia", unit="kg m^2", description="inertia", initial=0.02)
STUDY = SimpleNamespace(
    delay=0.0, friction_by_run=None, base=SimpleNamespace(parameters=(INERTIA, WAVES)),
    joint=4, prismatic=False, repeats=True, runs=(known_run("a.csv"),),
    moving=(np.array([True, True, True, True]),),
    fitted_rows=(np.array([True, False, False, True]),), unseen_rows=(np.array([False, True, True, False]),),
    names=lambda rows: np.ones(int(np.sum(rows)), dtype=bool),
)  # fmt: skip


def fitted(residual: list[float], *effects: SimpleNamespace, unseen: float = 0.0) -> SimpleNamespace:
    return SimpleNamespace(
        residual=(np.array(residual),), effects=effects, calls=5,
        values={"a": 3.456e-3, "n": 7.0, "inertia": 0.0234 if effects else 0.0357},
        std={"a": 0.078e-3, "n": 0.0, "inertia": 0.0012}, fitted=np.zeros(2), unseen=np.full(2, unseen),
        unseen_away=np.full(2, unseen), left=unseen, study=STUDY,
    )  # fmt: skip


def candidate(key: str, bic: float, evidence: float, unseen: float) -> TorqueCandidate:
    return TorqueCandidate(
        key=key, model=fitted([0.0] * 4, unseen=unseen), bic=bic, evidence=evidence, errors_gained=3.0,
        significance=9.0, vetoed=False,
    )  # fmt: skip


TAKEN, OTHER = candidate("cogging:harmonics", 318.0, 127.0, 2.43e-3), candidate("backlash", 46.0, 19.0, 6.78e-3)
LATER = candidate("stop", 12.0, 8.0, 1.97e-3)
FINDING = TorqueFinding(
    search=TorqueSearch(
        study=STUDY, base=fitted([0.031, 0.032, 0.033, 0.034]),
        final=fitted([0.006, 0.007, -0.008, -0.009], EFFECT),
        steps=(
            TorqueStep(promises=(SimpleNamespace(columns=17),), candidates=(TAKEN, OTHER), taken=TAKEN),
            TorqueStep(promises=(), candidates=(LATER,), taken=None),
        ),
        stability={"cogging:harmonics": 0.87},
    ),
    gaps={
        "fit": Gap(before=41.7e-3, after=12.9e-3, noise=5.4e-3),
        "validate": Gap(before=53.1e-3, after=14.6e-3, noise=6.2e-3),
        "sealed": Gap(before=67.3e-3, after=31.8e-3, noise=7.9e-3),
    },
    regions=(), maps=known_maps(),
    remaining=Remaining(
        position=np.array([0.2, 0.6]), up=np.array([0.0021, 0.0034]), down=np.array([-0.0043, -0.0056]),
        std=np.array([0.0007, 0.0008]),
    ),
    floor=4.4e-3, black_box=13.7e-3, nominal_loop=None, final_loop=None, fmu=None, considered=43,
    wall_s=29.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def torque() -> Seen:
    return render(torque_gap_page, FINDING, "An arm", measured=True)


def test_the_torque_left_before_stands_before_that_after(torque):
    table = torque.table("Before and after")
    assert table.header == ["", "left before [mN m]", "left after [mN m]", "noise [mN m]", "gap closed"]
    rows = {
        "fitted stretches": ["41.7", "12.9", "5.4", "79 %"],
        "stretches that no fit saw, which chose among candidates": ["53.1", "14.6", "6.2", "82 %"],
        "sealed runs, which took part in no choice": ["67.3", "31.8", "7.9", "60 %"],
    }
    assert {name: list(table.row(name).values())[1:] for name in table.column("")} == rows


def test_torques_from_1_on_stand_in_newton_metres():
    """A gap of 40 N m was told as 40000 mN m in tables and pictures."""
    strong = Gap(before=40.2, after=12.9, noise=0.0054)
    found = replace(FINDING.search, base=fitted([31.0, 32.0, 33.0, 34.0]))
    finding = replace(FINDING, search=found, gaps=dict.fromkeys(("fit", "validate"), strong))
    seen = render(torque_gap_page, finding, "An arm", measured=True)
    table = seen.table("Before and after")
    assert table.header == ["", "left before [N m]", "left after [N m]", "noise [N m]", "gap closed"]
    assert list(table.row("fitted stretches").values())[1:4] == ["40.2", "12.9", "0.0054"]
    axis = Figure().subplots()
    draw_torque_left(
        axis, TorqueLeft(stretches=(np.array([[0.2, 0.4], [3.0, -40.0], [0.5, 0.1]]),), noise=0.1), [False]
    )
    assert axis.get_ylabel() == "held out, left [N m]"
    assert list(axis.lines[0].get_ydata()) == [3.0, -40.0]


def test_residuals_of_a_drive_of_some_newton_metres_stand_in_its_unit():
    """An arm of ±5 N m had its gaps in mN m, beside a picture in N m."""
    run = known_run("a.csv")
    strong = SimpleNamespace(**vars(STUDY) | {"runs": (run.but(y=5.0 * np.sign(run.y + 0.1)),)})
    models = {
        name: SimpleNamespace(**vars(getattr(FINDING.search, name)) | {"study": strong}) for name in ("base", "final")
    }
    finding = replace(FINDING, search=replace(FINDING.search, study=strong, **models))
    seen = render(torque_gap_page, finding, "An arm", measured=True)
    table = seen.table("Before and after")
    assert table.header[1] == "left before [N m]"
    assert list(table.row("fitted stretches").values())[1:4] == ["0.0417", "0.0129", "0.0054"]
    assert seen.table("What was tried", "Round 1").header[3] == "left there [N m]"
    assert TorqueLeft.of(finding).largest == 5.0


def test_an_effect_of_the_torque_has_its_value_and_its_error(torque):
    assert torque.table("What is missing", heading="effect").rows[1:] == [
        ["cogging", "a", "0.003456 ± 0.000078 N m", "87 %"]
    ]


def test_the_nominal_parameters_stand_beside_those_with_the_effects(torque):
    (table,) = [grid for grid in torque.tables if grid.header[:2] == ["parameter", "without the effects"]]
    assert table.section == "What is missing"
    assert table.rows == [
        ["parameter", "without the effects", "with the effects"],
        ["inertia", "0.0357 ± 0.0012 kg m^2", "0.0234 ± 0.0012 kg m^2"],
    ]


def test_a_value_that_the_runs_do_not_tell_has_no_number():
    """The equilibrium of a spring that was not there stood as -10 ± 10239 rad."""
    angle = Quantity(id="epos", unit="rad", description="equilibrium", initial=0.0, lower=-10.0, upper=10.0)
    study = SimpleNamespace(**vars(STUDY) | {"base": SimpleNamespace(parameters=(INERTIA, angle))})
    models = {}
    for name, std in (("base", 10239.0), ("final", 0.5)):
        model = getattr(FINDING.search, name)
        known = {"values": model.values | {"epos": -9.5}, "std": model.std | {"epos": std}}
        models[name] = SimpleNamespace(**vars(model) | known)
    found = replace(FINDING, search=replace(FINDING.search, study=study, **models))
    seen = render(torque_gap_page, found, "An arm", measured=True)
    (table,) = [grid for grid in seen.tables if grid.header[:2] == ["parameter", "without the effects"]]
    assert table.rows[-1] == ["epos", "–", "-9.50 ± 0.50 rad"]


def test_a_refit_through_the_controller_has_a_column_of_its_own():
    loop = SimpleNamespace(values={"a": 2.5e-3, "inertia": 0.0243}, rms={"fit": 1.0}, mean_absolute={})
    seen = render(torque_gap_page, replace(FINDING, nominal_loop=loop, final_loop=loop), "An arm", measured=True)
    effects, nominal = [grid for grid in seen.tables if grid.section == "What is missing"]
    assert effects.row("cogging")["refitted through the controller"] == "0.0025 N m"
    assert nominal.row("inertia")["refitted through the controller"] == "0.0243 kg m^2"


def test_the_formula_of_an_effect_stands_there_once(torque):
    assert torque.text.count("a·sin(n·q)") == 1


def test_the_first_screen_of_a_torque_has_the_sealed_runs(torque):
    (table,) = [grid for grid in torque.tables if grid.section == ""]
    (row,) = table.rows[1:]
    assert row[:7] == ["4", "named", "cogging", "67.3 mN m", "31.8 mN m", "4.03", "a.csv"]
    assert row[8] == "joint4.json"


def test_every_round_has_its_candidates(torque):
    first, second = torque.table("What was tried", "Round 1"), torque.table("What was tried", "Round 2")
    assert first.header == ["entry", "gain in BIC", "evidence on held-out stretches", "left there [mN m]", "taken"]
    assert first.rows[1:] == [["cogging:harmonics", "318", "127", "2.43", "yes"], ["backlash", "46", "19", "6.78", ""]]
    assert second.rows[1:] == [["stop", "12", "8", "1.97", ""]]


def test_the_effort_of_the_torque_s_search_is_told(torque):
    assert torque.paragraphs[-1] == "37 simulations in 29 s."
    assert "43 effects of the catalogue can be read from motion to torque; each round" in torque.text
    assert FINDING.sentence in torque.text


def test_the_torque_s_pictures_draw_what_was_found(torque):
    _, motion, left = torque.figures
    above, below = motion.axes
    drawn = {line.get_label(): heights(line) for line in (*above.lines, *below.lines)}
    assert drawn == {
        "measured": [210.0, 230.0, 190.0, 170.0], "model before": [179.0, 198.0, 157.0, 136.0],
        "model after": [204.0, 223.0, 198.0, 179.0], "left before": [32.0, 33.0], "left after": [7.0, -8.0],
    }  # fmt: skip
    assert ends_of_band(below) == [-12.4, 12.4]
    up, down = left.axes[0].containers
    assert (up.get_label(), heights(up.lines[0])) == ("position grows", [2.1, 3.4])
    assert (down.get_label(), heights(down.lines[0])) == ("position falls", [-4.3, -5.6])
    ends = [segment[:, 1].tolist() for segment in up.lines[2][0].get_segments()]
    assert ends == [pytest.approx([1.4, 2.8]), pytest.approx([2.6, 4.2])]


MISSED = (
    Missed(
        file="all.csv", mode="closed_loop", joint=0, prismatic=False, before=8.31e-3, after=1.42e-3, noise=0.27e-3,
        expected=0.96e-3,
    ),
    Missed(
        file="all.csv", mode="closed_loop", joint=3, prismatic=False, before=7.53e-3, after=2.64e-3, noise=0.38e-3,
        expected=1.15e-3,
    ),
)  # fmt: skip
WHOLE = WholeFinding(joints=(0, 3), verdict="named", sentence="All is named.", names=("cogging",), rows=MISSED)


def test_every_joint_of_the_whole_device_has_its_gap_before_and_after():
    page = render(whole_gap_page, WHOLE, "An arm", measured=True)
    table = page.table("Before and after")
    assert table.header == [
        "run", "simulated", "joint", "missed before [mrad]", "after [mrad]", "expected [mrad]", "noise [mrad]",
    ]  # fmt: skip
    assert table.rows[1:] == [
        ["all.csv", "closed loop", "0", "8.31", "1.42", "0.96", "0.27"],
        ["all.csv", "closed loop", "3", "7.53", "2.64", "1.15", "0.38"],
    ]
    assert "After: with cogging." in page.paragraphs
    (glance,) = [grid for grid in page.tables if grid.section == ""]
    assert [row[:7] for row in glance.rows[1:]] == [
        ["0", "named", "cogging", "8.31 mrad", "1.42 mrad", "5.26", "all.csv (closed loop)"],
        ["3", "named", "cogging", "7.53 mrad", "2.64 mrad", "6.95", "all.csv (closed loop)"],
    ]
    before, after = ([bar.get_height() for bar in bars] for bars in page.figures[0].axes[0].containers)
    assert before == pytest.approx([8.31, 7.53])
    assert after == pytest.approx([1.42, 2.64])
    assert heights(page.figures[0].axes[0].lines[0]) == [0.96, 1.15]


def test_without_a_named_effect_nothing_changes_on_the_whole_device():
    page = render(whole_gap_page, replace(WHOLE, names=()), "An arm", measured=True)
    assert "No effect was named in a joint: before and after agree." in page.paragraphs


def check(joint: int, rmse: float, over_noise: float, spread: float) -> JointCheck:
    return JointCheck(
        joint=joint, prismatic=False, rmse_rad=rmse, rmse_over_noise=over_noise, nrmse=0.05, torque_difference_Nm=0.0,
        torque_rms_Nm=1.0, spread_rad=spread,
    )  # fmt: skip


RUN = RunCheck(
    file="all.csv", use="validate", mode="open_loop",
    joints=(check(0, 3e-3, 15.0, 4.6e-3), check(3, 6e-3, 20.0, 0.4e-3)),
    draws=38, t=T, measured=np.array([[0.1, 0.5]] * 4), simulated=np.array([[0.2, 0.7]] * 4),
    spread=np.array([[0.01, 0.03]] * 4),
)  # fmt: skip


def page_of_draws() -> Page:
    return Page(title="t", lead="l", sections=full_model_sections(Verification(runs=(RUN,))), synthetic=None)


def test_the_whole_device_s_draws_have_residual_and_spread():
    page = render(page_of_draws)
    table = page.table("All joints free")
    assert table.header == ["joint", "residual [rad]", "spread of the draws [rad]", "residual over √(noise² + spread²)"]
    assert table.rows[1:] == [["0", "0.003", "0.0046", "0.65"], ["3", "0.006", "0.0004", "12"]]
    assert table.caption == "all.csv, open loop"
    assert "; 38 draws." in page.captions[0]
    first, second = page.figures[0].axes
    assert [heights(line) for line in first.lines] == [[0.1] * 4, [0.2] * 4]
    edges = second.collections[0].get_paths()[0].vertices[:, 1]
    assert [edges.min(), edges.max()] == pytest.approx([0.64, 0.76])


def test_rows_at_rest_are_drawn_by_nobody_and_set_no_scale() -> None:
    """Stiff presliding may ask for any torque where a joint begins to move: 1500 N m stood in a picture of 1 N m."""
    base, final = fitted([1500.0, 0.0, 0.0, 0.0]), fitted([1500.0, 0.0, 0.0, 0.0])
    study = SimpleNamespace(**vars(STUDY) | {"moving": (np.array([False, True, True, True]),)})
    drawn: list[Figure] = []

    def keep(made: Figure, **_: object) -> None:
        drawn.append(made)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("haptid.report.discrepancy.torque_gap_page.picture_of", keep)
        patch.setattr(
            "haptid.report.discrepancy.torque_gap_page.draw_torque_left",
            lambda axis, *_: axis.plot([0.0], label="left"),
        )
        patch.setattr("haptid.report.discrepancy.torque_gap_page.TorqueLeft", SimpleNamespace(of=lambda _: None))
        found = SimpleNamespace(study=study, base=base, final=final)
        torque_picture(SimpleNamespace(search=found))  # type: ignore[arg-type] # what the picture reads
    (top, *_), measured = drawn[0].axes, 1e3 * STUDY.runs[0].y[1:, 0]
    low, high = top.get_ylim()
    assert low <= measured.min() <= measured.max() <= high
    assert high - low < 2 * np.ptp(measured) + 3
    assert all(np.isnan(line.get_ydata()[0]) for line in top.lines)
