"""Check the parameters that an ``identification.json`` states: its content in, nothing out or an `InputError`.

`check_tests` needs no device, so that every file is checked as it is read; `check_for_device` also knows which joints
are prismatic and which links have which parameters.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from haptid.fmu_build.exchange.possible import (
    Possible,
    check_bounds,
    check_entry,
    check_order,
    check_value,
    of_joint_parameter,
    of_quantity,
)
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.device import STANDARD, Device
from haptid.model.device.stated_parameters import ORDERED, ROWS
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.drive_terms import DERIVATIVE_GAIN, INTEGRAL_GAIN, LIMIT
from haptid.model.joint.joint_in_device import joint_quantities
from haptid.model.rigid_body.forward_dynamics import link_quantities
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

COEFFICIENT = re.compile(r"(inertia|gravity|V|M\d{2,8})_(1|([csq]\d{1,4}){1,9})")
"""Ids of inertial coefficients of coupled joints, as ``M01_c1``, ``V_s0``, ``gravity_c0c0``."""
TENSOR = ((4, 7, 8), (7, 5, 9), (8, 9, 6))
"""Places of the inertia tensor's entries among `STANDARD`."""
ANY = Possible(
    least=-THRESHOLDS.largest_magnitude_si,
    most=THRESHOLDS.largest_magnitude_si,
    units=(),
    description="inertial coefficient or limit of a controller",
)


def check_tests(data: Mapping[str, Any], path: str) -> None:
    """Refuse parameters of the tests that no joint of any device has.

    Parameters
    ----------
    data
        Content of an ``identification.json`` that follows the schema.
    path
        Name of the file, for errors.

    Raises
    ------
    InputError
        Where the same joint was tested alone twice in one posture, a parameter does not exist, or its value, bounds,
        unit or order (Fs ≥ Fc) is impossible.
    """
    _check_once(data, path)
    for where, joints, id, entry in _entries(data, path):
        name, _ = _of_joint(id, joints)
        if name in ROWS:
            check_entry(entry, of_joint_parameter(name), where)
        elif COEFFICIENT.fullmatch(id) or id in (LIMIT, DERIVATIVE_GAIN, INTEGRAL_GAIN):
            check_value(float(entry["value"]), ANY, f"{where}.value")
            check_bounds(entry, where)
        else:
            known = [f"{name}{suffix}" for suffix in id_suffixes(joints) for name in ROWS]
            expected, todo = "parameters of a locked joint", did_you_mean(id, known)
            raise InputError(where.removesuffix(f".{id}"), expected=expected, got=repr(id), todo=todo)

    for number, configuration in enumerate(data["configurations"]):
        values = {id: entry["value"] for id, entry in configuration["parameters"].items()}
        for larger, smaller in ORDERED:
            for tail in ("", *(f"_{joint}" for joint in configuration["free_joints"])):
                where = f"{path}: configurations[{number}].parameters"
                check_order(larger + tail, smaller + tail, values, {}, where)


def check_for_device(data: Mapping[str, Any], device: Device, path: str) -> None:
    """Refuse joints, links and parameters that a device does not have, and impossible values.

    Parameters
    ----------
    data
        Content of an ``identification.json`` that passed `check_tests`.
    device
        Device of the results.
    path
        Name of the file, for errors.

    Raises
    ------
    InputError
        With the key at fault.
    """
    for number, configuration in enumerate(data["configurations"]):
        check_joints(configuration["free_joints"], device, f"{path}: configurations[{number}].free_joints")
    for where, joints, id, entry in _entries(data, path):
        name, joint = _of_joint(id, joints)
        if name in ROWS:
            check_entry(entry, of_joint_parameter(name, slides=device.joints[joint].prismatic), where)
    known = device_quantities(device)
    _check_links(data.get("links", {}), known, path)
    for id, value in data.get("whole", {}).items():
        if id in known:
            check_value(float(value), of_quantity(known[id]), f"{path}: whole.{id}")
        elif not COEFFICIENT.match(id):
            expected, todo = f"parameters of {device.name}", did_you_mean(id, known)
            where = f"{path}: whole"
            raise InputError(where, expected=expected, got=repr(id), todo=todo)


def check_joints(joints: list[int], device: Device, where: str) -> None:
    """Refuse numbers of joints that a device does not have.

    Parameters
    ----------
    joints
        Numbers of joints.
    device
        Device of the results.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        With the joints that it has.
    """
    last = len(device.joints) - 1
    for joint in joints:
        if joint > last:
            todo = f"it has joints 0 to {last}"
            raise InputError(where, expected=f"joints of {device.name}", got=f"joint {joint}", todo=todo)


def check_orders(values: Mapping[str, float], device: Device, where: str) -> None:
    """Refuse values with which no simulation of the whole device starts, as Fs below Fc.

    Parameters
    ----------
    values
        Value by id in the whole device, SI units; the device's first guess where absent.
    device
        Device of the results.
    where
        Name of the file, for errors.

    Raises
    ------
    InputError
        With the first pair in the wrong order.
    """
    guesses = {id: q.initial for id, q in device_quantities(device).items()}
    for joint in range(len(device.joints)):
        for larger, smaller in ORDERED:
            check_order(f"{larger}_{joint}", f"{smaller}_{joint}", values, guesses, where)


def impossible_links(values: Mapping[str, float], device: Device) -> Iterator[str]:
    """Find links whose inertia no rigid body has.

    Parameters
    ----------
    values
        Value by id in the whole device, SI units; links without any stated value are skipped.
    device
        Device whose first guesses complete the values.

    Yields
    ------
    str
        A sentence for each such link.

    Notes
    -----
    A density exists only where tr(I)/2·1 − I, the second moment of mass, is positive semidefinite: the principal
    moments obey the triangle inequality (Wensing, Kim and Slotine 2018, eq. 17).
    """
    for link in device.massive:
        ids = [f"link{link.name}_{key}" for key in STANDARD]
        if not link.inertial or not set(ids) & set(values):
            continue
        stated = [float(values.get(id, guess)) for id, guess in zip(ids, link.inertial.initial, strict=True)]
        inertia = np.array([[stated[k] for k in row] for row in TENSOR])
        moments = np.linalg.eigvalsh(np.trace(inertia) / 2 * np.eye(3) - inertia)
        if moments[0] < -THRESHOLDS.rounding_of_second_moment * np.abs(inertia).max():
            yield f"link {link.name}: no body has this inertia: its principal moments break the triangle inequality"


def tell_first_guesses(data: Mapping[str, Any], device: Device) -> Iterator[str]:
    """Tell of joints that no test had free, whose friction and springs are the device's first guesses.

    Parameters
    ----------
    data
        Content of an ``identification.json`` that passed `check_for_device`.
    device
        Device of the results.

    Yields
    ------
    str
        One sentence; none where every joint was tested.
    """
    tested = {joint for entry in data["configurations"] for joint in entry["free_joints"]}
    guessed = [joint for joint in range(len(device.joints)) if joint not in tested]
    if guessed:
        names, plural = ", ".join(map(str, guessed)), "s" if len(guessed) > 1 else ""
        yield f"joint{plural} {names}: not identified, so that the device's first guesses stand there"


def device_quantities(device: Device) -> dict[str, Quantity]:
    """Return the parameters of the whole device by id: links and joints, without deriving its equations.

    Parameters
    ----------
    device
        Device with its joints and links.

    Returns
    -------
    dict of str to Quantity
        Parameter by id in the whole device, as ``Ks_4`` or ``link6_m``.
    """
    joints = [q for j in range(len(device.joints)) for q in joint_quantities(device, j, suffix=f"_{j}")]
    return {q.id: q for q in (*link_quantities(device), *joints)}


def _check_once(data: Mapping[str, Any], path: str) -> None:
    tested = set()
    for configuration in data["configurations"]:
        joints, posture = tuple(configuration["free_joints"]), repr(configuration.get("locked_positions_rad"))
        if len(joints) == 1 and (joints, posture) in tested:
            where, got = f"{path}: configurations", f"joint {joints[0]} twice"
            raise InputError(where, expected="one test of every joint alone in a posture", got=got)
        tested.add((joints, posture))


def _entries(data: Mapping[str, Any], path: str) -> Iterator[tuple[str, list[int], str, Mapping[str, Any]]]:
    """Yield place, free joints, id and entry of every parameter of every test."""
    for number, configuration in enumerate(data["configurations"]):
        for id, entry in configuration["parameters"].items():
            yield f"{path}: configurations[{number}].parameters.{id}", configuration["free_joints"], id, entry


def _of_joint(id: str, joints: list[int]) -> tuple[str, int]:
    """Return a parameter's name and its joint: the only one, or the number at the end of the id."""
    if len(joints) == 1 and id in ROWS:
        return id, joints[0]
    for joint in joints:
        if id.endswith(f"_{joint}") and id.removesuffix(f"_{joint}") in ROWS:
            return id.removesuffix(f"_{joint}"), joint
    return "", joints[0]


def _check_links(links: Mapping[str, Any], known: Mapping[str, Quantity], path: str) -> None:
    bodies = {id.removeprefix("link").rpartition("_")[0] for id in known if id.startswith(("link", "motor_"))}
    for body, parameters in links.items():
        if body not in bodies:
            where, todo = f"{path}: links", did_you_mean(body, sorted(bodies))
            raise InputError(where, expected="links and motors of the device", got=repr(body), todo=todo)
        prefix = body if body.startswith("motor_") else f"link{body}"
        own = [id.removeprefix(f"{prefix}_") for id in known if id.startswith(f"{prefix}_")]
        for id, entry in parameters.items():
            where = f"{path}: links.{body}"
            if f"{prefix}_{id}" not in known:
                todo = did_you_mean(id, own)
                raise InputError(where, expected="parameters of a link or motor", got=repr(id), todo=todo)
            check_entry(entry, of_quantity(known[f"{prefix}_{id}"]), f"{where}.{id}")
