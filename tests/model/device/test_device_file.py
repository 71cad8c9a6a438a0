"""Device files: what comes with the package loads; what is wrong is named by file and key."""

import copy
import tomllib
from pathlib import Path

import pytest

from haptid.model.device.reader import builtin_devices, load_device, parse_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.support.errors import InputError

DEVICES = Path(__file__).parents[3] / "model" / "device" / "built_in"


def table(name="freedom6s"):
    return tomllib.loads((DEVICES / f"{name}.toml").read_text())


@pytest.mark.parametrize("name", ["freedom6s", "single_joint", "double_pendulum", "arm6"])
def test_built_in_devices_load(name):
    assert name in builtin_devices()
    assert load_device(name).name == name
    assert load_device(f"{name}.toml").digest == load_device(name).digest


def test_urdf_and_toml_are_the_same_arm():
    urdf, toml = load_device("arm6.urdf"), load_device("arm6")
    assert urdf.joints == toml.joints
    for ours, theirs in zip(toml.links, urdf.links, strict=True):
        assert ours.moved_by == theirs.moved_by
        assert ours.parent == theirs.parent
        assert ours.rpy == pytest.approx(theirs.rpy, abs=1e-15)
        assert ours.origin == pytest.approx(theirs.origin)
        assert ours.inertial.initial == pytest.approx(theirs.inertial.initial, abs=1e-15)


def test_every_assumption_of_the_freedom6s_is_labelled():
    assert all("assumed" in line or "added" in line for line in load_device("freedom6s").assumptions)


def test_path_is_looked_for_beside_the_campaign(tmp_path):
    (tmp_path / "mine.toml").write_text((DEVICES / "single_joint.toml").read_text())
    assert load_device("mine.toml", tmp_path).name == "single_joint"


def wrong(path, value):
    def change(data):
        *stem, last = path
        for key in stem:
            data = data[key]
        if value is None:
            del data[last]
        else:
            data[last] = value

    return change


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (wrong(["links", 1, "mass"], "heavy"), "links[1].mass"),
        (wrong(["links", 1, "mass"], -0.25), "links[1].mass"),
        (wrong(["links", 0, "colour"], "red"), "links[0].colour"),
        (wrong(["links", 4, "parent"], "9"), "links[4].parent"),
        (wrong(["links", 4, "name"], "2"), "links[4].name"),
        (wrong(["links", 3, "moved_by"], {"2": 0.5}), "links[3].moved_by.2"),
        (wrong(["links", 3, "moved_by"], {"9": 1}), "links[3].moved_by.9"),
        (wrong(["links", 0, "axis"], [0, 0, 0]), "links[0].axis"),
        (wrong(["links", 0, "inertia", "I33"], 5e-2), "links[0].inertia"),
        (wrong(["links", 0, "moved_by"], None), "links[0].moved_by"),
        (wrong(["joints", 2, "transmission"], "chain"), "joints[2].transmission"),
        (wrong(["joints", 2, "position_limits"], [1, -1]), "joints[2].position_limits"),
        (wrong(["joints", 2, "parameters", "Ks"], {"initial": 2.0, "upper": 1.0}), "joints[2].parameters.Ks"),
        (wrong(["joints", 2, "parameters", "sigma9"], 1.0), "joints[2].parameters.sigma9"),
        (wrong(["gravity"], [0, -9.81]), "gravity"),
        (wrong(["control_point", "link"], "hand"), "control_point.link"),
        (wrong(["title"], None), "top level"),
    ],
)
def test_errors_name_the_key(change, named):
    data = copy.deepcopy(table())
    change(data)
    with pytest.raises(InputError) as caught:
        parse_device(data, "mine.toml")
    assert str(caught.value).startswith(f"mine.toml: {named}:")
    assert "expected" in str(caught.value)


PENDULUM = (DEVICES / "double_pendulum.toml").read_text()
FS = "Fs = { initial = 0.16, lower = 0.01, upper = 1.0 }"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "moved_by = { 0 = 1 }",
            "moved_by = { 0 = 1e300 }",
            "line 71: links[0].moved_by.0: expected a number from -6 ",
        ),
        ("ratios = { 0 = 6 }", f"ratios = {{ {'9' * 5000} = 1 }}", "expected a joint's number and its coefficient"),
        ("ratios = { 0 = 6 }", "ratios = { shoulder = 6 }", "line 60: motors[0].ratios.shoulder: expected a joint's"),
        ("ratios = { 0 = 6 }", "ratios = { 0 = 1e300 }", "line 60: motors[0].ratios.0: expected a number from -1e+06"),
        ("origin = [0.0, 0.0, -0.3]", "origin = [0, 0, -1e300]", "line 80: links[1].origin[2]: expected a number"),
        ("origin = [0.0, 0.0, -0.3]", "origin = [0, 0, 1e20]", "line 80: links[1].origin[2]: expected a number"),
        ("axis = [0, 1, 0]", "axis = [0, 1e300, 0]", "links[0].axis[1]: expected a number"),
        ("-9.81]", "-9.81e300]", "line 4: gravity[2]: expected a number from -1000 to 1000 m/s^2"),
        (FS, "Fs = { initial = 1e300 }", "line 39: joints[0].parameters.Fs: expected initial from 1e-10 to 1e+06"),
        (FS, "Fs = -1", "line 39: joints[0].parameters.Fs: expected initial from 1e-10"),
        (FS, "Fs = { fixed = 0.001 }", "expected Fs >= Fc (stiction, Coulomb friction), got Fs = 0.001, Fc = 0.146"),
        (FS, "Fs = { initial = 1, fixed = 2 }", "got { initial, fixed }; keep one form"),
        (FS, "Fs = { initial = 1, uper = 2 }", "got { initial, uper }; did you mean upper?"),
        ("Kp = { fixed = 1.0 }", "Kp = { fixed = 0.0 }", "line 32: joints[0].parameters.Kp"),
        ("inertia = 7.66e-5", "inertia = -1", "line 59: motors[0].inertia: expected a number from 1e-15"),
        ("mass = 0.559", "mass = 1e-300", "line 72: links[0].mass: expected a number from 1e-09"),
        (
            "mass = 0.559",
            "mass = { initial = 0.559, std = 1e-300 }",
            "links[0].mass.std: expected a standard deviation",
        ),
        ("[-6.5, 6.5]", "[-1e300, 1e300]", "line 29: joints[0].position_limits[0]: expected a number from -1e+06"),
        ("mass = 0.3", "mass = 1e300", "line 22: uncertainty.mass: expected a number from 1e-09"),
        ("torque_limit = 6.0", "torque_limit = 1e300", "line 30: joints[0].torque_limit: expected a number from 1e-09"),
        ("torque_limit = 6.0", "torque_limt = 6.0", "line 30: joints[0].torque_limt: expected a known key, got"),
        ("torque_limit = 6.0", "torque_limt = 6.0", "did you mean torque_limit?"),
        (
            "torque_limit = 6.0",
            'transmission = "tendn"',
            "expected one of direct, tendon, got 'tendn'; did you mean tendon",
        ),
        ('"double_pendulum"', '"double pendulum"', "line 2: name: expected a name of the letters a-z, digits and _"),
        ('title = "DFKI', 'titel = "DFKI', "is 'titel' a misspelling of it?"),
    ],
)
def test_what_no_device_can_have_is_told_with_its_line(tmp_path, old, new, words):
    assert old in PENDULUM
    (tmp_path / "mine.toml").write_text(PENDULUM.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_device(tmp_path / "mine.toml")
    assert words in str(caught.value)
    assert str(caught.value).isprintable()


def test_a_joint_that_moves_no_mass_is_refused():
    data = table("double_pendulum")
    data["links"] = [{"name": "1", "moved_by": {"0": 1, "1": 1}}]
    del data["control_point"], data["motors"]
    with pytest.raises(InputError, match=r"joints\[0\]: expected a joint that moves a mass"):
        parse_device(data, "mine.toml")
    data["motors"] = [{"name": "m", "inertia": 1e-4, "ratios": {"0": 6, "1": 1}}]
    assert parse_device(data, "mine.toml").massive == ()


def test_joint_that_moves_nothing_is_refused():
    data = table("double_pendulum")
    data["joints"].append({"name": "idle"})
    with pytest.raises(InputError, match=r"joints\[2\]"):
        parse_device(data, "mine.toml")


def test_unknown_device_lists_the_known_ones():
    with pytest.raises(InputError, match="freedom6s"):
        load_device("freedom7s")


def test_broken_toml_and_urdf_are_named(tmp_path):
    for name, text in (
        ("a.toml", "name = "),
        ("b.urdf", "<robot><link"),
        ("c.urdf", "<robot name='x'><link name='a'/></robot>"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match=name):
            load_device(tmp_path / name)


def test_mimicking_joint_becomes_a_passive_link(tmp_path):
    text = (
        (DEVICES / "arm6.urdf")
        .read_text()
        .replace('<axis xyz="0.6 0 0.8"/>', '<axis xyz="0.6 0 0.8"/><mimic joint="nod" multiplier="-1" offset="0"/>')
    )
    (tmp_path / "linked.urdf").write_text(text)
    device = load_device(tmp_path / "linked.urdf")
    assert len(device.joints) == 5
    assert dict(device.link("flange").moved_by) == {4: -1}


def test_a_lower_bound_of_zero_is_taken_on_what_is_positive(tmp_path):
    (tmp_path / "mine.toml").write_text(PENDULUM.replace(FS, "Fs = { initial = 0.2, lower = 0 }", 1))
    equations = configuration_equations(load_device(tmp_path / "mine.toml"), (0,))
    assert next(q for q in equations.parameters if q.id == "Fs").lower == 1e-7
