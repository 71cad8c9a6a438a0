"""A URDF that a parser would repair in silence, or that is no tree of links, is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from haptid.model.device.reader import load_device
from haptid.support.errors import InputError

GOOD = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><mass value="1.0"/><origin xyz="0.1 0 0"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="2" velocity="3"/></joint>
</robot>
"""


def load(folder: Path, text: str):
    path = folder / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return load_device(path)


def test_the_good_one_is_read(tmp_path: Path):
    device = load(tmp_path, GOOD)
    assert [joint.name for joint in device.joints] == ["one"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<limit lower", "<limit lower=", "arm.urdf, line 6: expected well-formed XML"),
        ("</joint>", "", "arm.urdf, line 7: expected well-formed XML"),
        ('effort="2"', 'effort="nan"', "joint one, limit effort: expected 1 finite number below 1e+12, got 'nan'"),
        ('lower="-1"', 'lower="2"', "joint one: expected limits with lower <= upper, got lower 2.0, upper 1.0"),
        ('<child link="upper"/>', '<child link="uper"/>', "did you mean upper?"),
        ('<mass value="1.0"/>', '<mass value="inf"/>', "link upper, mass value: expected 1 finite number"),
        ("<inertia ixx", "inertia ixx", "link upper: expected mass and inertia in <inertial>, got no inertia"),
        ('ixx="0.01"', 'ixx="${m}"', "run the file through xacro first"),
        ('xyz="0 0 1"', 'xyz="0 0 0"', "joint one: expected an axis with a direction"),
        ('type="revolute"', 'type="revolut"', "did you mean revolute?"),
        ('<robot name="arm">', '<!DOCTYPE a [<!ENTITY b "c">]><robot name="arm">', "XML without a document type"),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', "expected every link once, got 'base' twice"),
        ('<link name="base"/>', '<link name="base"/><link name="spare"/>', "one link that no joint carries"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, old: str, new: str, words: str):
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        load(tmp_path, GOOD.replace(old, new))
    assert words in str(caught.value)
    assert len(str(caught.value)) <= 300
