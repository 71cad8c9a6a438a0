"""The search on joints in which the virtual device has hidden something, or nothing; four effects of the catalogue."""

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from fmpy import simulate_fmu

from haptid.discrepancy.finding.finding import Finding, _predict_groups, as_json, find
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.study.study import Study, study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.report.discrepancy.page import discrepancy_page
from haptid.support.linear_algebra import rms
from haptid.support.listener import ignore_progress
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.fmu_build.accuracy_cases import draws_of, json_of

EFFECTS = {key: catalogue()[key] for key in ("cubic_spring", "cogging", "amplitude_scatter")}
TRUTH = {
    "inertia": 1.6e-4, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.018, "epos": 0.03, "sigma0": 0.5,
    "sigma1": 0.003, "sigma2": 1.3e-3, "vs": 0.06, "Fs": 1.5e-3, "Fc": 1.1e-3,
}  # fmt: skip
KNOWN = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
INPUTS = tuple(
    Cosine(amplitude=a, frequency=w, use=use, duration=10.0, spacing=0.01)
    for a, w, use in ((0.008, 1.5, "fit"), (0.006, 2.5, "fit"), (0.009, 3.5, "fit"), (0.007, 2.0, "validate"))
)


def study_with(
    folder: Path,
    effects: dict[str, dict[str, float]],
    listed: dict[str, Effect],
    sensor: Sensor = Sensor(noise=2e-4, resolution=0.0),  # noqa: B008 - frozen
    seed: int = 5,
) -> Study:
    """Return the study of a joint of the virtual device in which ``effects`` are hidden."""
    make_joint_campaign(folder, 3, TRUTH, INPUTS, effects=effects, sensor=sensor, known=KNOWN, seed=seed)
    return study_of(prepare(read_campaign(folder)), 3, listed)


def found(
    tmp_path: Path, effects: dict[str, dict[str, float]], without: str = "", known_effects: dict[str, Effect] = EFFECTS
) -> Finding:
    study = study_with(tmp_path / "c", effects, {key: e for key, e in known_effects.items() if e.id != without})
    return find(study, tmp_path / "out", kind="python", seed=0, starts=4, tell=ignore_progress)


def angles(page: str) -> list[str]:
    """Units of an angle on a page, but for its pictures and for frequencies, those that pictures tell included."""
    return re.findall(
        r"\bm?rad\b", re.sub(r'src="data:[^"]*"|frequencies between [^,]*,|frequency \[rad/s\]', "", page)
    )


def test_hidden_spring_is_named_added_and_closes_the_gap(tmp_path: Path):
    k3 = 0.02
    finding = found(tmp_path, {"cubic_spring": {"spring_cubic": k3}})
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "named"
    assert [e["id"] for e in data["effects"]] == ["cubic_spring"]
    assert data["effects"][0]["stability"] == 1.0
    estimate = data["effects"][0]["parameters"]["k3"]
    assert abs(estimate["value"] - k3) < 4 * estimate["std"]
    gap = data["gap"]["validate"]
    assert gap["before"] > 1.5 * gap["noise"]
    assert gap["closed"] > 0.9
    assert gap["after"] < 1.1 * gap["noise"]
    json.dumps(data, allow_nan=False)
    _check_accuracy(finding, data)
    page = discrepancy_page(finding, "test", measured=False).html
    assert "SYNTHETIC" in page
    assert "cubic_spring" in page
    assert "100 %" in page
    assert "mrad" in page


def _check_accuracy(finding: Finding, data: dict[str, Any]) -> None:
    """Check what the FMU with the named effect says of itself."""
    assert finding.rebuilt is not None
    path, fit = finding.rebuilt.fmu.path, finding.rebuilt.fit
    (effect,) = json_of(path, "effects.json")["effects"]
    assert effect == {"joint": 3, **data["effects"][0], "gap": data["gap"]}
    (joint,) = json_of(path, "verification.json")["joints"]
    assert [row["rmse"] for row in joint["runs"]] == [score.rmse_rad for score in fit.runs]
    assert [row["over_noise"] for row in joint["runs"]] == [score.over_noise for score in fit.runs]
    draws = draws_of(path)
    assert len(draws) == 200
    drawn = np.array([next(x for name, x in draw.items() if name.endswith(".k3")) for draw in draws])
    std = float(fit.std[fit.index("k3")])
    assert abs(drawn.mean() - fit.values["k3"]) < 4 * std / np.sqrt(200)
    assert drawn.std() == pytest.approx(std, rel=4 / np.sqrt(400))


@pytest.mark.long
def test_a_sealed_run_takes_part_in_no_choice_and_its_gap_is_told(tmp_path: Path):
    more = tuple(
        Cosine(amplitude=a, frequency=w, use="validate", duration=10.0, spacing=0.01)
        for a, w in ((0.008, 2.8), (0.009, 1.7))
    )
    made = tmp_path / "c"
    make_joint_campaign(
        made, 3, TRUTH, (*INPUTS, *more), effects={"cubic_spring": {"spring_cubic": 0.02}}, seed=5, known=KNOWN,
        sensor=Sensor(noise=2e-4, resolution=0.0),
    )  # fmt: skip
    study = study_of(prepare(read_campaign(made)), 3, EFFECTS)
    assert (len(study.unseen), len(study.sealed)) == (2, 1)
    finding = find(study, tmp_path / "out", kind="python", seed=0, starts=4, tell=ignore_progress)
    gap = as_json(finding, measured=False, seed=0)["gap"]["sealed"]
    assert gap["before"] > 1.5 * gap["noise"]
    assert gap["closed"] > 0.9
    assert "sealed runs" in discrepancy_page(finding, "test", measured=False).html
    # With other readings in the sealed run everything but its own gap is the same.
    (sealed,) = study.sealed
    other = replace(study, sealed=(sealed.but(y=sealed.y[::-1].copy()),))
    again = find(other, tmp_path / "again", kind="python", seed=0, starts=4, tell=ignore_progress)
    assert again.search.best.candidate.solution.values == finding.search.best.candidate.solution.values
    assert again.gaps["validate"].before == finding.gaps["validate"].before
    assert again.gaps["sealed"].after > 2.0 * finding.gaps["sealed"].after


def test_a_joint_that_slides_is_told_of_in_metres_and_newtons(tmp_path: Path):
    make_joint_campaign(
        tmp_path / "c", 3, TRUTH, INPUTS, effects={"cubic_spring": {"spring_cubic": 0.02}}, seed=5,
        sensor=Sensor(noise=2e-4), known={"gravity_cos": {"fixed": 0.0}},
    )  # fmt: skip
    read = prepare(read_campaign(tmp_path / "c"))
    runs = tuple(replace(run, prismatic=(True,)) for run in read.runs)
    study = study_of(replace(read, runs=runs), 3, EFFECTS)
    finding = find(study, tmp_path / "out", kind="python", seed=0, starts=4, tell=ignore_progress)
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "named"
    assert {p["unit"] for e in data["effects"] for p in e["parameters"].values()} == {"N/m^3"}
    page = discrepancy_page(finding, "test", measured=False).html
    assert "times the sensor" in page
    assert not angles(page)
    result = simulate_fmu(str(tmp_path / "out" / data["fmu"]), stop_time=0.1, output_interval=0.01)
    assert np.isfinite(result["joint3.reading"]).all()


def test_nothing_hidden_is_nothing_missing(tmp_path: Path):
    finding = found(tmp_path, {})
    assert finding.judgement.verdict == "nothing_missing"
    assert finding.search.best.solution.keys == ()
    assert finding.gaps["validate"].after == pytest.approx(finding.gaps["validate"].noise, rel=0.1)


@pytest.mark.long
def test_the_same_equations_under_two_names_are_ambiguous_for_every_run(tmp_path: Path):
    hidden = {
        "inertia": 1.1e-4, "rotor_inertia": 5e-5, "tendon_stiffness": 3.0, "tendon_damping": 4e-3, "tendon_slack": 0.01,
    }  # fmt: skip
    twins = {key: catalogue()[key] for key in ("tendon_slack", "backlash:motor")}
    finding = found(tmp_path, {"tendon_slack": hidden}, known_effects=twins)
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "ambiguous"
    names = {data["effects"][0]["id"], *(id for a in data["alternatives"] for id in a["ids"])}
    assert names == {"tendon_slack", "backlash"}
    assert "nor would any other" in data["sentence"]
    assert "Either serves" in data["sentence"]
    assert data["next_experiment"]["separation_over_noise"] == 0.0
    assert "no run within these limits" in data["next_experiment"]["run"]
    assert "The run that would tell" not in discrepancy_page(finding, "test", measured=False).html


@pytest.mark.long
def test_two_powers_of_the_position_are_a_curve_and_no_names(tmp_path: Path):
    springs = {key: catalogue()[key] for key in ("asymmetric_spring", "cubic_spring")}
    finding = found(tmp_path, {"payload_gravity": {"payload_cos": 0.006, "payload_sin": 0.006}}, known_effects=springs)
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "unlisted"
    assert "asymmetric_spring and cubic_spring follow it as powers follow any curve" in data["sentence"]
    assert data["unnamed_shape"]["variable"] == "position_rad"


@pytest.mark.long
def test_what_the_catalogue_does_not_hold_gets_no_name_but_a_shape(tmp_path: Path):
    finding = found(tmp_path, {"cubic_spring": {"spring_cubic": 0.02}}, without="cubic_spring")
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "unlisted"
    assert data["fmu"] is None
    shape = data["unnamed_shape"]
    assert shape["variable"] == "position_rad"
    q, torque = np.array(shape["knots"]), np.array(shape["torque_Nm"])
    curve = -0.02 * (q - TRUTH["epos"]) ** 3
    curve -= np.polyval(np.polyfit(q, curve, 1), q)
    assert np.abs(torque - curve).max() < 0.02 * np.ptp(curve)
    assert shape["closed"] > 0.98
    json.dumps(data, allow_nan=False)
    assert "What is missing, without a name" in discrepancy_page(finding, "test", measured=False).html


@pytest.mark.long
def test_the_gap_of_the_fitted_runs_is_what_least_squares_leave(tmp_path: Path):
    """A weak wave was told as 0.136 mrad, which the fit under correlated noise leaves where 0.04 mrad need be left."""
    finding = found(tmp_path, {"cogging": {"cogging": 2e-5, "cogging_number": 30.0}}, without="cogging")
    search = finding.search
    assert finding.judgement.verdict == "unlisted"
    white, correlated = (
        rms(predict(search.study, solution, search.study.fitted).rms)
        for solution in (search.base.solution, search.before.solution)
    )
    gap = finding.gaps["fit"]
    assert (gap.before, gap.after) == (white, white)
    assert white < correlated


@pytest.mark.parametrize("law", [False, True])
def test_the_nominal_model_of_the_fitted_runs_is_the_one_of_least_squares(law: bool, monkeypatch: pytest.MonkeyPatch):
    white, own, asked = (SimpleNamespace(effects=(), noise=SimpleNamespace(scatters=())) for _ in range(3))
    monkeypatch.setattr("haptid.discrepancy.finding.finding.predict", lambda _study, solution, _runs: solution)
    study = SimpleNamespace(fitted=("a.csv",), unseen=(), sealed=())
    search: Any = SimpleNamespace(study=study, base=SimpleNamespace(solution=white), asked=asked if law else None)
    plain: Any = SimpleNamespace(solution=asked if law else own)
    (_, before, after) = _predict_groups(search, plain, cast("Any", SimpleNamespace(solution=own)))["fit"]
    # Under another friction law the one that was asked for is the model before.
    assert (before, after) == ((asked, own) if law else (white, white))
