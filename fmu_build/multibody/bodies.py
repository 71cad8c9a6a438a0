"""Bodies, hinges and drives of an identified device: `Device` and values in, `Multibody` out.

A link of a device follows its parent by Σ_j c_j·q_j. Multibody formats know joints with a coordinate of their own, and
joints that mimic one of them. So every term of that sum becomes one `Hinge`: for each joint of the device one term with
|c_j| = 1 leads (its axis is turned round where c_j = −1), and all others follow it by their ratio.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from haptid.fmu_build.exchange.identification_check import impossible_links
from haptid.model.device.device import STANDARD, Device, Link, Vector
from haptid.model.equations.fmu_names import of_joint
from haptid.model.friction.registry import law_named
from haptid.support.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Hinge:
    """One motion of a body against its parent, a turn or a travel.

    Parameters
    ----------
    name
        ``joint4`` of the hinge that leads, ``joint2_<link>`` of one that follows: readers that sort
        names find the leader first.
    joint
        Number of the joint of the device.
    slides
        Whether it is a travel.
    axis
        Unit vector in the body's frame.
    ratio
        Its coordinate over q of the joint; 1 where it leads.
    leads
        Whether its coordinate is the joint's own.
    """

    name: str
    joint: int
    slides: bool
    axis: Vector
    ratio: float
    leads: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Inertial:
    """Mass, centroid and inertia of a body, in its frame.

    Parameters
    ----------
    mass
        Mass [kg].
    centroid
        Centroid [m], shape (3,).
    inertia
        I11, I22, I33, I12, I13, I23 about the centroid [kg m²].
    """

    mass: float
    centroid: Vector
    inertia: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A body: its frame at home in that of its parent, its motions in turn, and its inertial parameters.

    Parameters
    ----------
    name, title
        Identifier, and words for a reader.
    parent
        Name of its parent, or ``base``.
    origin, rpy
        Position [m] and fixed-axis angles [rad], R = Rz·Ry·Rx.
    hinges
        None for a body that is fixed to its parent.
    inertial
        None for a massless body.
    """

    name: str
    title: str
    parent: str
    origin: Vector
    rpy: Vector
    hinges: tuple[Hinge, ...]
    inertial: Inertial | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """Drive, spring, friction and limits of one joint of the device.

    Parameters
    ----------
    name
        As ``joint4``, by which the FMU names its variables.
    title
        Words for a reader.
    gain
        Kp, torque at the joint over the command.
    stiffness, equilibrium
        Spring [N m/rad] and the position at which it is slack [rad].
    friction
        Id of the friction law.
    values
        Parameters of the law by id.
    viscous, coulomb
        Viscous friction [N m s/rad] and Coulomb level [N m] of the law.
    limits
        Mechanical range [rad] or [m]; may be infinite.
    effort
        Largest command [N m] or [N]; may be infinite.
    """

    name: str
    title: str
    gain: float
    stiffness: float
    equilibrium: float
    friction: str
    values: Mapping[str, float]
    viscous: float
    coulomb: float
    limits: tuple[float, float]
    effort: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Rotor:
    """The rotor of a motor, which turns by Σ_j ratios[j]·q_j.

    Parameters
    ----------
    name
        Identifier.
    inertia
        Inertia about the shaft [kg m²].
    ratios
        Turns of the rotor for one of the joint, by joint.
    """

    name: str
    inertia: float
    ratios: Mapping[int, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Multibody:
    """An identified device as bodies that simulators of rigid bodies know.

    Parameters
    ----------
    name, title
        Identifier, and words for a reader.
    gravity
        Acceleration of gravity in the base frame [m/s²].
    bodies
        Each behind its parent.
    axes
        Joints of the device by number.
    rotors
        Rotors of the motors.
    tip, control_point
        Body that carries the control point, and the point in its frame [m].
    guessed
        Sentences on joints whose friction and springs are first guesses; none where every joint was tested.
    """

    name: str
    title: str
    gravity: Vector
    bodies: tuple[Body, ...]
    axes: tuple[Axis, ...]
    rotors: tuple[Rotor, ...]
    tip: str
    control_point: Vector
    guessed: tuple[str, ...] = ()


def multibody(device: Device, values: Mapping[str, float], title: str) -> Multibody:
    """Arrange an identified device as bodies, hinges, axes and rotors.

    Parameters
    ----------
    device
        Device with the friction laws of the result.
    values
        Value by id of every parameter of the whole device, SI units.
    title
        What is identified, and from what.

    Returns
    -------
    Multibody
        The numbers are those of the FMU of the whole device.

    Raises
    ------
    InputError
        Where no link is moved by ±1 times some joint, or no rigid body has the inertia of a link: simulators refuse it.
    """
    for sentence in impossible_links(values, device):
        raise InputError("links", expected="links that a simulator of rigid bodies takes", got=sentence)
    leaders = {j: _leader(device, j) for j in range(len(device.joints))}
    return Multibody(
        name=device.name,
        title=title,
        gravity=device.gravity,
        bodies=tuple(_body(link, leaders, values) for link in device.links),
        axes=tuple(_axis(device, j, values) for j in range(len(device.joints))),
        rotors=tuple(
            Rotor(
                name=motor.name,
                inertia=float(values[f"motor_{motor.name}_J"]),
                ratios={j: float(ratio) for j, ratio in sorted(motor.ratios.items()) if ratio},
            )
            for motor in device.motors
        ),
        tip=device.tip,
        control_point=device.control_point,
    )


def _leader(device: Device, joint: int) -> str:
    # A link with mass leads before a massless one, and a link that no other joint moves before one that several move:
    # what follows is held by a constraint, the less of it the better.
    ranked = sorted(device.links, key=lambda link: (len(link.moved_by) > 1, link.inertial is None))
    for link, ratio in ((link, ratio) for ratio in (1, -1) for link in ranked):
        if link.moved_by.get(joint, 0) == ratio:
            return link.name
    where, got = f"device {device.name}, joint {joint}", "none"
    raise InputError(where, expected="a link that it moves by 1 or −1 times its position", got=got)


def _body(link: Link, leaders: Mapping[int, str], values: Mapping[str, float]) -> Body:
    return Body(
        name=link.name,
        title=link.title,
        parent=link.parent,
        origin=link.origin,
        rpy=link.rpy,
        hinges=tuple(_hinge(link, j, leaders[j] == link.name) for j, ratio in link.moved_by.items() if ratio),
        inertial=None if link.inertial is None else _inertial(link, values),
    )


def _hinge(link: Link, joint: int, leads: bool) -> Hinge:
    ratio = float(link.moved_by[joint])
    x, y, z = link.axis
    turned_round = leads and ratio < 0
    return Hinge(
        name=f"joint{joint}" if leads else f"joint{joint}_{link.name}",
        joint=joint,
        slides=link.motion == "prismatic",
        axis=(-x, -y, -z) if turned_round else link.axis,
        ratio=1.0 if leads else ratio,
        leads=leads,
    )


def _inertial(link: Link, values: Mapping[str, float]) -> Inertial:
    m, x, y, z, xx, yy, zz, xy, xz, yz = (float(values[f"link{link.name}_{key}"]) for key in STANDARD)
    return Inertial(mass=m, centroid=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))


def _axis(device: Device, joint: int, values: Mapping[str, float]) -> Axis:
    data, tail = device.joints[joint], f"_{joint}"
    law = law_named(data.friction)
    friction = law.values(values, tail)
    return Axis(
        name=of_joint(joint, "").rstrip("."),
        title=data.name,
        gain=float(values[f"Kp{tail}"]),
        stiffness=float(values[f"Ks{tail}"]),
        equilibrium=float(values[f"epos{tail}"]),
        friction=law.id,
        values=friction,
        viscous=friction[law.roles.viscous],
        coulomb=friction[law.roles.coulomb],
        limits=data.position_limits,
        effort=data.torque_limit,
    )
