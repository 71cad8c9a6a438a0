"""identification.json and discrepancy JSON of strangers: one line, nothing written, no file elsewhere read."""

from __future__ import annotations

import json
import shutil

import pytest
from click.testing import CliRunner

from haptid.fmu_build.exchange.discrepancy_json import read_finding
from haptid.fmu_build.exchange.identification_json import inner_step_of, read_identification
from haptid.fmu_build.export import main as export
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.device.reader import load_device
from haptid.model.effects.registry import catalogue
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import LONGEST, InputError

PARAMETER = {"value": 1e-4, "std": None, "unit": "kg m^2", "status": "identified"}
FINDING = {
    "schema": "discrepancy/1", "joint": 4, "measured": False, "verdict": "named",
    "effects": [{"id": "cubic_spring", "parameters": {"k3": {"value": 0.03, "std": 0.001}}}],
    "refit": {"inertia": 1e-4, "k3": 0.03},
}  # fmt: skip


def content() -> dict:
    return {
        "schema": "identification/1", "device": "freedom6s", "campaign": "a test", "measured": False,
        "configurations": [{"free_joints": [4], "parameters": {"inertia": dict(PARAMETER)}}], "links": {},
    }  # fmt: skip


def refused(folder, data, *arguments):
    """Return the line with which the export refuses ``data``."""
    source, out = folder / "identification.json", folder / "x.fmu"
    source.write_text(data if isinstance(data, str) else json.dumps(data))
    before = sorted(folder.rglob("*"))
    done = CliRunner().invoke(export, ["--from", str(source), "--out", str(out), *map(str, arguments)])
    assert done.exit_code == 2, done.output
    (line,) = done.stderr.splitlines()
    assert len(line.removeprefix("error: ")) <= LONGEST
    assert sorted(folder.rglob("*")) == before
    return line


def changed(*path, to, data=None):
    """Return the content with one entry replaced, or removed where ``to`` is ...."""
    data = content() if data is None else json.loads(json.dumps(data))
    at = data
    for key in path[:-1]:
        at = at[key]
    if to is ...:
        del at[path[-1]]
    else:
        at[path[-1]] = to
    return data


K3 = ("effects", 0, "parameters", "k3")
ONE = ("configurations", 0)
WRONG = [
    (
        changed("schema", to="identification/2"),
        "schema: expected an identification.json of schema 'identification/1', got 'identification/2'",
    ),
    (changed("schema", to=...), "expected an identification.json with the key 'schema'"),
    (changed("configurations", to={}), "configurations: expected a list"),
    (changed("configurations", to=[7]), "configurations[0]: expected a table { … }, got 7"),
    (changed("device", to=7), "device: expected a text, got 7"),
    (changed("device", to="../elsewhere.toml"), "--device ../elsewhere.toml if it is yours"),
    (changed("device", to="/etc/passwd"), "--device /etc/passwd if it is yours"),
    (
        changed("device_file", to="/etc/passwd", data=changed("device", to="../elsewhere.toml")),
        "--device ../elsewhere.toml if it is yours",
    ),
    (changed("device_file", to=7), "device_file: expected a text, got 7"),
    (changed("device", to="freedom7s"), "a built-in name or a file"),
    (changed("device", to="a\0b"), "device: expected"),
    (changed("device", to="x" * 5000), "device: expected"),
    (changed("device", to="x" * 500), "device: expected"),
    (changed(*ONE, "free_joints", to=["4"]), "configurations[0].free_joints[0]: expected a whole number, got '4'"),
    (changed(*ONE, "free_joints", to=[4, 4]), "every entry once"),
    (changed(*ONE, "free_joints", to=[]), "free_joints: expected"),
    (changed(*ONE, "parameters", "inertia", "value", to="1e-4"), "inertia.value: expected a number, got '1e-4'"),
    (changed(*ONE, "parameters", "inertia", "value", to=...), "inertia: expected the key 'value'"),
    (changed(*ONE, "parameters", "inertia", to={"vlaue": 1.0}), "is 'vlaue' a misspelling of it?"),
    (changed(*ONE, "parameters", "Kss", to={"value": 1.0}), "got 'Kss'; did you mean Ks"),
    (changed(*ONE, "parameters", "inertia", "status", to="known"), "status: expected one of identified"),
    (changed("links", to={"6": {"m": {"value": None}}}), "links.6.m.value: expected a number"),
    (changed("whole", to={"a": True}), "whole.a: expected a number, got True"),
    (changed("configurations", to=2 * content()["configurations"]), "joint 4 twice"),
    ('{"schema": "identification/1",', "cut off"),
    *(
        (
            changed(*ONE, "parameters", "inertia", "value", to=x),
            "parameters.inertia.value: expected a number from 1e-10",
        )
        for x in (-1.0, 0.0, 0, 1e300)
    ),
    *(
        (changed(*ONE, "parameters", id, to={"value": x}), f"parameters.{id}.value: expected a number from")
        for id, x in (("Ks", 1e300), ("Ks", -1.0), ("vs", 0), ("Fc", -1.0), ("gravity_cos", 1e300))
    ),
    (changed(*ONE, "parameters", "Fc", to={"value": 5.0}), "expected Fs_4 >= Fc_4, got Fs_4 = "),
    (changed(*ONE, "parameters", to={"Fc": {"value": 2.0}, "Fs": {"value": 1.0}}), "expected Fs >= Fc, got Fs = 1"),
    (changed(*ONE, "parameters", "inertia", "unit", to="N m/deg"), "inertia.unit: expected the unit kg m^2"),
    (changed(*ONE, "parameters", "inertia", "unit", to="kg"), "inertia.unit: expected the unit kg m^2, got 'kg'"),
    (changed(*ONE, "parameters", "inertia", "lower", to=5), "parameters.inertia.value: expected a value within"),
    (
        changed(*ONE, "parameters", "Ks", to={"value": 0.0, "lower": 5, "upper": -5}),
        "parameters.Ks: expected lower <= upper, got lower 5, upper -5",
    ),
    (changed(*ONE, "locked_positions_rad", to=7), "configurations[0].locked_positions_rad: expected a list"),
    (
        changed(*ONE, "locked_positions_rad", to=[1e300]),
        "locked_positions_rad[0]: expected a number of 1000000.0 or less",
    ),
    (changed(*ONE, "free_joints", to=[9]), "configurations[0].free_joints: expected joints of freedom6s, got joint 9"),
    (changed(*ONE, "inner_step_s", to=0), "configurations[0].inner_step_s: expected a number of 1e-06 or more"),
    (changed(*ONE, "free_joints", to=[10**9]), "free_joints[0]: expected a number of 9999 or less"),
    (changed(*ONE, "free_joints", to=[4, 0]), "got 'inertia'; did you mean"),
    (changed("links", to={"66": {"m": {"value": 1.0}}}), "links: expected links and motors of the device, got '66'"),
    (
        changed("links", to={"6": {"mass": {"value": 1.0}}}),
        "links.6: expected parameters of a link or motor, got 'mass'",
    ),
    (changed("links", to={"6": {"m": {"value": -1e300}}}), "links.6.m.value: expected a number from 0"),
    (changed("links", to={"6": {"x": {"value": 1e15}}}), "links.6.x.value: expected a number from -1000 to 1000"),
    (changed("links", to={"6": {"m": {"value": 1.0, "unit": "g"}}}), "links.6.m.unit: expected the unit kg, got 'g'"),
    (changed("whole", to={"Ks_44": 0.1}), "whole: expected parameters of freedom6s, got 'Ks_44'; did you mean Ks_4"),
    (changed("whole", to={"vs_4": 0.0}), "whole.vs_4: expected a number from"),
    (
        '{"schema": "identification/1", "seed": ' + "9" * 5000 + "}",
        "seed: expected numbers of at most 64 bits, got a n",
    ),
]


@pytest.mark.parametrize(("data", "part"), WRONG)
def test_export_names_the_key_at_fault(data, part, tmp_path):
    assert part in refused(tmp_path, data)


@pytest.mark.parametrize(
    ("data", "part"),
    [
        (
            changed("schema", to="discrepancy/2", data=FINDING),
            "expected a discrepancy/joint<j>.json of schema 'discrepancy/1'",
        ),
        (changed("joint", to=None, data=FINDING), "joint: expected a whole number, got None"),
        (changed("joint", to=77, data=FINDING), "joints of freedom6s, got joint 77"),
        (changed("joint", to=3, data=FINDING), "a configuration with this joint alone"),
        (changed("verdict", to="unlisted", data=FINDING), "verdict: expected one of the verdicts"),
        (changed("verdict", to="perhaps", data=FINDING), "verdict: expected one of nothing_missing"),
        (changed("effects", to=[{"id": "cubic_sprin", "parameters": {}}], data=FINDING), "is 'cubic_spring' meant?"),
        (changed("effects", 0, "parameters", to=..., data=FINDING), "effects[0]: expected the key 'parameters'"),
        (changed("refit", to={"k3": "x"}, data=FINDING), "refit.k3: expected a number"),
        (changed("refit", to={}, data=FINDING), "joint4.json: refit: expected its inertia, identified and refitted"),
        (changed("refit", to=None, data=FINDING), "joint4.json: refit: expected its inertia, identified and refitted"),
        (changed("refit", to=..., data=FINDING), "joint4.json: refit: expected its inertia, identified and refitted"),
        (changed("refit", "inertia", to=-1e300, data=FINDING), "refit.inertia: expected a number from 1e-10"),
        (changed("refit", "Fc", to=-5, data=FINDING), "refit.Fc: expected a number from"),
        (changed("refit", "Fc", to=5, data=FINDING), "joint4.json: expected Fs_4 >= Fc_4"),
        (changed("refit", "k3", to=1e300, data=FINDING), "refit.k3: expected a number from"),
        (
            changed("refit", "k4", to=1.0, data=FINDING),
            "refit: expected parameters of the joint and its effects, got 'k4'",
        ),
        (
            changed("effects", to=2 * FINDING["effects"], data=FINDING),
            "effects: expected every effect once, got cubic_s",
        ),
        (
            changed("refit", "k3", to=..., data=FINDING),
            "refit: expected the key 'k3', got inertia; cubic_spring has no v",
        ),
        (changed(*K3, "value", to=-1e300, data=FINDING), "effects[0].parameters.k3.value: expected a number from"),
        (changed(*K3, "unit", to="N m", data=FINDING), "parameters.k3.unit: expected the unit N m/rad^3"),
        (changed(*K3[:-1], to={"k4": {"value": 1}}, data=FINDING), "expected parameters of cubic_spring, got 'k4'"),
        (changed("joint", to=10**9, data=FINDING), "joint: expected a number of 9999 or less"),
        (changed("effects", 0, "stability", to=2, data=FINDING), "stability: expected a number of 1 or less"),
    ],
)
def test_export_names_the_key_of_a_finding(data, part, tmp_path):
    path = tmp_path / "joint4.json"
    path.write_text(json.dumps(data))
    assert part in refused(tmp_path, content(), "--with", path)


@pytest.mark.parametrize(
    ("parameters", "missing"), [({"Ks": {"value": 0.01}}, "inertia"), ({"inertia": PARAMETER}, "Kp")]
)
def test_one_joint_needs_all_its_parameters(parameters, missing, tmp_path):
    data = changed(*ONE, "parameters", to=parameters)
    assert f"joint 4: expected the key '{missing}'" in refused(tmp_path, data, "--joints", "4")


def test_fields_that_were_added_to_the_results_are_read(tmp_path):
    entry = {
        "residual": "torque", "why": "a controller swept it", "floor": {"value": 0.01, "unit": "N m"},
        "baseline": {"parameters": {"Fv": {"value": 1e-3, "std": 1e-5, "unit": "N m s/rad"}}},
        "runs": [{"file": "a.csv", "figures": {"model": {"free_rmse": 0.1, "horizon_rmse": {"0.1": 0.01}}}}],
        "locked_positions_rad": [0, 0, 0, 0, 0, 0],
    }  # fmt: skip
    source, data = tmp_path / "identification.json", content()
    data["configurations"][0] |= entry
    other = data["configurations"][0] | {"locked_positions_rad": [0, 0.5, 0, 0, 0, 0]}
    source.write_text(json.dumps(data | {"configurations": [*data["configurations"], other]}))
    assert read_identification(source)["configurations"][0]["residual"] == "torque"
    told = {"verdict": "partly_named", "residual": "torque", "gap": {"sealed": None, "validate": {"black_box": 0.1}}}
    source.write_text(json.dumps(changed("effects", 0, "stability", to=0.9, data=FINDING) | told))
    assert [e.id for e in read_finding(source, catalogue()).effects] == ["cubic_spring"]


def test_a_joint_keeps_the_inner_step_of_its_fit_and_the_device_the_shortest():
    usual = THRESHOLDS.inner_step_s
    data = changed(*ONE, "inner_step_s", to=usual / 4)
    data["configurations"].append({"free_joints": [3], "parameters": {}})
    assert inner_step_of(data, 4) == usual / 4
    assert inner_step_of(data, 3) == usual
    assert inner_step_of(data) == usual / 4
    assert inner_step_of(content()) == usual
    # The joints' friction may be stiffer in the motion of all than in that of each.
    data["verification"] = {"runs": [], "inner_step_s": usual / 64}
    assert (inner_step_of(data), inner_step_of(data, 4)) == (usual / 64, usual / 4)


def test_a_finding_under_another_friction_law_is_refused_with_what_to_do(tmp_path):
    law = {"id": "friction_law", "variant": "coulomb", "parameters": {}, "evidence": 100.0}
    source = tmp_path / "joint4.json"
    source.write_text(json.dumps({**FINDING, "effects": [law]}))
    with pytest.raises(InputError, match=r'got coulomb; write friction = "coulomb" into \[joint\.\d\]'):
        read_finding(source, catalogue())


def test_a_link_out_of_the_folder_is_no_file_of_the_results(tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    (tmp_path / "machine.toml").write_text('name = "secret"')
    (folder / "machine.toml").symlink_to(tmp_path / "machine.toml")
    assert "--device machine.toml if it is yours" in refused(folder, changed("device", to="machine.toml"))


def test_a_device_beside_the_results_or_named_by_the_user_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())
    from importlib import resources  # noqa: PLC0415 # this test alone

    folder = tmp_path / "results"
    folder.mkdir()
    machine = tmp_path / "machine.toml"
    shutil.copy(str(resources.files("haptid.model.device.built_in") / "double_pendulum.toml"), machine)
    data = changed("device", to="../machine.toml")
    data["configurations"] = []
    source = folder / "identification.json"
    source.write_text(json.dumps(data))
    call = ["--from", str(source), "--out", str(folder / "x.fmu"), "--kind", "native"]
    done = CliRunner().invoke(export, [*call, "--device", str(machine)])
    assert done.exit_code == 0, done.output
    (folder / "device").mkdir()
    for named in ({"device": "machine.toml"}, {"device_file": "device/machine.toml"}):
        shutil.copy(machine, folder / next(iter(named.values())))
        source.write_text(json.dumps(data | named))
        done = CliRunner().invoke(export, call)
        assert done.exit_code == 0, done.output
        assert load_device(machine).title in done.output
        (folder / next(iter(named.values()))).unlink()
