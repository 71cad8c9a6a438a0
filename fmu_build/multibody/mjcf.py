"""MJCF of an identified device for MuJoCo: `Multibody` in, bytes of the file out.

Springs, gains, rotors and friction have counterparts in MuJoCo:

Ks, epos        ``stiffness``, ``springref`` of a joint
Kp              ``gear`` of a motor
rotor           ``armature`` of a joint, or of a fixed tendon where several joints turn it
LuGre           ``dcmotor`` without a motor constant: its bristle is LuGre's, σ2 is the joint's ``damping``
other friction  ``frictionloss`` at the Coulomb level, ``damping``
following link  an equality of joints, which MuJoCo holds by a stiff constraint; a link that several joints move turns
                by one joint of its own, and a fixed tendon holds that to their sum
"""

from __future__ import annotations

import math
from typing import Literal
from xml.etree.ElementTree import Comment, Element, SubElement

from haptid.fmu_build.description.xml_parts import xml_bytes
from haptid.fmu_build.multibody.bodies import Axis, Body, Hinge, Multibody
from haptid.fmu_build.multibody.urdf import CONTROL_POINT, text_of
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.device import BASE
from haptid.model.friction.registry import DEFAULT
from haptid.model.thresholds import THRESHOLDS as OF_MODEL
from haptid.support.errors import InputError

FrictionOf = Literal["lugre", "frictionloss"]
"""Friction in MuJoCo: its LuGre bristle where the joint's law is LuGre, or Coulomb and viscous friction alone."""
STIFF = "{dmin} {dmax} 0.001 0.5 2"
"""Impedance of the equality of two joints; width, midpoint and power do not matter where dmin = dmax."""


def mjcf_bytes(machine: Multibody, friction: FrictionOf = "lugre", remarks: tuple[str, ...] = ()) -> bytes:
    """Return the MJCF of an identified device.

    Parameters
    ----------
    machine
        Bodies, axes and rotors.
    friction
        ``lugre`` needs a MuJoCo whose ``dcmotor`` has a LuGre bristle and the input ``none`` (4.0).
    remarks
        Sentences for a comment at the top.

    Returns
    -------
    bytes
        Indented XML in UTF-8. ``ctrl`` holds the commanded torques, joint by joint; joints, motors and sensors are
        named as in the FMU, ``joint0`` …; ranges are stated but not enforced, as in the FMU.

    Raises
    ------
    InputError
        Where a joint turns no link by itself, but only together with others.
    """
    root = Element("mujoco", model=machine.name)
    for sentence in (machine.title, *remarks):
        root.append(Comment(f" {sentence.replace('--', '–')} "))
    SubElement(root, "compiler", angle="radian", eulerseq="XYZ", autolimits="false", balanceinertia="false")
    step = repr(OF_MODEL.inner_step_s)
    SubElement(root, "option", timestep=step, gravity=text_of(machine.gravity), integrator="RK4")
    _bodies(root, machine, friction)
    _tendons(root, machine)
    _equalities(root, machine)
    _actuators(root, machine, friction)
    _sensors(root, machine)
    return xml_bytes(root)


def _bodies(root: Element, machine: Multibody, friction: FrictionOf) -> None:
    nodes = {BASE: SubElement(root, "worldbody")}
    for body in machine.bodies:
        node = SubElement(nodes[body.parent], "body", name=body.name, pos=text_of(body.origin), euler=text_of(body.rpy))
        nodes[body.name] = node
        if len(body.hinges) > 1:
            first = body.hinges[0]
            kind = "slide" if first.slides else "hinge"
            SubElement(node, "joint", name=name_of_sum(body), type=kind, axis=text_of(first.axis))
        else:
            for hinge in body.hinges:
                node.append(_joint(hinge, machine, friction))
        _inertial(node, body)
    SubElement(nodes[machine.tip], "site", name=CONTROL_POINT, pos=text_of(machine.control_point))


def _joint(hinge: Hinge, machine: Multibody, friction: FrictionOf) -> Element:
    joint = Element("joint", name=hinge.name, type="slide" if hinge.slides else "hinge", axis=text_of(hinge.axis))
    if not hinge.leads:
        return joint
    axis = machine.axes[hinge.joint]
    joint.set("stiffness", repr(axis.stiffness))
    joint.set("springref", repr(axis.equilibrium))
    joint.set("damping", repr(axis.viscous))
    if not has_bristle(axis, friction):
        joint.set("frictionloss", repr(axis.coulomb))
    own = [rotor for rotor in machine.rotors if set(rotor.ratios) == {hinge.joint}]
    armature = sum(rotor.inertia * rotor.ratios[hinge.joint] ** 2 for rotor in own)
    joint.set("armature", repr(float(armature)))
    if all(math.isfinite(limit) for limit in axis.limits):
        joint.set("range", text_of(axis.limits))
        joint.set("limited", "false")
    return joint


def has_bristle(axis: Axis, friction: FrictionOf) -> bool:
    """Say whether MuJoCo simulates the bristle of a joint.

    Parameters
    ----------
    axis
        The joint.
    friction
        Friction that the file is to have.

    Returns
    -------
    bool
        Whether its law is LuGre and the file has LuGre's.
    """
    return friction == "lugre" and axis.friction == DEFAULT


def _inertial(node: Element, body: Body) -> None:
    """Write mass, centroid and inertia; a massless body that moves gets the least that MuJoCo takes."""
    if body.inertial is not None:
        inertia = text_of(body.inertial.inertia)
        centroid, mass = text_of(body.inertial.centroid), repr(body.inertial.mass)
        SubElement(node, "inertial", pos=centroid, mass=mass, fullinertia=inertia)
    elif body.hinges:
        least = THRESHOLDS.inertia_of_massless_body_si
        SubElement(node, "inertial", pos="0 0 0", mass=repr(least), diaginertia=text_of((least, least, least)))


def name_of_sum(body: Body) -> str:
    """Return the name of the one joint of a body that several joints of the device move.

    Parameters
    ----------
    body
        Body with several hinges.

    Returns
    -------
    str
        Name in the MJCF.
    """
    return f"{body.name}_sum"


def _sums(machine: Multibody) -> tuple[Body, ...]:
    """Return the bodies that several joints move; the mass matrix of two hinges about one axis would be singular."""
    sums = tuple(body for body in machine.bodies if len(body.hinges) > 1)
    for body in sums:
        for hinge in body.hinges:
            if hinge.leads:
                where, got = f"link {body.name}", f"{hinge.name}, which turns no other link"
                expected = "joints that each turn a link by themselves, as MuJoCo needs them"
                raise InputError(where, expected=expected, got=got, todo="export a URDF or an FMU")
    return sums


def _tendons(root: Element, machine: Multibody) -> None:
    """Write rotors that several joints turn, and the sums by which bodies follow several joints."""
    shared = [rotor for rotor in machine.rotors if len(rotor.ratios) > 1]
    sums = _sums(machine)
    if not shared and not sums:
        return
    tendons = SubElement(root, "tendon")
    for body in sums:
        tendon = SubElement(tendons, "fixed", name=name_of_sum(body))
        SubElement(tendon, "joint", joint=name_of_sum(body), coef="1")
        for hinge in body.hinges:
            SubElement(tendon, "joint", joint=machine.axes[hinge.joint].name, coef=repr(-hinge.ratio))
    for rotor in shared:
        tendon = SubElement(tendons, "fixed", name=f"rotor_{rotor.name}", armature=repr(rotor.inertia))
        for j, ratio in rotor.ratios.items():
            SubElement(tendon, "joint", joint=machine.axes[j].name, coef=repr(ratio))


def _equalities(root: Element, machine: Multibody) -> None:
    followers = [body for body in machine.bodies if any(not hinge.leads for hinge in body.hinges)]
    if not followers:
        return
    equality = SubElement(root, "equality")
    d = repr(THRESHOLDS.impedance_of_followers)
    held = {"solref": f"{THRESHOLDS.time_constant_of_followers_s!r} 1", "solimp": STIFF.format(dmin=d, dmax=d)}
    for body in followers:
        if len(body.hinges) > 1:
            SubElement(equality, "tendon", {"tendon1": name_of_sum(body), "polycoef": "0 0 0 0 0"} | held)
            continue
        (hinge,) = body.hinges
        ratio = text_of((0.0, hinge.ratio, 0.0, 0.0, 0.0))
        leader = machine.axes[hinge.joint].name
        SubElement(equality, "joint", {"joint1": hinge.name, "joint2": leader, "polycoef": ratio} | held)


def _actuators(root: Element, machine: Multibody, friction: FrictionOf) -> None:
    actuators = SubElement(root, "actuator")
    for axis in machine.axes:
        motor = SubElement(actuators, "motor", name=axis.name, joint=axis.name, gear=repr(axis.gain))
        if math.isfinite(axis.effort):
            motor.set("ctrllimited", "false")
            motor.set("ctrlrange", text_of((-axis.effort, axis.effort)))
    for axis in machine.axes:
        if has_bristle(axis, friction):
            p = axis.values
            lugre = text_of([p[id] for id in ("sigma0", "sigma1", "Fc", "Fs", "vs")])
            SubElement(
                actuators, "dcmotor", name=f"{axis.name}_friction", joint=axis.name, motorconst="0 0", resistance="1",
                input="none", lugre=lugre,
            )  # fmt: skip


def _sensors(root: Element, machine: Multibody) -> None:
    sensors = SubElement(root, "sensor")
    for kind, tail in (("jointpos", "reading"), ("jointvel", "speed")):
        for axis in machine.axes:
            SubElement(sensors, kind, name=f"{axis.name}.{tail}", joint=axis.name)
    for kind, tail in (("framepos", "position"), ("framequat", "quaternion")):
        SubElement(sensors, kind, name=f"handle.{tail}", objtype="site", objname=CONTROL_POINT)
