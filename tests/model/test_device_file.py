"""Device files: what comes with the package loads; what is wrong is named by file and key."""

import copy
import tomllib
from pathlib import Path

import pytest

from haptid.model.device.reader import builtin_devices, load_device, parse_device
from haptid.support.errors import InputError

DEVICES = Path(__file__).parents[2] / "model" / "device" / "built_in"


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
        (wrong(["links", 0, "colour"], "red"), "links[0]"),
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
