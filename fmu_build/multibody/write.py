"""URDF and MJCF files of an identified device: ``identification.json`` and `Device` in, one file out.

The values are those of the FMU of the whole device, from the same functions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from haptid.fmu_build.exchange.identification_check import check_for_device, check_orders, tell_first_guesses
from haptid.fmu_build.exchange.identification_json import (
    friction_by_joint,
    of_device,
    read_identification,
    words_of_campaign,
)
from haptid.fmu_build.exchange.recorded_device import device_of_results
from haptid.fmu_build.exchange.start_values import with_start_values
from haptid.fmu_build.multibody.bodies import Multibody, multibody
from haptid.fmu_build.multibody.losses import losses_of_mjcf, losses_of_urdf
from haptid.fmu_build.multibody.mjcf import FrictionOf, mjcf_bytes
from haptid.fmu_build.multibody.urdf import urdf_bytes
from haptid.model.device.device import Device
from haptid.model.joint.whole_device import full_equations
from haptid.support.errors import InputError
from haptid.support.files.files import write_bytes

SINGLE = "single_joint"
"""The name of the device that is any one joint of any machine."""
Form = Literal["urdf", "mjcf"]
"""Format of a multibody file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """A multibody file that was written.

    Parameters
    ----------
    path
        The file.
    form
        ``urdf`` or ``mjcf``.
    losses
        Sentences on what the file does not carry.
    """

    path: Path
    form: Form
    losses: tuple[str, ...]


def identified_multibody(device: Device, identification: Mapping[str, Any], start: Path | None = None) -> Multibody:
    """Arrange an identified device as bodies, hinges, axes and rotors.

    Parameters
    ----------
    device
        Device of the results.
    identification
        Content of an ``identification.json`` that passed `check_for_device`.
    start
        Parameter set (SSV) whose values overrule the identification; None for none.

    Returns
    -------
    Multibody
        At the values of the FMU of the whole device; first guesses where none was identified.

    Raises
    ------
    InputError
        Where the parameter set is at fault, or the device is none that such a file can hold.
    """
    device = device.with_friction(friction_by_joint(identification))
    equations = full_equations(device)
    found = with_start_values(of_device(identification).among(equations), start, equations)
    values = {q.id: float(found.values.get(q.id, q.initial)) for q in equations.parameters}
    machine = multibody(device, values, f"{device.title}; values: {words_of_campaign(identification)}")
    return replace(machine, guessed=tuple(tell_first_guesses(identification, device)))


def write_multibody(machine: Multibody, out: Path, form: Form, friction: FrictionOf = "lugre") -> Written:
    """Write the URDF or the MJCF of an identified device.

    Parameters
    ----------
    machine
        The device.
    out
        File to write.
    form
        Format.
    friction
        Friction of an MJCF, see `mjcf_bytes`.

    Returns
    -------
    Written

    Raises
    ------
    InputError, WritingError
        As `mjcf_bytes` and `write_bytes`.
    """
    if form == "urdf":
        losses = losses_of_urdf(machine)
        content = urdf_bytes(machine, (*machine.guessed, *losses))
    else:
        losses = losses_of_mjcf(machine, friction)
        content = mjcf_bytes(machine, friction, (*machine.guessed, *losses))
    return Written(path=write_bytes(out, content), form=form, losses=losses)


def multibody_of_result(source: Path, device: Device | str | None = None, start: Path | None = None) -> Multibody:
    """Read an identification.json and arrange its device as bodies, hinges, axes and rotors.

    Parameters
    ----------
    source
        File identification.json.
    device
        Device of the results, or its file; None for the one that the results name.
    start
        Parameter set (SSV) whose values overrule the identification; None for none.

    Returns
    -------
    Multibody

    Raises
    ------
    InputError
        Where the result or the parameter set is at fault, or the result is of a single joint, which has no bodies.
    """
    data = read_identification(source)
    if data["device"] == SINGLE:
        got = "a joint alone, whose inertia and gravity are known and no bodies"
        todo = "export an FMU: choose a name that ends in .fmu"
        raise InputError(str(source), expected="a device with links", got=got, todo=todo)
    machine = device if isinstance(device, Device) else device_of_results(device, data, source)
    check_for_device(data, machine, str(source))
    check_orders(of_device(data).values, machine, str(source))
    return identified_multibody(machine, data, start)
