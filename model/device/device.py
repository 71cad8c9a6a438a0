"""A device as data: links that turn or slide with the joints, their first guesses, motors, drives and assumptions.

Readers of TOML and URDF files make a `Device`; rigid-body equations, joints and plans are derived from it.

Symbols
-------
n_q joints with positions q [rad] or [m]; a link follows its parent by the angle (or travel) Σ_j moved_by[j]·q_j,
so that passive links (a parallelogram rod) are tree branches whose coefficients are 0, 1, −1, ….
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Literal

from haptid.model.friction.registry import DEFAULT

Vector = tuple[float, float, float]
Motion = Literal["revolute", "prismatic", "fixed"]
Transmission = Literal["direct", "tendon"]
BASE = "base"
"""Name of the frame that stands still."""

STANDARD = ("m", "x", "y", "z", "I11", "I22", "I33", "I12", "I13", "I23")
"""Standard parameters of a link: mass, centroid, inertia tensor about the centroid, in the link's frame."""

LINK_UNITS = ("kg", "m", "m", "m", *("kg m^2",) * 6)
"""Units of STANDARD."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
    """A first guess of one parameter, in the parameter's unit.

    Parameters
    ----------
    initial, lower, upper
        First guess and bounds.
    std
        Standard deviation of a normal prior about ``initial``; None for a flat prior between the bounds.
    fixed
        Whether the parameter is known and not fitted.
    """

    initial: float
    lower: float = -math.inf
    upper: float = math.inf
    std: float | None = None
    fixed: bool = False

    def __post_init__(self) -> None:
        """Check that the first guess lies within the bounds and ``std`` is positive; ValueError where not."""
        if not self.lower <= self.initial <= self.upper:
            msg = f"initial {self.initial} lies outside [{self.lower}, {self.upper}]"
            raise ValueError(msg)
        if self.std is not None and not self.std > 0:
            msg = f"std must be positive, got {self.std}"
            raise ValueError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Inertial:
    """First guesses of mass [kg], centroid [m] and inertia about the centroid [kg m²], in the link's frame.

    Parameters
    ----------
    guesses
        Ten guesses in the order of `STANDARD`; products of inertia are tensor entries, I12 = −∫ x y dm.
    """

    guesses: tuple[Guess, ...]

    @property
    def initial(self) -> tuple[float, ...]:
        """First guesses, shape (10,)."""
        return tuple(guess.initial for guess in self.guesses)


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """A rigid link: its frame in the parent's frame, its motion and its inertial parameters.

    Parameters
    ----------
    name, title
        Identifier, and words for a reader.
    motion
        ``revolute``, ``prismatic`` or ``fixed``.
    parent
        Name of a link above it in the file, or ``base``.
    origin, rpy
        Frame at home in the parent's frame: position [m]; fixed-axis roll, pitch, yaw [rad], R = Rz·Ry·Rx.
    axis
        Unit vector of the motion in the link's own frame.
    moved_by
        Joint → coefficient; the motion's coordinate is Σ coefficient·q. Integers for turning links.
    inertial
        None for a massless link.
    """

    name: str
    title: str = ""
    parent: str = BASE
    motion: Motion = "revolute"
    origin: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)
    axis: Vector = (0.0, 0.0, 1.0)
    moved_by: Mapping[int, Fraction] = field(default_factory=dict)
    inertial: Inertial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """The rotor of a motor, which turns by Σ_j ratios[j]·q_j.

    Parameters
    ----------
    name
        Identifier.
    inertia
        Inertia about the shaft [kg m²].
    ratios
        Joint → turns of the motor for one of the joint: one row of the coupling matrix.

    Notes
    -----
    Only the spin about the shaft has kinetic energy here: the rotor's mass belongs to the link that carries it, and
    gyroscopic torques are neglected.
    """

    name: str
    inertia: Guess
    ratios: Mapping[int, Fraction]


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """A joint: drive, limits, and first guesses of the parameters that do not come from the links.

    Parameters
    ----------
    name
        Name for a reader.
    transmission
        ``direct`` or ``tendon``.
    prismatic
        Whether the joint slides.
    friction
        Id of the friction law, one of `model.friction.registry.laws`.
    parameters
        Guesses by id: of Kp, Ks, epos and the parameters of the friction law.
    position_limits
        Mechanical range [rad] or [m].
    torque_limit
        Largest command [N m] or [N].
    max_frequency
        Highest frequency at which the amplifier is linear [rad/s].
    """

    name: str
    transmission: Transmission = "direct"
    prismatic: bool = False
    friction: str = DEFAULT
    parameters: Mapping[str, Guess] = field(default_factory=dict)
    position_limits: tuple[float, float] = (-math.pi, math.pi)
    torque_limit: float = math.inf
    max_frequency: float = math.inf

    @property
    def planned_range(self) -> tuple[float, float]:
        """Range of positions that a plan may use [rad] or [m].

        The position limits; 2π from the other limit where one side has none, ±π where neither side has one.
        """
        lower, upper = self.position_limits
        if math.isinf(lower) and math.isinf(upper):
            return -math.pi, math.pi
        return (upper - 2 * math.pi if math.isinf(lower) else lower), (
            lower + 2 * math.pi if math.isinf(upper) else upper
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A tree of links with n_q joints, in SI units.

    Parameters
    ----------
    name, title
        Identifier, and words for a reader.
    gravity
        Acceleration of gravity in the base frame [m/s²], shape (3,).
    joints
        The n_q joints; a joint's number is its place.
    links
        Links, each behind its parent.
    motors
        Rotors.
    control_link, control_point
        Link that carries the control point (the last link where empty), and the point in the link's frame [m].
    assumptions
        Sentences for reports.
    """

    name: str
    title: str
    gravity: Vector
    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    motors: tuple[Motor, ...] = ()
    control_link: str = ""
    control_point: Vector = (0.0, 0.0, 0.0)
    assumptions: tuple[str, ...] = ()

    def link(self, name: str) -> Link:
        """Return the link of this name.

        Parameters
        ----------
        name
            Name of a link.

        Returns
        -------
        Link
            The link.

        Raises
        ------
        KeyError
            Where there is no such link; the message lists the known names.
        """
        for link in self.links:
            if link.name == name:
                return link
        msg = f"{self.name} has no link {name!r}; it has {[link.name for link in self.links]}"
        raise KeyError(msg)

    def with_friction(self, laws: Mapping[int, str]) -> Device:
        """Return the device with other friction laws.

        Parameters
        ----------
        laws
            Id of the friction law by joint; other joints keep their law.

        Returns
        -------
        Device
            Copy; guesses stay and apply to the parameters that both laws have.
        """
        joints = tuple(replace(joint, friction=laws.get(j, joint.friction)) for j, joint in enumerate(self.joints))
        return replace(self, joints=joints)

    @property
    def massive(self) -> tuple[Link, ...]:
        """The links with inertial parameters, in the order of π."""
        return tuple(link for link in self.links if link.inertial is not None)

    @property
    def tip(self) -> str:
        """Name of the link that carries the control point: ``control_link``, else the last link."""
        return self.control_link or self.links[-1].name

    @property
    def digest(self) -> str:
        """Sixteen hex digits of the SHA-256 of geometry, gravity, motors' ratios and names; guesses do not enter."""
        links = [
            (k.name, k.parent, k.motion, k.origin, k.rpy, k.axis, sorted(k.moved_by.items()), k.inertial is None)
            for k in self.links
        ]
        motors = [(m.name, sorted(m.ratios.items())) for m in self.motors]
        joints = [(j.name, j.prismatic) for j in self.joints]
        text = repr((self.name, self.gravity, joints, links, motors, self.tip, self.control_point))
        return hashlib.sha256(text.encode()).hexdigest()[:16]
