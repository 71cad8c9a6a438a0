"""Several joints that move together: what is missing in one of them is found there."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.discrepancy.finding.finding import Finding, as_json, find
from haptid.discrepancy.fit.nominal_fit import fit_nominal
from haptid.discrepancy.run import main
from haptid.discrepancy.search.search import search
from haptid.discrepancy.study.coupled_study import CoupledStudy, coupled_study_of, place_in_joint, take_from_joint
from haptid.discrepancy.unnamed import missing_torque as shape
from haptid.discrepancy.unnamed.missing_torque import missing
from haptid.discrepancy.unnamed.splines import SYMBOLS, without_polynomial
from haptid.fmu_build.exchange.discrepancy_json import at_values
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.campaign import Campaign
from haptid.model.effects.registry import catalogue
from haptid.model.joint.joint_in_device import of_the_test_alone
from haptid.support.files.files import write_json
from haptid.support.listener import ignore_progress
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import DRIVE, read_truth
from haptid.virtual_device.recording.campaign import header
from haptid.virtual_device.recording.inputs import AMPLITUDE, Cosine
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import write_campaign
from haptid.virtual_device.recording.whole import Controller, Reference, controlled_run, coupled_run, coupled_test
from tests.fmu_build.building.test_commands import identification
from tests.identification.verification.test_verification import true_values

SENSOR = Sensor(noise=2e-4, resolution=1.5e-4)
COG = {"cog": 2e-3, "cog_number": 9.0, "cog_phase": 0.4}
SCATTER = 0.02
EFFECTS = {"cogging": catalogue()["cogging"]}
TESTS = (0, 2, 3)
"""Two of the coupled tests to fit, and the one to judge by."""


def campaign(
    folder: Path, hidden: dict[int, dict[str, float]], scatter: dict[int, tuple[float, bool]] | None = None
) -> Campaign:
    """Write and read the coupled test of joints 0 and 1 of an arm with something hidden."""
    arm = Arm(read_truth(), hidden)
    runs = [
        coupled_test(arm, test, sensor=SENSOR, seed=(3, number), scatter=scatter) for number, test in enumerate(TESTS)
    ]
    write_campaign(folder, header("coupled", "freedom6s", SENSOR), runs, joints=6)
    return prepare(read_campaign(folder))


@pytest.fixture(scope="module")
def with_cogging(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return campaign(tmp_path_factory.mktemp("cogging"), {0: COG})


@pytest.fixture(scope="module")
def finding(tmp_path_factory: pytest.TempPathFactory) -> tuple[Finding, Path]:
    """Search two joints of which one is hidden something, while the other's torque scatters from cycle to cycle."""
    out, folder = tmp_path_factory.mktemp("out"), tmp_path_factory.mktemp("both")
    effects = EFFECTS | {"amplitude_scatter": catalogue()["amplitude_scatter"]}
    study = coupled_study_of(campaign(folder, {0: COG}, {1: (SCATTER, True)}), (0, 1), effects, {}, threads=2)
    return find(study, out, kind="native", seed=0, starts=2, tell=ignore_progress), out


@pytest.mark.parametrize("key", [key for key, e in catalogue().items() if e.random or not of_the_test_alone(e)])
def test_an_effect_in_its_place_and_taken_off_it_is_the_same(key: str):
    effect = catalogue()[key].but(contenders=())
    there = place_in_joint(effect, 3)
    assert there.id == f"joint3_{effect.id}"
    assert {q.id for q in there.parameters} == {f"{q.id}_3" for q in effect.parameters}
    assert there.threshold == effect.threshold
    back = take_from_joint(there, 3)
    assert back.but(title=effect.title, rivals=effect.rivals) == effect


@pytest.mark.long
def test_what_is_hidden_in_each_joint_is_named_there(finding: tuple[Finding, Path]):
    found, out = finding
    assert found.judgement.verdict == "named"
    effect, scatter = found.judgement.effects
    assert (effect.id, scatter.id) == ("joint0_cogging", "joint1_amplitude_scatter")
    truth = {
        "cogging_sin_0": COG["cog"] * np.cos(COG["cog_phase"]),
        "cogging_cos_0": COG["cog"] * np.sin(COG["cog_phase"]),
        "cogging_number_0": COG["cog_number"],
        "amplitude_scatter_1": SCATTER,
    }
    for id, told in (effect.parameters | scatter.parameters).items():
        assert abs(told.value - truth[id]) < 4 * told.std
        assert told.std < 0.35 * truth[id]
    gap = found.gaps["validate"]
    assert gap.before > 1.5 * gap.noise
    assert gap.closed_beside_scatter is not None
    assert gap.closed_beside_scatter > 0.97
    data = json.loads(json.dumps(as_json(found, measured=False, seed=0)))
    assert (data["joint"], data["joints"]) == (None, [0, 1])
    assert (out / data["fmu"]).name == "joints01_joint0_cogging.fmu"
    assert (out / data["fmu"]).exists()
    assert {tuple(c.run.free_joints) for c in found.curves} == {(0,), (1,)}


@pytest.mark.long
def test_where_nothing_is_hidden_nothing_is_found(tmp_path: Path):
    study = coupled_study_of(campaign(tmp_path, {}), (0, 1), EFFECTS, {}, threads=2)
    found = search(study, starts=2)
    assert found.best.adequate
    assert not found.best.solution.effects


@pytest.mark.long
def test_what_a_joints_own_test_has_named_belongs_to_the_base(with_cogging: Campaign):
    values = {"cogging_sin": COG["cog"] * np.cos(0.4), "cogging_cos": COG["cog"] * np.sin(0.4), "cogging_number": 9.0}
    known = {0: (at_values(EFFECTS["cogging"], values),)}
    plain = coupled_study_of(with_cogging, (0, 1), EFFECTS, {}, threads=2)
    plain.equations([place_in_joint(EFFECTS["cogging"], 0)])
    study = coupled_study_of(with_cogging, (0, 1), EFFECTS, known, threads=2)
    assert study.base.parameter("cogging_number_0").fixed
    assert study.base.parameter("cogging_number_0").initial == 9.0
    assert set(study.in_si({q.id: q.initial for q in study.base.parameters})) == {"joint1_cogging"}
    found = search(study, starts=2)
    assert found.best.adequate
    assert not found.best.solution.effects


def test_the_scales_of_a_joint_are_its_own(with_cogging: Campaign):
    study = coupled_study_of(with_cogging, (0, 1), EFFECTS, {})
    assert isinstance(study, CoupledStudy)
    theta = {q.id: q.initial for q in study.base.parameters}
    first, second = study.scales(0, theta), study.scales(1, theta)
    assert first.torque == pytest.approx(AMPLITUDE[0], rel=1e-6)
    assert second.torque == pytest.approx(AMPLITUDE[1], rel=1e-6)
    M = Arm(read_truth()).dynamics(np.zeros(6), np.zeros(6))[0]
    assert first.inertia == pytest.approx(M[0, 0], rel=0.5)
    assert second.inertia == pytest.approx(M[1, 1], rel=0.5)


@pytest.mark.long
def test_what_has_no_name_is_a_torque_of_the_joint_in_which_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    study = coupled_study_of(campaign(tmp_path, {0: {"cubic": 0.3}}), (0, 1), {}, {}, threads=2)
    monkeypatch.setattr(shape, "SYMBOLS", {"position_rad": SYMBOLS["position_rad"]})
    found = missing(study, fit_nominal(study, starts=2).solution)
    assert (found.joint, found.variables) == (0, ("position_rad",))
    assert found.closed > 0.95
    # the cubic of the virtual device, less the straight line that a spring would take up
    q, epos = found.knots[0], float(read_truth().drives[0, DRIVE.index("epos")])
    bend = without_polynomial(q, 2) @ (-0.3 * (q - epos) ** 3)
    assert np.abs(found.torque - bend).max() < 0.2 * np.abs(bend).max()
    assert found.as_json()["joint"] == 0


@pytest.mark.parametrize(
    ("free", "told"),
    [("0,2", "expected runs in which these joints move together"), ("x", "expected joint numbers")],
)
def test_joints_that_no_run_frees_together_are_refused_in_one_line(
    free: str, told: str, tmp_path: Path, with_cogging: Campaign
):
    arguments = [str(with_cogging.folder), "--free", free, "--out", str(tmp_path), "--quiet"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2
    assert told in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def all_joints(folder: Path, hidden: dict[int, dict[str, float]]) -> Path:
    """Write a run of all joints under a controller, beside one of two joints that is to be fitted."""
    reference = Reference(frequency=np.full(6, 1.5), phase=np.zeros(6))
    arm = Arm(read_truth(), hidden)
    run = controlled_run(arm, reference, Controller(), sensor=SENSOR, name="all.csv.gz", seed=(1,))
    head = header("whole", "freedom6s", SENSOR) | {"controller": Controller().described()}
    cosines = [Cosine(amplitude=AMPLITUDE[j], frequency=1.0, use="fit") for j in (0, 1)]
    coupled = coupled_run(arm, cosines, (0, 1), sensor=SENSOR, name="two.csv.gz", seed=(2,))
    write_campaign(folder, head, [coupled, run], joints=6)
    return folder


def test_the_whole_model_needs_an_identified_one(tmp_path: Path):
    folder, out = all_joints(tmp_path / "c", {}), tmp_path / "out"
    result = CliRunner().invoke(main, [str(folder), "--free", "0,1,2,3,4,5", "--out", str(out), "--quiet"])
    assert result.exit_code == 2
    assert "python -m identification.run makes it" in result.stderr
    stage = ["--free", "0,1,2,3,4,5", "--stage", "gap", "--out", str(out), "--quiet"]
    result = CliRunner().invoke(main, [str(folder), *stage])
    assert result.exit_code == 2
    assert result.stderr.splitlines() == [
        "error: --stage gap: expected joints with runs to fit, got --free 0,1,2,3,4,5 without runs to fit"
    ]
    assert not out.exists()


def test_what_was_named_in_a_joint_closes_the_gap_of_the_whole_model(tmp_path: Path):
    """The identified values are the machine's own: what is missed is not the error of parameters."""
    folder, out = all_joints(tmp_path / "c", {3: {"cog": 2e-3, "cog_number": 9.0}}), tmp_path / "out"
    whole = {id: float(value) for id, value in true_values().items()}
    source = identification() | {"configurations": [], "links": {}, "whole": whole}
    write_json(out / "identification.json", source)
    arguments = [str(folder), "--free", "0,1,2,3,4,5", "--out", str(out), "--quiet"]

    def run() -> dict:
        result = CliRunner().invoke(main, arguments)
        assert result.exit_code == 0, result.output
        return json.loads((out / "discrepancy" / "whole.json").read_text())

    alone = run()
    assert alone["verdict"] == "unlisted"
    assert alone["sentence"].startswith("Joint")
    named = {"cogging_sin": 2e-3, "cogging_cos": 0.0, "cogging_number": 9.0}
    own = {id: whole[f"{id}_3"] for id in ("Kp", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")}
    parameters = {id: {"value": x, "std": 1e-5, "unit": ""} for id, x in named.items()}
    finding = {
        "schema": "discrepancy/1", "joint": 3, "measured": False, "verdict": "named", "refit": own | named,
        "effects": [{"id": "cogging", "variant": None, "parameters": parameters}],
    }  # fmt: skip
    write_json(out / "discrepancy" / "joint3.json", finding)
    with_it = run()
    assert with_it["verdict"] == "named"
    assert [e["id"] for e in with_it["effects"]] == ["joint3_cogging"]
    (row,) = [r for r in with_it["gap"]["validate"] if r["joint"] == 3 and r["mode"] == "closed_loop"]
    assert row["before"] > 3 * row["noise"]
    assert row["after"] == pytest.approx(row["noise"], rel=0.1)
    assert "joint3_cogging" in (out / "discrepancy" / "whole.html").read_text()
