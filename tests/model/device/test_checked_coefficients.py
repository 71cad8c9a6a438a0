"""Inertia and gravity that links give a joint are checked; defaults of friction keep their order."""

import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.model.device.device_table import parse_device
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.plan import main
from haptid.support.errors import InputError

BUILT_IN = Path(__file__).parents[3] / "model" / "device" / "built_in"
PENDULUM = (BUILT_IN / "double_pendulum.toml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = 0.559", "mass = 1e9", "joint 0 (shoulder): expected inertia from 1e-10 to 100000 kg m^2"),
        ("centroid = [0.0, 0.0, -0.3]", "centroid = [0.0, 0.0, -1e4]", "got 5.59e+07; check masses, lengths"),
        ("ratios = { 0 = 6 }", "ratios = { 0 = 1e6 }", "joint 0 (shoulder): expected inertia"),
    ],
)
def test_products_that_no_joint_has_are_refused_before_any_work(tmp_path, old, new, words):
    assert old in PENDULUM
    (tmp_path / "heavy.toml").write_text(PENDULUM.replace(old, new, 1))
    result = CliRunner().invoke(main, [str(tmp_path / "heavy.toml"), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert words in result.stderr
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="expected inertia"):
        configuration_equations(load_device(tmp_path / "heavy.toml"), (0,))


def test_a_point_on_the_axis_gives_no_inertia():
    table = tomllib.loads((BUILT_IN / "single_joint.toml").read_text())
    table["links"][0] |= {"inertia": dict.fromkeys(("I11", "I22", "I33"), 0.0)}
    with pytest.raises(InputError, match="expected a joint with inertia"):
        configuration_equations(parse_device(table, "point.toml"), (0,))


@pytest.mark.parametrize(("given", "other"), [({"Fc": 0.5}, "Fs"), ({"Fs": {"fixed": 1e-4}}, "Fc")])
def test_friction_that_is_not_given_keeps_the_order(given, other):
    table = tomllib.loads((BUILT_IN / "single_joint.toml").read_text())
    table["joints"][0]["parameters"] |= given
    quantities = {q.id: q for q in configuration_equations(parse_device(table, "a.toml"), (0,)).parameters}
    assert quantities["Fs"].initial >= quantities["Fc"].initial
    assert other not in given


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("gravity = [0.0, 0.0, -9.81]", "gravity = [0, 0, 0]"),
        ("-9.81]", "-5e-324]"),
        ("position_limits = [-6.5, 6.5]", "position_limits = [-inf, inf]"),
        ("position_limits = [-6.5, 6.5]", "position_limits = [0.1, inf]"),
        ("inertia = { I11 = 0.00319, I22 = 0.00319, I33 = 1e-4 }", "inertia = { I11 = 0, I22 = 0, I33 = 0 }"),
    ],
)
def test_what_is_zero_or_endless_is_planned(tmp_path, old, new):
    assert old in PENDULUM
    (tmp_path / "odd.toml").write_text(PENDULUM.replace(old, new, 1))
    options = ["--out", str(tmp_path / "out"), "--runs", "1", "--tests", "1", "--quiet"]
    result = CliRunner().invoke(main, [str(tmp_path / "odd.toml"), *options])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "out" / "locking_plan.json").is_file()
