"""The FMU of the whole device takes along what a search named in one joint."""

import json
from pathlib import Path

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner, Result

from haptid.fmu_build.exchange.discrepancy_json import by_joint, finding_of
from haptid.fmu_build.export import main as export
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.effects.registry import catalogue
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.support.errors import InputError
from tests.fmu_build.accuracy_cases import json_of, page_of
from tests.fmu_build.building.test_commands import identification
from tests.fmu_build.fmu_cases import DEVICE, STEP, Client, equations, torques

BASE = {q.id: q.initial for q in equations("joint4").parameters} | {"inertia": 1.5e-4, "Ks": 0.02}
COGGING = {"cogging_sin": 2e-3, "cogging_cos": -1e-3, "cogging_number": 7.0}
TENDON = {
    "tendon_compliance": 0.5, "tendon_rotor_share": 0.3, "tendon_damping_time": 0.01, "tendon_compliance_least": 1e-4,
}  # fmt: skip
CLOCK = {"clock_rate": 1e-3}


def finding(effects: dict[str, dict[str, float]], joint: int = 4, verdict: str = "named") -> dict:
    """Return the fields of a ``discrepancy/joint<j>.json`` that an export reads."""
    refit = dict(BASE)
    for own in effects.values():
        refit |= own
    named = [
        {"id": id, "variant": None, "parameters": {k: {"value": x, "std": 1e-5, "unit": ""} for k, x in own.items()}}
        for id, own in effects.items()
    ]
    kept = {"schema": "discrepancy/1", "joint": joint, "measured": False, "verdict": verdict, "effects": named}
    return {**kept, "refit": refit if effects else None}


@pytest.fixture(autouse=True)
def here_only(monkeypatch):
    """Binaries for this machine alone."""
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())


def exported(folder: Path, *contents: dict, kind: str = "native") -> tuple[Result, Path]:
    source, out = folder / "identification.json", folder / "whole.fmu"
    source.write_text(json.dumps(identification()))
    arguments = ["--from", str(source), "--out", str(out), "--kind", kind]
    for number, content in enumerate(contents):
        path = folder / f"finding{number}.json"
        path.write_text(json.dumps(content))
        arguments += ["--with", str(path)]
    return CliRunner().invoke(export, arguments), out


@pytest.mark.parametrize("kind", ["python", "native"])
def test_the_whole_device_moves_as_its_equations_with_the_effect_do(kind: str, tmp_path: Path):
    result, out = exported(tmp_path, finding({"cogging": COGGING, "tendon_elasticity": TENDON}), kind=kind)
    assert result.exit_code == 0, result.output
    assert "joint 4: cogging, tendon_elasticity; its inertia moved by +15 % in the refit" in result.stdout
    variables = {v.name: v for v in fmpy.read_model_description(str(out)).modelVariables}
    assert float(variables["joint4.spring.Ks"].start) == 0.02
    assert float(variables["joint4.cogging.cogging_sin"].start) == 2e-3
    assert float(variables["joint4.tested.inertia"].start) == 1.5e-4
    assert float(variables["link6.m"].start) == 0.11
    entries = catalogue()
    e = full_equations(DEVICE, {4: [entries["cogging"], entries["tendon_elasticity"]]})
    p = {q.id: q.initial for q in e.parameters} | {"link6_m": 0.11}
    p |= {f"{id}_4": value for id, value in (BASE | COGGING | TENDON).items() if f"{id}_4" in p}
    t = STEP * np.arange(81)
    expected = CompiledKernel.of(e).simulate(t, torques(e, t), np.array(list(p.values())), np.zeros(len(e.states)))
    got = Client(out).start().go().run(e, t, torques(e, t))
    np.testing.assert_array_equal(got, expected)
    plain = equations("freedom6s")
    without = CompiledKernel.of(plain).simulate(
        t, torques(plain, t), np.array([p[q.id] for q in plain.parameters]), np.zeros(18)
    )
    joint = [o.id for o in e.outputs].index("y4")
    assert np.abs(got - without)[:, joint].max() > 1e-3


def test_the_fmu_lists_the_effects_and_the_gap_that_they_close(tmp_path: Path):
    content = finding({"cogging": COGGING})
    content["effects"][0] |= {"evidence": 412.0, "stability": 0.9}
    content["gap"] = {"validate": {"before": 2e-3, "after": 2e-4, "noise": 1.9e-4, "closed": 0.994}}
    result, out = exported(tmp_path, content)
    assert result.exit_code == 0, result.output
    told = json_of(out, "effects.json")
    (effect,) = told["effects"]
    assert (effect["joint"], effect["id"], effect["stability"]) == (4, "cogging", 0.9)
    assert effect["parameters"]["cogging_sin"]["value"] == 2e-3
    assert effect["gap"] == content["gap"]
    assert told["searched"] == "joints searched: 4"
    page = page_of(out)
    assert "named in 90 % of bags of runs; the effects close 99.4 % of the gap on runs that no fit saw" in page
    assert "without the effects that were added" in page


def test_what_belongs_to_the_test_alone_stays_behind_and_is_told(tmp_path: Path):
    result, out = exported(tmp_path, finding({"clock_error": CLOCK, "cogging": COGGING}))
    assert result.exit_code == 0, result.output
    assert "joint 4: cogging;" in result.stdout
    assert "without clock_error: the clock of the recording, not of the device" in result.stdout
    names = {v.name for v in fmpy.read_model_description(str(out)).modelVariables}
    assert not [name for name in names if "clock" in name]
    left = "clock_error of joint 4 (the clock of the recording, not of the device)"
    assert (
        json_of(out, "effects.json")["searched"] == f"joints searched: 4; named there but not in the equations: {left}"
    )
    assert left in page_of(out)


def test_where_nothing_is_missing_the_whole_device_stays_as_it_is(tmp_path: Path):
    result, out = exported(tmp_path, finding({}, verdict="nothing_missing"))
    assert result.exit_code == 0, result.output
    assert "joint 4: nothing" in result.stdout
    variables = {v.name: v for v in fmpy.read_model_description(str(out)).modelVariables}
    assert float(variables["joint4.spring.Ks"].start) == 0.0123


@pytest.mark.parametrize(
    ("contents", "told"),
    [
        ([finding({"cogging": COGGING}, verdict="unlisted")], "got 'unlisted'"),
        ([{"schema": "identification/1"}], "expected a discrepancy/joint<j>.json"),
        ([finding({"cogging": COGGING}, joint=None)], "joint: expected a whole number, got None"),
        ([finding({"no_such_thing": {}})], "got 'no_such_thing'"),
        ([finding({"cogging": COGGING})] * 2, "expected one finding per joint"),
        ([finding({"cogging": COGGING}, joint=2)], "joint 2: expected a configuration with this joint alone"),
    ],
)
def test_other_files_are_refused_in_one_line(contents: list[dict], told: str, tmp_path: Path):
    result, out = exported(tmp_path, *contents)
    assert result.exit_code == 2
    assert told in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not out.exists()


def test_one_joint_alone_takes_nothing_along(tmp_path: Path):
    result, _ = exported(tmp_path, finding({"cogging": COGGING}))
    source = tmp_path / "identification.json"
    arguments = ["--from", str(source), "--out", str(tmp_path / "one.fmu"), "--joints", "4", "--with", str(source)]
    result = CliRunner().invoke(export, arguments)
    assert result.exit_code == 2
    assert "expected the whole device, got a joint alone" in result.stderr


@pytest.mark.parametrize(
    ("verdict", "fmu", "told"),
    [
        ("unlisted", None, "has the verdict 'unlisted', and haptid missing wrote no FMU of the joint with effects"),
        ("named", "fmu/joint4_cogging.fmu", "haptid missing has written the FMU of the joint with its effects: "),
    ],
)
def test_a_joint_alone_is_told_whether_an_fmu_with_its_effects_is_there(
    tmp_path: Path, verdict: str, fmu: str | None, told: str
):
    source, found = tmp_path / "identification.json", tmp_path / "discrepancy" / "joint4.json"
    source.write_text(json.dumps(identification()))
    found.parent.mkdir()
    found.write_text(json.dumps(finding({"cogging": COGGING}, verdict=verdict) | {"fmu": fmu}))
    arguments = ["--from", str(source), "--out", str(tmp_path / "one.fmu"), "--joints", "4", "--with", str(found)]
    result = CliRunner().invoke(export, arguments)
    assert result.exit_code == 2
    assert told in result.stderr
    assert fmu is None or str(tmp_path / fmu)[-30:] in result.stderr


def test_bounds_without_their_scale_hold_the_value_and_its_sign():
    found = finding_of(finding({"tendon_elasticity": TENDON}), "x", catalogue())
    rows = {q.id: q for q in found.effects[0].parameters}
    assert (rows["tendon_compliance"].lower, rows["tendon_compliance"].initial) == (0.0, 0.5)
    assert rows["tendon_rotor_share"].upper == 0.9
    assert by_joint([found]) == {4: found.effects}
    with pytest.raises(InputError, match="one finding per joint"):
        by_joint([found, found])


def test_a_finding_in_place_of_the_result_names_the_option_that_takes_it(tmp_path: Path):
    found = tmp_path / "joint4.json"
    found.write_text(json.dumps(finding({"cogging": COGGING}) | {"fmu": "fmu/joint4_cogging.fmu"}))
    result = CliRunner().invoke(export, ["--from", str(found), "--out", str(tmp_path / "x.fmu")])
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert "expected an identification.json, got a finding of haptid missing; --with takes its effects along" in line
