"""What URDF and MJCF do not carry of an identified device: `Multibody` in, sentences for file and command out."""

from __future__ import annotations

from haptid.fmu_build.multibody.bodies import Multibody
from haptid.fmu_build.multibody.mjcf import FrictionOf, has_bristle
from haptid.model.friction.registry import law_named

REST_OF_FRICTION = "the viscous and the Coulomb part alone, without stiction, Stribeck speed and presliding"
"""What is said of a joint whose friction becomes a damping and a constant level."""


def losses_of_urdf(machine: Multibody) -> tuple[str, ...]:
    """Return what the URDF of a device leaves out.

    Parameters
    ----------
    machine
        The device.

    Returns
    -------
    tuple of str
        A sentence for each thing that this device has and the format cannot say; ends without a full stop.
    """
    of_friction = {law_named(axis.friction).title for axis in machine.axes}
    springs = [axis.name for axis in machine.axes if axis.stiffness]
    gains = [axis.name for axis in machine.axes if axis.gain != 1]
    rotors = [rotor.name for rotor in machine.rotors if rotor.inertia]
    followers = [hinge.name for body in machine.bodies for hinge in body.hinges if not hinge.leads]
    x, y, z = machine.gravity
    found = [f"friction of {law}: {REST_OF_FRICTION}" for law in sorted(of_friction)]
    if springs:
        found.append(f"springs: those of {', '.join(springs)} are left out")
    if gains:
        found.append(f"gains: Kp of {', '.join(gains)} is left out, efforts are torques at the joint")
    if rotors:
        found.append(f"rotors: the inertia of {', '.join(rotors)} is left out")
    if followers:
        found.append(f"passive links: {', '.join(followers)} mimic a joint, which many readers ignore")
    found.append(f"gravity: the reader's own; identified with {x:g} {y:g} {z:g} m/s^2 in the base frame")
    return tuple(found)


def losses_of_mjcf(machine: Multibody, friction: FrictionOf) -> tuple[str, ...]:
    """Return what the MJCF of a device leaves out.

    Parameters
    ----------
    machine
        The device.
    friction
        Friction that the file has.

    Returns
    -------
    tuple of str
        A sentence for each thing that this device has and the format does not carry; ends without a full stop.
    """
    without = [axis.name for axis in machine.axes if not has_bristle(axis, friction)]
    followers = [hinge.name for body in machine.bodies for hinge in body.hinges if not hinge.leads]
    found = []
    if without:
        found.append(f"friction of {', '.join(without)}: {REST_OF_FRICTION}")
    if followers:
        found.append(f"passive links: {', '.join(followers)} follow a joint by MuJoCo's stiff, not rigid, equality")
    return tuple(found)
