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
LIMIT = '<limit lower="-1" upper="1" effort="2" velocity="3"/>'
INERTIAL = GOOD[GOOD.index("<inertial>") : GOOD.index("</inertial>") + len("</inertial>")]
TWO = GOOD.replace(
    "</robot>",
    f"""<link name="l-1">{INERTIAL}</link><link name="l_1">{INERTIAL}</link>
  <joint name="two" type="revolute"><parent link="upper"/><child link="l-1"/><limit upper="1" effort="2"/></joint>
  <joint name="three" type="revolute"><parent link="l-1"/><child link="l_1"/><limit upper="1" effort="2"/></joint>
</robot>
""",
)


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
        ('lower="-1"', 'lower="2"', "joint one: expected limits with lower < upper, got lower 2.0, upper 1.0"),
        ('<child link="upper"/>', '<child link="uper"/>', "did you mean upper?"),
        ('<mass value="1.0"/>', '<mass value="inf"/>', "link upper, mass value: expected 1 finite number"),
        ("<inertia ixx", "inertia ixx", "link upper: expected mass and inertia in <inertial>, got no inertia"),
        ('ixx="0.01"', 'ixx="${m}"', "run the file through xacro first"),
        ('xyz="0 0 1"', 'xyz="0 0 0"', "joint one: expected an axis with a direction"),
        ('type="revolute"', 'type="revolut"', "did you mean revolute?"),
        ('<robot name="arm">', '<!DOCTYPE a [<!ENTITY b "c">]><robot name="arm">', "XML without a document type"),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', "expected every link once, got 'base' twice"),
        ('<link name="base"/>', '<link name="base"/><link name="spare"/>', "one link that no joint carries"),
        ("<limit ", "<limits ", "joint one: expected elements of a URDF, got <limits>; did you mean <limit>?"),
        ("<axis ", "<axes ", "joint one: expected elements of a URDF, got <axes>; did you mean <axis>?"),
        ("<axis xyz", "<axis xzy", "joint one, axis: expected attributes of <axis>, got 'xzy'; did you mean 'xyz'?"),
        ('<axis xyz="0 0 1"/>', "<axis/>", "joint one, axis: expected <axis> with xyz, got no xyz"),
        ("upper=", "uper=", "joint one, limit: expected attributes of <limit>, got 'uper'; did you mean 'upper'?"),
        ("effort", "efort", "did you mean 'effort'?"),
        ("effort", "Effort", "did you mean 'effort'?"),
        ('effort="2"', "", "joint one, limit effort: expected a number above 0, got none; state the largest torque"),
        ('effort="2"', 'effort="0"', "joint one, limit effort: expected a number above 0, got 0; state the largest"),
        (LIMIT, "", "joint one: expected a <limit> of a revolute joint, got none; URDF demands it"),
        ('lower="-1"', 'lower="1"', "expected limits with lower < upper, got lower 1.0, upper 1.0"),
        (LIMIT, LIMIT + LIMIT, "joint one: expected one <limit>, got 2"),
        (
            '<child link="upper"/>',
            '<child link="upper"/><child link="base"/>',
            "joint one: expected one <child>, got 2",
        ),
        (INERTIAL, INERTIAL + INERTIAL, "link upper: expected one <inertial>, got 2"),
        ('ixx="0.01"', "", "link upper, inertial, inertia: expected <inertia> with ixx, iyy, izz, ixy, ixz, iyz"),
        ('ixy="0"', "", "got no ixy"),
        ('<mass value="1.0"/>', "<mass/>", "link upper, inertial, mass: expected <mass> with value, got no value"),
        ('<mass value="1.0"/>', '<mass value="0"/>', "link upper: expected a mass for a link with inertia, got mass 0"),
        ('<mass value="1.0"/>', '<mass value="-1"/>', "link upper, mass value: expected a number from 1e-09"),
        ('<mass value="1.0"/>', '<mass value="1e11"/>', "link upper, mass value: expected a number from 1e-09"),
        ('ixx="0.01"', 'ixx="1.0"', "link upper, inertia: expected principal moments that satisfy"),
        (INERTIAL, "", "joint one: expected a joint that moves a mass, got none"),
        (LIMIT, LIMIT + '<dynamics damping="-3"/>', "joint one, dynamics damping: expected initial from 1e-11"),
        (LIMIT, LIMIT + '<dynamics friction="1e11"/>', "joint one, dynamics friction"),
        (
            '<child link="upper"/>',
            '<child link="base"/>',
            "joint one: expected a tree of links, got 'base' below itself",
        ),
        ('<parent link="base"/>', '<parent link="upper"/>', "joint one"),
        (LIMIT, LIMIT + '<mimic joint="two"/>', "joint one, mimic: expected a joint of this file, got 'two'"),
        (LIMIT, LIMIT + "<a>" * 5000 + "</a>" * 5000, "arm.urdf: expected at most 64 elements within each other"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, old: str, new: str, words: str):
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        load(tmp_path, GOOD.replace(old, new))
    assert words in str(caught.value)
    assert len(str(caught.value)) <= 300


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '"upper"/><child link="l-1"',
            '"l_1"/><child link="l-1"',
            "joint two: expected a tree of links, got 'l-1' below",
        ),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="tow"/>', "joint three, mimic: expected a joint of"),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="three"/>', "which is fixed or mimics another"),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="two" offset="1"/>', "put the offset into"),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="two" multiplier="0.5"/>', "0.5 times 'two'"),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="two" multiplier="0"/>', "a multiplier other than 0"),
        ('<child link="l_1"/>', '<child link="l_1"/><mimic joint="two" multiplier="1e9"/>', "joint three, mimic"),
        ('<child link="l_1"/>', '<child link="l_1"/><origin xyz="1e9 0 0"/>', "joint three, origin xyz: expected"),
    ],
)
def test_of_several_joints_the_one_at_fault_is_named(tmp_path: Path, old: str, new: str, words: str):
    assert old in TWO
    with pytest.raises(InputError) as caught:
        load(tmp_path, TWO.replace(old, new))
    assert words in str(caught.value)
    assert len(str(caught.value)) <= 300


def test_links_whose_names_differ_by_signs_stay_two(tmp_path: Path):
    assert [link.name for link in load(tmp_path, TWO).links] == ["upper", "l_1", "l_1_2"]


def test_a_link_may_be_called_base_below_the_root(tmp_path: Path):
    device = load(tmp_path, GOOD.replace('"base"', '"world"').replace('"upper"', '"base"'))
    assert [(link.name, link.parent) for link in device.links] == [("base_2", "base")]


def test_a_robot_without_a_name_has_that_of_its_file(tmp_path: Path):
    assert load(tmp_path, GOOD.replace(' name="arm"', "")).name == "arm"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("</joint>", "<calibration rising='0'/><safety_controller k_velocity='1'/><hardwareInterface/></joint>"),
        ("</link>", "<visual><origin xyz='0 0 0'/></visual><collision/><sensor/><contact/><self_collide/></link>"),
        ("</robot>", "<transmission/><gazebo reference='upper'><limits/></gazebo><material name='a'/></robot>"),
        (
            "</robot>",
            "<ros2_control/><sensor name='s'/><loop_joint/><!-- limit --><mujoco><compiler/></mujoco></robot>",
        ),
        ('velocity="3"', 'velocity="3" acceleration="5" jerk="7"'),
        ('velocity="3"', ""),
        ("</joint>", "<dynamics damping='0' friction='0' spring_stiffness='3' spring_reference='0'/></joint>"),
        ('type="revolute"', 'type="continuous"'),
        ('type="revolute"', 'type="prismatic"'),
        (LIMIT, '<limit upper="1" effort="2"/>'),
    ],
)
def test_what_urdf_and_others_have_beside_is_left_alone(tmp_path: Path, old: str, new: str):
    assert old in GOOD
    assert len(load(tmp_path, GOOD.replace(old, new)).joints) == 1


def test_a_continuous_joint_needs_no_limit(tmp_path: Path):
    joint = load(tmp_path, GOOD.replace(LIMIT, "").replace('"revolute"', '"continuous"')).joints[0]
    assert joint.torque_limit == float("inf")
