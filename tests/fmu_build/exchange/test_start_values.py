"""A parameter set (SSV) whose values an exported FMU starts from."""

from __future__ import annotations

import json

import fmpy
import pytest
from click.testing import CliRunner

from haptid.fmu_build.exchange.identification_json import Identified
from haptid.fmu_build.exchange.possible import check_order, with_pairs_in_order
from haptid.fmu_build.exchange.ssv import ssv_bytes
from haptid.fmu_build.exchange.ssv_reader import read_ssv
from haptid.fmu_build.exchange.start_values import with_start_values
from haptid.fmu_build.export import main as export
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import LONGEST, InputError
from tests.fmu_build.building.test_commands import identification
from tests.fmu_build.ssv_cases import GOOD, STATE, VALUES


def exported(folder, text):
    source, values, out = folder / "identification.json", folder / "parameters.ssv", folder / "x.fmu"
    source.write_text(json.dumps(identification()))
    values.write_text(text)
    call = ["--from", str(source), "--values", str(values), "--out", str(out), "--kind", "native", "--joints", "4"]
    return CliRunner().invoke(export, call), out


def test_an_exported_fmu_starts_from_the_values(tmp_path, monkeypatch):
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())
    done, out = exported(tmp_path, GOOD)
    assert done.exit_code == 0, done.output
    start = {v.name: v.start for v in fmpy.read_model_description(str(out)).modelVariables}
    assert {name: float(start[name]) for name in VALUES} == VALUES
    assert float(start["joint4.inertia"]) == 1.3e-4


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("joint4.spring.Ks", "joint4.spring.Kss", "got 'joint4.spring.Kss'; did you mean joint4.spring.Ks"),
        (
            "joint4.friction.vs",
            "joint4.spring.Ks",
            "expected every parameter once, got 'joint4.spring.Ks' again (line 4)",
        ),
        ('value="0.02"', 'value="nan"', "line 5: expected a finite number as value, got 'nan'"),
        ('value="0.02"', 'value="1e999"', "expected a finite number as value"),
        ('value="0.02"', 'value="0,02"', "got '0,02'; write a decimal point"),
        ('value="0.02"', 'value="-1"', "line 4: joint4.spring.Ks: expected a number from 0"),
        ('value="0.1"', 'value="0"', "joint4.friction.vs: expected a number from"),
        ('value="0.3"', 'value="1e300"', f"{STATE}: expected a number from"),
        ('value="0.02" unit="N m/rad"', 'value="0.02" unit="N m/deg"', "expected the unit N m/rad, got 'N m/deg'"),
        ('value="0.02" unit="N m/rad"', 'value="0.02" unit="furlong"', "expected a unit that is known, got 'furlong'"),
        ('rad="-1"', 'rad="-1" factor="57.3"', "expected the unit N m/rad"),
        ("ssv:Real", "ssv:Integer", "expected an element in <Parameter>: <Real>, <Annotations>, got <Integer>"),
        ('value="0.02"', 'vale="0.02"', "expected attributes of <Real>, got 'vale'; did you mean value?"),
        ('version="1.0" name', 'version="2.0" name', "expected a <ParameterSet version=\"1.0\">, got '2.0'"),
        (
            "<ssv:ParameterSet",
            '<!DOCTYPE a [<!ENTITY b "c">]>\n<ssv:ParameterSet',
            "expected XML without document type",
        ),
        ("SystemStructureParameterValues", "Other", "of the namespace"),
        ("</ssv:ParameterSet>", "", "expected XML, a parameter set (.ssv), got"),
        ("<ssv:Units>", "<ssv:Unit>", "expected an element in <ParameterSet>"),
    ],
)
def test_other_files_are_refused_with_their_line(old, new, part, tmp_path):
    assert old in GOOD
    done, out = exported(tmp_path, GOOD.replace(old, new))
    assert done.exit_code == 2, done.output
    (line,) = done.stderr.splitlines()
    assert "parameters.ssv, line " in line
    assert part in line
    assert len(line.removeprefix("error: ")) <= LONGEST
    assert not out.exists()


def test_stiction_stays_above_coulomb_friction(tmp_path):
    done, _ = exported(tmp_path, ssv_bytes({"joint4.friction.Fc": 1.0}, {"joint4.friction.Fc": "N m"}).decode())
    assert done.exit_code == 2
    assert "expected Fs >= Fc" in done.stderr


@pytest.mark.parametrize("hair", [1e-15, 3e-6])
def test_stiction_at_coulomb_friction_is_in_order_to_the_last_bit(hair):
    equations, level = joint_equations(4), 0.0548853
    found = Identified(values={"Fs": level * (1 - hair), "Fc": level}, provenance={})
    assert with_start_values(found, None, equations).values == {"Fs": level, "Fc": level}
    check_order("Fs", "Fc", found.values, {}, "a.json")


def test_annotations_are_passed_over_and_a_unit_may_be_left_open(tmp_path):
    text = GOOD.replace(' unit="rad/s"', "").replace(
        "<ssv:Parameters>", '<ssc:Annotations><a:b xmlns:a="c"><a:Parameter/></a:b></ssc:Annotations><ssv:Parameters>'
    )
    (tmp_path / "a.ssv").write_text(text)
    assert read_ssv(tmp_path / "a.ssv")["joint4.friction.vs"].unit is None
    with pytest.raises(InputError, match="No such file"):
        read_ssv(tmp_path / "b.ssv")


def test_a_parameter_set_without_values_is_refused(tmp_path):
    done, out = exported(tmp_path, ssv_bytes({}, {}).decode())
    assert done.exit_code == 2
    assert done.output.endswith("parameters.ssv: expected values of parameters or states, got none\n")
    assert not out.exists()


def test_a_fit_that_passed_its_constraints_far_gives_an_fmu_all_the_same():
    """A fit to a torque of another joint ended `haptid identify` after its fits: expected Fs >= Fc."""
    equations = joint_equations(4)
    found = Identified(values={"Fs": 549.3, "Fc": 986.2}, provenance={})
    assert with_start_values(found, None, equations).values == {"Fs": 986.2, "Fc": 986.2}
    with pytest.raises(InputError, match=r"expected Fs >= Fc, got Fs = 549\.3, Fc = 986\.2"):
        with_pairs_in_order(found.values, equations, "values")
