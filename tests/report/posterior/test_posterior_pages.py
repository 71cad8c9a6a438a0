"""Pages of posteriors, of a joint and of an FMU: the numbers of known posteriors stand at their places."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.report.posterior.foreign_page import foreign_posterior_page
from haptid.report.posterior.page import posterior_page
from haptid.support.tables import Table, text_of
from haptid.uq.foreign.infer import Band, ForeignPosterior
from haptid.uq.job.summary import tell_posterior
from haptid.uq.prediction.choice import Scored
from haptid.uq.prediction.next_run import NextRun
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.arviz_door import Diagnostics, LeaveOneOut
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.record import parameter_json
from haptid.uq.result.summary import Limit, ParameterSummary
from haptid.uq.sampling.sampling import Sample
from tests.report.known import INERTIA, STIFFNESS, T, known_equations, known_run
from tests.report.reading import Seen, ends_of_area, heights, render, told_in

NAMES = ("inertia", "Ks", "cycle_scatter")
PRIOR = np.linspace(0.0, 1.0, 2001)[:, None] * np.array([4e-5, 0.08, 1.0])
"""Draws of flat priors: 95 % of their width lie between the quantiles of 2.5 and 97.5 %."""
COORDINATES = SimpleNamespace(
    names=NAMES, logarithmic=(True, False, True), free=(INERTIA, STIFFNESS), hyper=(SimpleNamespace(id="factor"),),
    values=lambda eta: eta, draw=lambda _rng, _size: PRIOR,
)  # fmt: skip


def summary(id: str, median: float, std: float, *ends: tuple[float, float], unit: str, **known) -> ParameterSummary:
    return ParameterSummary(
        id=id, unit=unit, description=f"meaning of {id}", prior=f"prior of {id}", mean=9.9 * median, std=std,
        median=median, intervals=dict(zip((0.5, 0.8, 0.95), ends, strict=True)), verdict=f"Verdict on {id}.", **known,
    )  # fmt: skip


INERTIA_KNOWN = summary(
    "inertia", 1.234e-4, 3.2e-6, (1.212e-4, 1.257e-4), (1.193e-4, 1.276e-4), (1.171e-4, 1.299e-4), unit="kg m²",
    contraction=0.043, overlap=0.017,
    diagnostics=Diagnostics(rhat=1.0012, ess_bulk=1830.0, ess_tail=1520.0, mcse_mean=7.4e-8),
)  # fmt: skip
KS_KNOWN = summary(
    "Ks", 0.0278, 0.0041, (0.0251, 0.0306), (0.0226, 0.0331), (0.0199, 0.0362), unit="N m/rad", contraction=0.92,
    overlap=0.81, diagnostics=Diagnostics(rhat=1.0034, ess_bulk=970.0, ess_tail=640.0, mcse_mean=1.3e-4),
)  # fmt: skip
SCATTER_KNOWN = summary(
    "cycle_scatter", 0.0147, 0.0023, (0.0131, 0.0164), (0.0118, 0.0178), (0.0104, 0.0195), unit="1",
    contraction=0.11, overlap=0.07,
    diagnostics=Diagnostics(rhat=1.0023, ess_bulk=1140.0, ess_tail=1090.0, mcse_mean=6.8e-5),
)  # fmt: skip
DRAWS = np.random.default_rng(1).uniform(0.9, 1.1, (2, 30, 3)) * np.array([1.234e-4, 0.0278, 0.0147])
SAMPLE = Sample(
    chain=np.zeros((4, 500, 12, 3)), log_prob=np.zeros((4, 500, 12)), acceptance=np.full((4, 12), 0.37),
    tau=np.array([21.0, 32.0, 24.0]), reached=True, move="stretch", trials={"stretch": 41.0, "walk": 67.0},
)  # fmt: skip
WHITE = Scored(model=SimpleNamespace(words="White noise"), mode=None, score=731.4)
SCATTERING = Scored(model=SimpleNamespace(words="Amplitudes scatter"), mode=None, score=758.9)


def bands_of(file: str, use: str, covered: tuple[float, float, float]) -> Bands:
    half = np.array([0.01, 0.02, 0.03])[:, None]
    return Bands(
        run=known_run(file, use), median=np.full(4, 0.2), lower=np.full((3, 4), 0.2) - half,
        upper=np.full((3, 4), 0.2) + 2 * half, covered=np.array(covered), cycle_factors=np.array([[1.021, 0.004]]),
        unit="rad",
    )  # fmt: skip


POSTERIOR = Posterior(
    joint=4, candidates=(WHITE, SCATTERING), chosen=SCATTERING,
    mode=SimpleNamespace(density=SimpleNamespace(coordinates=COORDINATES, equations=known_equations())),
    sample=SAMPLE, parameters=(INERTIA_KNOWN, KS_KNOWN, SCATTER_KNOWN), draws=DRAWS,
    cycle_log_density=np.zeros((2, 30, 3)), run_log_density=np.zeros((2, 30, 2)),
    loo=LeaveOneOut(elpd=742.3, std=16.7, effective=5.0, pareto_k=np.array([0.1, 0.8, 0.3])),
    bands=(bands_of("a.csv", "fit", (0.513, 0.824, 0.946)), bands_of("b.csv", "validate", (0.487, 0.771, 0.932))),
    modes=1,
    next_run=NextRun(
        parameter="Ks", amplitude=0.0643, omega=2.71, duration=18.0, before=0.0041, after=0.0026, repeat=0.0033
    ),
    sensitivity={
        "half": {"inertia": (1.221e-4, 3.1e-6), "Ks": (0.0269, 0.0035)},
        "stated": {"inertia": (1.235e-4, 3.3e-6), "Ks": (0.0279, 0.0042)},
    },
    wall_s=12.0,
)  # fmt: skip
STIFF = replace(INERTIA_KNOWN, id="Ks", intervals=INERTIA_KNOWN.intervals | {0.95: (1.19e-4, 1.28e-4)})
SHORT = replace(
    POSTERIOR, joint=2, next_run=None, sample=replace(SAMPLE, reached=False), parameters=(INERTIA_KNOWN, STIFF)
)


@pytest.fixture(scope="module")
def page() -> Seen:
    return render(posterior_page, [POSTERIOR], title="An arm", synthetic=False, footer=["seed 3"])


def test_the_interval_is_that_of_95_per_cent(page):
    table = page.table("Joint 4")
    assert table.row("inertia") == {
        "parameter": "inertia", "meaning": "meaning of inertia", "verdict": "Verdict on inertia.",
        "median": "0.0001234", "95 % interval": "0.0001171 … 0.0001299", "unit": "kg m²", "prior": "prior of inertia",
    }  # fmt: skip
    row = table.row("Ks")
    assert [row["median"], row["95 % interval"]] == ["0.0278", "0.0199 … 0.0362"]
    assert table.row("cycle_scatter")["95 % interval"] == "0.0104 … 0.0195"


def test_every_level_has_its_own_column(page):
    table = page.table("Joint 4: priors, diagnostics, corner and rank plots", heading="50 % interval")
    assert table.header[2:5] == ["50 % interval", "80 % interval", "95 % interval"]
    assert table.row("inertia") == {
        "parameter": "inertia", "median": "0.0001234", "50 % interval": "0.0001212 … 0.0001257",
        "80 % interval": "0.0001193 … 0.0001276", "95 % interval": "0.0001171 … 0.0001299", "unit": "kg m²",
    }  # fmt: skip


def test_diagnostics_stand_in_their_columns(page):
    table = page.table("Joint 4: priors, diagnostics, corner and rank plots", heading="R̂")
    assert table.row("inertia") == {
        "parameter": "inertia", "prior": "prior of inertia", "overlap": "0.017", "posterior/prior width": "0.043",
        "R̂": "1.0012", "bulk ESS": "1830", "tail ESS": "1520", "MCSE of the mean": "7.4e-08",
    }  # fmt: skip


def test_sensitivity_has_a_column_for_each_width(page):
    table = page.table("Joint 4: priors, diagnostics, corner and rank plots", "Prior sensitivity")
    assert table.rows == [
        ["parameter", "half prior width", "stated prior width"],
        ["inertia", "0.0001221 ± 3.1e-06", "0.0001235 ± 3.3e-06"],
        ["Ks", "0.0269 ± 0.0035", "0.0279 ± 0.0042"],
    ]


def test_noise_models_have_their_scores_and_their_distance(page):
    table = page.table("Joint 4: noise model")
    assert table.rows[1:] == [["White noise", "731.4", "-27.5"], ["Amplitudes scatter (used)", "758.9", "0.0"]]
    assert "Used: Amplitudes scatter. It is the simplest one within 3 " in page.text


def test_the_sampler_has_its_numbers(page):
    said = "\n".join(page.paragraphs)
    assert "4 independent ensembles of 12 walkers, 500 steps each; autocorrelation time 32.0 steps, known" in said
    assert "at least 750 independent draws; acceptance 0.37." in said
    assert "Largest R̂ 1.0034. All ensembles found the same mode." in said
    assert "PSIS-LOO over cycles: 742.3 ± 16.7, 1 of 3 Pareto k above 0.7." in said
    assert "of a trial: stretch 41.0, walk 67.0 steps." in said


def test_the_next_run_has_its_numbers(page):
    said = "To narrow Ks, the least known: run A = 0.0643 N m, ω = 2.71 rad/s for 18 s. "
    gain = (
        "The standard deviation of its coordinate, which is relative for a positive parameter, should go from 0.0041 "
        "to 0.0026 (0.0033 by repeating the most useful of the"
    )
    assert f"{said}{gain}" in page.text


def test_the_lead_counts_what_is_known_and_what_is_not(page):
    assert page.paragraphs[0] == (
        "1 of 2 parameters are known to better than ±10 % (95 %). Set by their priors: Ks of joint 4."
    )


def test_the_overview_has_best_and_least_known():
    page = render(posterior_page, [POSTERIOR, SHORT], title="An arm", synthetic=False, footer=[])
    rows = page.table("All joints")
    assert rows.row("4") == {
        "joint": "4", "best known": "inertia ±5.2 %", "least known": "Ks ±29 %",
        "amplitude scatter": "Verdict on cycle_scatter.", "run to make next": "A = 0.0643, ω = 2.71 rad/s",
        "sampler": "sound",
    }  # fmt: skip
    assert list(rows.row("2").values())[1:] == [
        "Ks ±3.6 %", "inertia ±5.2 %", "none needed by the data", "–", "short",
    ]  # fmt: skip
    assert "3 of 4 parameters are known" in page.paragraphs[0]
    assert "The chains of joint 2 agree but are short" in page.paragraphs[0]


WHERE_ENDS_MATTER = "Where the ends matter, run without --quick; after a whole run, fix what the runs leave open."


def test_the_first_screen_has_a_line_for_each_joint():
    files = ("posterior/joint4.nc", "posterior/joint2.nc", "posterior.json")
    page = render(posterior_page, [POSTERIOR, SHORT], title="An arm", synthetic=False, footer=[], files=files)
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.header[1:5] == ["sampler", "known to ±10 %", "best known", "least known"]
    assert table.rows[1:] == [
        ["joint 4", "sound", "1 of 2", "inertia ±5.2 %", "Ks ±29 %", "Use the intervals.", "joint4.nc posterior.json"],
        ["joint 2", "short", "2 of 2", "Ks ±3.6 %", "inertia ±5.2 %", WHERE_ENDS_MATTER,
         "joint2.nc posterior.json"],
    ]  # fmt: skip
    assert set(files) <= set(page.links)


def test_intervals_of_a_doubted_model_are_not_to_be_used():
    doubted = replace(POSTERIOR, doubts=("The model leaves 440 times the noise.",))
    page = render(posterior_page, [doubted, SHORT], title="An arm", synthetic=False, footer=[], files=())
    assert page.paragraphs[0].startswith("Do not use joint 4 yet: the notes of the joint say why. ")
    (table,) = [grid for grid in page.tables if grid.section == ""]
    actions = [row[5] for row in table.rows[1:]]
    assert table.header[5] == "what to do next"
    assert actions[0] == "Do not use these intervals yet: read what the joint's first notes doubt."
    assert actions[1] == WHERE_ENDS_MATTER


def test_disagreeing_ensembles_are_named():
    page = render(posterior_page, [replace(POSTERIOR, modes=2)], title="An arm", synthetic=False, footer=[])
    assert "Do not use joint 4: independent ensembles disagree." in page.paragraphs[0]
    assert "The ensembles found 2 separate modes." in page.text


RESTLESS = replace(INERTIA_KNOWN, diagnostics=replace(INERTIA_KNOWN.diagnostics, rhat=1.029))
TOO_SHORT = replace(SHORT, parameters=(RESTLESS, STIFF))


def test_chains_of_one_mode_that_are_too_short_are_called_so_and_not_searched_for_modes():
    page = render(posterior_page, [POSTERIOR, TOO_SHORT], title="An arm", synthetic=False, footer=[])
    assert page.paragraphs[0].startswith("Do not use joint 2 yet: the chains are too short. 3 of 4")
    (table,) = [grid for grid in page.tables if grid.section == ""]
    row = table.row("joint 2")
    assert row["sampler"] == "too short"
    assert row["what to do next"].startswith("Do not use these intervals yet: run without --quick; after a whole run, ")
    assert page.table("All joints").row("2")["sampler"] == "too short"
    assert "disagree" not in page.paragraphs[0]


def test_terminal_and_files_say_the_same_word_of_the_chains_at_the_head():
    lines = text_of(tell_posterior(TOO_SHORT)).splitlines()
    assert lines[1].startswith("  too short: ")
    assert "not settled" in lines[-1]
    assert text_of(tell_posterior(POSTERIOR)).splitlines()[1] == "  Verdict on inertia."
    doubted = text_of(tell_posterior(replace(POSTERIOR, doubts=("The model misfits.",)))).splitlines()
    assert doubted[1:4] == [
        "  do not use these intervals yet: The model misfits.",
        "  what follows holds within this model, not for the joint:",
        "  Verdict on inertia.",
    ]


def test_ends_of_a_narrow_interval_are_told_apart():
    """Both ends read 0.36."""
    first = POSTERIOR.parameters[0]
    narrow = replace(first, intervals=first.intervals | {0.95: (0.359998, 0.360002)})
    (told,) = [part for part in tell_posterior(replace(POSTERIOR, parameters=(narrow,))) if isinstance(part, Table)]
    assert told.rows[0][2] == "0.359998 to 0.360002"


def test_a_parameter_at_a_bound_has_a_limit_in_place_of_a_width():
    limit = Limit(side="below", value=1.23e-5, bound=0.0)
    stiffness = replace(KS_KNOWN, contraction=0.01, limit=limit)
    at_zero = replace(POSTERIOR, parameters=(INERTIA_KNOWN, stiffness, SCATTER_KNOWN))
    page = render(posterior_page, [at_zero], title="An arm", synthetic=False, footer=[])
    assert page.paragraphs[0] == (
        "1 of 2 parameters are known to better than ±10 % (95 %). None is set by its prior. "
        "At a bound, so that the data give a limit: Ks of joint 4 (below 1.2e-05 N m/rad)."
    )
    (table,) = [grid for grid in page.tables if grid.section == ""]
    assert table.row("joint 4")["least known"] == "Ks below 1.2e-05 N m/rad"
    assert parameter_json(stiffness)["limit"] == {"side": "below", "value": 1.23e-5, "probability": 0.95}


def test_the_widths_are_those_of_95_per_cent(page):
    _, widths, *_ = page.figures
    assert [text.get_text() for text in widths.axes[0].texts] == ["± 5.2 %", "± 29 %"]
    assert told_in(widths.axes[0])[0] == "inertia: ± 5.19 % with the data, ± 15.4 % by the prior alone"
    prior, *_ = widths.axes[0].containers[0]
    assert prior.get_x() + prior.get_width() == pytest.approx(100 * 0.95 * 4e-5 / 2 / 1.234e-4)


def test_the_bands_hold_what_they_say(page):
    _, _, bands, *_ = page.figures
    left, right, *_ = bands.axes
    assert ends_of_area(left.collections[0]) == [0.17, 0.26]
    assert heights(left.lines[0]) == [0.21, 0.23, 0.19, 0.17]
    assert [ends_of_area(area) for area in right.collections] == [[-30.0, 60.0], [-20.0, 40.0], [-10.0, 20.0]]
    assert heights(right.lines[0]) == [10.0, 30.0, -10.0, -30.0]
    titles = [axis.get_title(loc="left") for axis in bands.axes]
    assert titles[1::2] == [
        "residual; bands of 50, 80, 95 % hold 51.3, 82.4, 94.6 %",
        "residual; bands of 50, 80, 95 % hold 48.7, 77.1, 93.2 %",
    ]


def test_the_cycles_have_their_95_per_cent(page):
    cycles = page.figures[0].axes[0]
    (segment,) = cycles.containers[0].lines[2][0].get_segments()
    assert segment[:, 1].tolist() == pytest.approx([2.1 - 0.784, 2.1 + 0.784])


FOREIGN = ForeignPosterior(
    calibrated=SimpleNamespace(
        campaign=SimpleNamespace(outputs=("arm.q",), measured=True, model=SimpleNamespace(name="Arm"))
    ),
    coordinates=COORDINATES, sample=replace(SAMPLE, chain=DRAWS[:, :, None, :]),
    parameters=(INERTIA_KNOWN, KS_KNOWN, replace(SCATTER_KNOWN, id="factor")),
    bands=(
        Band(
            run=known_run("a.csv"), lower=np.full((4, 1), 0.15), upper=np.full((4, 1), 0.26),
            covered={0.5: 0.53, 0.95: 0.91},
        ),
        Band(
            run=known_run("b.csv", "validate"), lower=np.full((4, 1), 0.15), upper=np.full((4, 1), 0.26),
            covered={0.5: 0.47, 0.95: 0.88},
        ),
    ),
    modes=1, wall_s=3.0,
)  # fmt: skip


def test_an_fmu_s_posterior_has_its_intervals_and_its_coverage():
    page = render(foreign_posterior_page, FOREIGN, ["seed 3"])
    table = page.table("Parameters")
    assert table.row("mechanics.inertia") == {
        "variable": "mechanics.inertia", "median": "0.0001234", "95 % interval": "0.0001171 … 0.0001299",
        "unit": "kg m²", "prior": "prior of inertia", "verdict": "Verdict on inertia.",
    }  # fmt: skip
    assert [table.row("factor")[name] for name in ("median", "95 % interval")] == ["0.0147", "0.0104 … 0.0195"]
    assert page.table("Runs").rows == [
        ["run", "use", "in the 50% band", "in the 95% band"],
        ["a.csv", "fit", "53%", "91%"],
        ["b.csv", "validate", "47%", "88%"],
    ]
    assert "2 ensembles of 1 walkers, 30 steps, autocorrelation time 32.0 steps" in page.text
    band = page.figures[1].axes[0]
    assert ends_of_area(band.collections[0]) == [0.15, 0.26]
    assert heights(band.lines[0]) == [0.21, 0.23, 0.19, 0.17]
    assert band.lines[0].get_xdata().tolist() == T.tolist()


def test_chains_that_have_not_settled_are_named():
    page = render(foreign_posterior_page, replace(FOREIGN, modes=2), [])
    assert page.paragraphs[0].startswith("Ensembles disagree: Independent ensembles found different posteriors.")
    short = replace(FOREIGN, sample=replace(FOREIGN.sample, reached=False))
    page = render(foreign_posterior_page, short, [])
    assert page.paragraphs[0].startswith("Short: The ensembles agree")
