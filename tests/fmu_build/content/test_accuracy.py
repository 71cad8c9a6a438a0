"""FMUs of first guesses say so, and what replaced an identified value takes its draws away."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from haptid.fmu_build.accuracy.draws import digest_of, draws_text
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.fmu_build.export import export_joint
from haptid.fmu_build.native.platforms import this_platform
from haptid.support.errors import InputError
from tests.fmu_build.accuracy_cases import FILES, draws_of, json_of, page_of, table_of, text_of
from tests.fmu_build.fmu_cases import equations, fmu

COLUMNS = ("inertia", "Ks", "Fs", "Fc")


@pytest.fixture(autouse=True)
def here_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())


def results(folder: Path) -> dict[str, Any]:
    """Return an identification.json of joint 4 whose draws lie in a folder."""
    quantities = equations("joint4").parameters
    centre = np.array([q.initial for q in quantities if q.id in COLUMNS])
    values = centre * (1 + 0.01 * np.random.default_rng(1).standard_normal((200, 4)))
    ids = [q.id for q in quantities if q.id in COLUMNS]
    text = draws_text(ids, values)
    (folder / "draws").mkdir()
    (folder / "draws" / "joint4.csv").write_text(text)
    entries = {
        q.id: {"value": q.initial, "std": 0.01 * abs(q.initial), "unit": q.unit, "status": "identified"}
        for q in quantities
    }
    return {
        "schema": "identification/1",
        "device": "single_joint",
        "campaign": "a <test>",
        "measured": False,
        "configurations": [
            {"free_joints": [4], "parameters": entries, "data": "0123", "noise_rad": 2e-4, "runs": RUNS}
        ],
        "draws": {"joint4": {"digest": digest_of(text.encode()), "source": "a test", "seed": 7}},
    }


RUNS = [
    {
        "file": "a.csv", "use": "fit", "rmse_rad": 2e-4, "rmse_over_noise": 1.0,
        "figures": {"model": {"free_rmse": 3e-4, "torque_rmse": 1e-5, "torque_error": 0.02}},
    },
    {
        "file": "b.csv", "use": "validate", "rmse_rad": 2.2e-4, "rmse_over_noise": 1.1,
        "figures": {"model": {"free_rmse": 5e-4, "closed_rmse": 4e-4, "torque_rmse": 2e-5, "torque_error": 0.03}},
    },
]  # fmt: skip


@pytest.mark.parametrize("kind", ["python", "native"])
def test_first_guesses_say_so(kind: Any):
    path = fmu("joint4", kind).path
    assert validate_fmu(str(path)) == []
    assert fmpy.read_model_description(str(path)).description.endswith("values: first guesses")
    verification = json_of(path, "verification.json")
    assert verification["joints"] == []
    assert verification["synthetic"] is None
    assert "first guesses" in verification["draws"]["source"]
    assert draws_of(path) == []
    assert {row["status"] for row in table_of(path, "parameters.csv")} <= {"first guess", "fixed"}
    assert "Nothing was verified: no parameter was identified" in page_of(path)
    assert "SYNTHETIC" not in page_of(path)


def test_an_identification_fmu_says_nothing_of_values_that_a_fit_sets():
    path = fmu("joint4", "python", identification=True).path
    with pytest.raises(KeyError):
        text_of(path, "extra/haptid/verification.json")
    assert "How good it is" not in page_of(path)


def test_all_files_are_there_with_the_numbers_of_the_results(tmp_path: Path):
    data = results(tmp_path)
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    assert validate_fmu(str(path)) == []
    assert all(text_of(path, f"extra/haptid/{name}") for name in FILES)
    entries = data["configurations"][0]["parameters"]
    stem = {row["name"].rpartition(".")[2]: row for row in table_of(path, "parameters.csv")}
    for id, entry in entries.items():
        row = stem[id]
        assert (float(row["value"]), float(row["std"]), row["status"]) == (entry["value"], entry["std"], "identified")
    drawn = np.array([list(draw.values()) for draw in draws_of(path)])
    assert drawn.shape == (200, 4)
    Ks = [draw["joint4.spring.Ks"] for draw in draws_of(path)]
    assert float(stem["Ks"]["q0.025"]) == pytest.approx(np.quantile(Ks, 0.025), rel=1e-12)
    matrix = [[float(x) for x in list(row.values())[1:]] for row in table_of(path, "correlation.csv")]
    np.testing.assert_allclose(matrix, np.corrcoef(drawn.T), atol=1e-12)
    assert json_of(path, "digests.json")["data"] == {"4": "0123"}


def test_a_value_of_a_model_that_does_not_fit_is_told_as_uncertain(tmp_path: Path):
    data = results(tmp_path)
    data["configurations"][0]["parameters"]["Ks"]["told_status"] = "uncertain"
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    stem = {row["name"].rpartition(".")[2]: row["status"] for row in table_of(path, "parameters.csv")}
    assert (stem["Ks"], stem["Fc"]) == ("uncertain", "identified")
    assert page_of(path).count("<td>uncertain</td>") == 1


def test_the_verification_is_by_run_and_way_of_comparison(tmp_path: Path):
    path = export_joint(results(tmp_path), 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    (joint,) = json_of(path, "verification.json")["joints"]
    rows = {(row["file"], row["mode"]): row for row in joint["runs"]}
    assert set(rows) == {
        *((file, mode) for file in ("a.csv", "b.csv") for mode in ("as_fitted", "open_loop", "torque")),
        ("b.csv", "closed_loop"),
    }
    assert rows["b.csv", "closed_loop"]["rmse"] == 4e-4
    assert rows["b.csv", "closed_loop"]["over_noise"] == pytest.approx(2.0)
    assert rows["b.csv", "as_fitted"]["over_noise"] == 1.1
    assert joint["verdict"] == (
        "Of the runs that no fit saw, the worst: "
        "in closed loop it misses b.csv by 0.0004 rad, 2 times the sensor's noise; "
        "simulated freely it misses b.csv by 0.0005 rad, 2.5 times the sensor's noise; "
        "it misses the torque of b.csv by 3 %."
    )
    page = page_of(path)
    assert joint["verdict"].replace("'", "&#39;") in page
    assert "SYNTHETIC DATA" in page
    assert "a &lt;test&gt;" in page
    description = fmpy.read_model_description(str(path)).description
    assert "identified from a <test> (SYNTHETIC data)" in description
    assert "first guess" not in description


def test_a_stated_value_takes_its_draws_away_and_those_it_is_ordered_with(tmp_path: Path):
    start = write_ssv(tmp_path / "p.ssv", {"joint4.friction.Fs": 0.01}, {"joint4.friction.Fs": "N m"})
    path = export_joint(results(tmp_path), 4, tmp_path / "x.fmu", "native", start, folder=tmp_path).path
    assert set(draws_of(path)[0]) == {"joint4.inertia", "joint4.spring.Ks"}
    assert "come from elsewhere" in json_of(path, "verification.json")["draws"]["source"]


@pytest.mark.parametrize(("largest", "unit"), [(None, "mN.m"), (0.4, "mN.m"), (5.0, None)])
def test_an_exported_joint_shows_torques_in_the_unit_of_its_drive(
    tmp_path: Path, largest: float | None, unit: str | None
):
    data = results(tmp_path)
    if largest is not None:
        data["configurations"][0]["largest_torque_Nm"] = largest
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    by_name = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    assert by_name["joint4.torque"].displayUnit == unit


def test_results_without_draws_say_why(tmp_path: Path):
    data = results(tmp_path)
    path = export_joint(data, 4, tmp_path / "x.fmu", "native").path
    assert draws_of(path) == []
    assert "does not lie beside" in page_of(path)
    del data["draws"]
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    assert "haptid identify makes them" in page_of(path)


def test_draws_of_other_results_are_refused_in_one_line(tmp_path: Path):
    data = results(tmp_path)
    with (tmp_path / "draws" / "joint4.csv").open("a") as stream:
        stream.write("200,1,1,1,1\n")
    with pytest.raises(InputError, match=r"joint4\.csv: expected the digest .*, got content of the digest") as caught:
        export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path)
    assert "\n" not in str(caught.value)


def posterior(folder: Path, data: str) -> None:
    """Write a posterior of joint 4 beside the results."""
    names = ["joint4.spring.Ks", "joint4.actuator.Kp", "joint5.spring.Ks"]
    values = np.column_stack([np.linspace(0.01, 0.02, 500), np.ones(500), np.linspace(1, 2, 500)])
    text = draws_text(names, values)
    (folder / "parameters_posterior.csv").write_text(text)
    told = {
        "mean": 0.015,
        "std": 0.003,
        "median": 0.0149,
        "intervals": {"0.5": [0.012, 0.017], "0.95": [0.0102, 0.0198]},
    }
    joint = {
        "joint": 4, "data": data, "sound": True, "parameters": {"Ks": told},
        "correlation": {"ids": ["Ks"], "matrix": [[1.0]]},
    }  # fmt: skip
    content = {"schema": "posterior/1", "seed": 3, "draws": digest_of(text.encode()), "joints": [joint]}
    (folder / "posterior.json").write_text(json.dumps(content))


def test_a_posterior_of_the_same_data_is_preferred(tmp_path: Path):
    data = results(tmp_path)
    posterior(tmp_path, "0123")
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    assert "posterior that haptid posterior sampled" in json_of(path, "verification.json")["draws"]["source"]
    assert len(draws_of(path)) == 200
    assert set(draws_of(path)[0]) == {"joint4.spring.Ks"}
    (row,) = [row for row in table_of(path, "parameters.csv") if row["name"] == "joint4.spring.Ks"]
    told = [float(row[key]) for key in ("mean", "std", "q0.025", "q0.25", "q0.5", "q0.75", "q0.975")]
    assert told == [0.015, 0.003, 0.0102, 0.012, 0.0149, 0.017, 0.0198]


@pytest.mark.parametrize("content", ["other data", "{", '{"schema": "posterior/1", "joints": [{"joint": 4}]}'])
def test_another_posterior_is_not_taken(content: str, tmp_path: Path):
    data = results(tmp_path)
    posterior(tmp_path, "4567")
    if content != "other data":
        (tmp_path / "posterior.json").write_text(content)
    path = export_joint(data, 4, tmp_path / "x.fmu", "native", folder=tmp_path).path
    assert json_of(path, "verification.json")["draws"] == {"count": 200, "source": "a test", "seed": 7}
