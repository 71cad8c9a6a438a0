"""URDF of an identified device: `Multibody` in, bytes of the file out.

URDF knows links, joints with limits, viscous and dry friction, and joints that mimic another. A body that several
joints move becomes a chain of massless links, one a hinge. What URDF cannot say is told by `losses.losses_of_urdf`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Comment, Element, SubElement

from haptid.fmu_build.description.xml_parts import xml_bytes
from haptid.fmu_build.multibody.bodies import Axis, Body, Hinge, Inertial, Multibody
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.device import BASE, Vector

CONTROL_POINT = "control_point"
"""Name of the massless link at the control point; the last of the file, where haptid's own reader looks for it."""


def text_of(numbers: Iterable[float]) -> str:
    """Return numbers with all their digits, separated by blanks.

    Parameters
    ----------
    numbers
        Any numbers.

    Returns
    -------
    str
        Text that reads back as the same bits.
    """
    return " ".join(repr(float(number) + 0.0) for number in numbers)


def urdf_bytes(machine: Multibody, remarks: tuple[str, ...] = ()) -> bytes:
    """Return the URDF of an identified device.

    Parameters
    ----------
    machine
        Bodies and axes.
    remarks
        Sentences for a comment at the top.

    Returns
    -------
    bytes
        Indented XML in UTF-8; joints are named as in the FMU, ``joint0`` …, the driven ones first and in their order.
    """
    root = Element("robot", name=machine.name)
    for sentence in (machine.title, *remarks):
        root.append(Comment(f" {sentence.replace('--', '–')} "))
    # MuJoCo's reader of URDF: it knows no massless body that moves, and would melt fixed links into their parents.
    mujoco = SubElement(root, "mujoco")
    least = repr(THRESHOLDS.inertia_of_massless_body_si)
    SubElement(mujoco, "compiler", boundmass=least, boundinertia=least, fusestatic="false")
    SubElement(root, "link", name=BASE)
    joints: list[tuple[tuple[int, int], Element]] = []
    for place, body in enumerate(machine.bodies):
        for link, joint, order in _chain(machine, body):
            root.append(link)
            joints.append(((order, place), joint))
    SubElement(root, "link", name=CONTROL_POINT)
    # Joints are numbered in the order of the file by readers that know no other order.
    root.extend(joint for _, joint in sorted(joints, key=lambda pair: pair[0]))
    last = SubElement(root, "joint", name=f"{CONTROL_POINT}_joint", type="fixed")
    _ends(last, machine.tip, CONTROL_POINT, machine.control_point, (0.0, 0.0, 0.0))
    return xml_bytes(root)


def _chain(machine: Multibody, body: Body) -> Iterator[tuple[Element, Element, int]]:
    """Yield links and joints of a body, one pair a hinge, each with the place of the joint in the file."""
    many = len(machine.axes)
    parent, origin, rpy = body.parent, body.origin, body.rpy
    if not body.hinges:
        joint = Element("joint", name=f"{body.name}_fixed", type="fixed")
        _ends(joint, parent, body.name, origin, rpy)
        yield _link(body.name, body.inertial), joint, many
    for k, hinge in enumerate(body.hinges):
        last = hinge is body.hinges[-1]
        name = body.name if last else f"{body.name}_{k}"
        joint = _joint(hinge, machine.axes[hinge.joint])
        _ends(joint, parent, name, origin, rpy)
        yield _link(name, body.inertial if last else None), joint, hinge.joint if hinge.leads else many
        parent, origin, rpy = name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def _ends(joint: Element, parent: str, child: str, origin: Vector, rpy: Vector) -> None:
    SubElement(joint, "origin", xyz=text_of(origin), rpy=text_of(rpy))
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)


def _link(name: str, inertial: Inertial | None) -> Element:
    link = Element("link", name=name)
    if inertial is None:
        return link
    node = SubElement(link, "inertial")
    SubElement(node, "origin", xyz=text_of(inertial.centroid), rpy=text_of((0.0, 0.0, 0.0)))
    SubElement(node, "mass", value=repr(inertial.mass))
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    tensor = {key: repr(value) for key, value in zip(keys, inertial.inertia, strict=True)}
    SubElement(node, "inertia", tensor)
    return link


def _joint(hinge: Hinge, axis: Axis) -> Element:
    endless = any(math.isinf(limit) for limit in axis.limits)
    turns = "continuous" if endless else "revolute"
    kind = "prismatic" if hinge.slides else turns
    joint = Element("joint", name=hinge.name, type=kind)
    SubElement(joint, "axis", xyz=text_of(hinge.axis))
    ends = sorted(hinge.ratio * limit for limit in axis.limits)
    # URDF demands an effort and a velocity of every limit; the device states no velocity.
    largest = THRESHOLDS.limit_where_none_is_stated_si
    lower, upper = (max(-largest, min(largest, end)) for end in ends)
    effort = axis.effort if hinge.leads and math.isfinite(axis.effort) else largest
    limit = {"effort": repr(effort), "velocity": repr(largest)}
    if kind != "continuous":
        limit = {"lower": repr(lower), "upper": repr(upper), **limit}
    SubElement(joint, "limit", limit)
    if hinge.leads:
        SubElement(joint, "dynamics", damping=repr(axis.viscous), friction=repr(axis.coulomb))
    else:
        SubElement(joint, "mimic", joint=f"joint{hinge.joint}", multiplier=repr(hinge.ratio), offset="0")
    return joint
