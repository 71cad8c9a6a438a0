"""``python -m fmu_build.export``: an identified model as an FMU, once more or in the other packaging, or as bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from haptid.fmu_build.accuracy.accuracy import of_device as accuracy_of_device
from haptid.fmu_build.accuracy.accuracy import of_joint as accuracy_of_joint
from haptid.fmu_build.accuracy.accuracy import without_replaced
from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.commands import export as main
from haptid.fmu_build.content.reference_run import OverflowingError
from haptid.fmu_build.exchange.discrepancy_json import Finding, apply_refits, by_joint, read_discrepancy, read_finding
from haptid.fmu_build.exchange.identification_check import (
    check_for_device,
    check_orders,
    impossible_links,
    tell_first_guesses,
)
from haptid.fmu_build.exchange.identification_json import (
    drive_of,
    entries_of,
    friction_by_joint,
    inner_step_of,
    largest_torque_of,
    of_device,
    of_joint,
    read_identification,
)
from haptid.fmu_build.exchange.recorded_device import device_of_results
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.fmu_build.exchange.start_values import with_start_values
from haptid.fmu_build.exchange.taken_along import taken_along
from haptid.fmu_build.multibody.mjcf import FrictionOf
from haptid.fmu_build.multibody.write import SINGLE, Form, multibody_of_result, write_multibody
from haptid.model.device.device import Device
from haptid.model.effects.registry import with_folder
from haptid.model.equations.drive import Drive
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.drive_terms import drive_quantities
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.parameter_table import joint_parameters
from haptid.model.joint.whole_device import full_equations
from haptid.support.command import parse_joints
from haptid.support.errors import InputError

FORMS: Mapping[str, Form] = {".urdf": "urdf", ".xml": "mjcf"}
"""Format of a multibody file by the end of its name."""


def export_full(
    device: Device,
    identification: Mapping[str, Any],
    out: Path,
    kind: Kind = "python",
    findings: Sequence[Finding] = (),
    start: Path | None = None,
    folder: Path | None = None,
) -> Fmu:
    """Build the FMU of the whole device at its identified values.

    Parameters
    ----------
    device
        Device of the results.
    identification
        Content of an ``identification.json`` that passed `check_for_device`.
    out
        File to write.
    kind
        Packaging.
    findings
        Effects to include, with the parameters that were fitted with them; links stay as they were identified.
    start
        Parameter set (SSV) whose values overrule identification and findings; None for none.
    folder
        Folder of the results, where the draws of the parameters lie; None exports without draws.

    Returns
    -------
    Fmu
        With provenance of every value in its documentation.

    Raises
    ------
    InputError
        Where two findings are of one joint, the parameter set is at fault, or the reference run overflows.
    NumericalError
        Where the compiler is missing or fails.
    """
    equations = full_equations(device.with_friction(friction_by_joint(identification)), by_joint(findings))
    identified = of_device(identification)
    found = with_start_values(apply_refits(identified, findings).among(equations), start, equations)
    accuracy = without_replaced(
        accuracy_of_device(identification, device.name, folder, findings), identified, found, equations
    )
    return build_fmu(
        equations, out, kind=kind, values=found.values, provenance=found.provenance, accuracy=accuracy,
        step=inner_step_of(identification), largest_torque=largest_torque_of(identification),
    )  # fmt: skip


def export_joint(
    identification: Mapping[str, Any],
    joint: int,
    out: Path,
    kind: Kind = "python",
    start: Path | None = None,
    folder: Path | None = None,
) -> Fmu:
    """Build the FMU of one joint at its identified values.

    Parameters
    ----------
    identification
        Content of an ``identification.json`` with a configuration that frees this joint alone.
    joint
        Number of the joint.
    out
        File to write.
    kind
        Packaging.
    start
        Parameter set (SSV) whose values overrule the identification; None for none.
    folder
        Folder of the results, where draws and posterior lie; None exports without draws.

    Returns
    -------
    Fmu
        With the bounds of the fit where they are written down.

    Raises
    ------
    InputError
        Where the joint was not tested alone, the parameter set is at fault, or the reference run overflows.
    NumericalError
        Where the compiler is missing or fails.
    """
    entries, identified = entries_of(identification, joint), of_joint(identification, joint)
    # The inertia of a prismatic joint is a mass: its unit says which kind of joint was identified.
    slides, friction = entries["inertia"].get("unit") == "kg", friction_by_joint(identification)[joint]
    drive = drive_of(identification, joint)
    driven = () if drive is None else drive_quantities(drive, prismatic=slides)
    rows = (*joint_parameters(prismatic=slides, friction=friction), *driven)
    table = [q for q in rows if q.id in identified.values]
    parameters = [_set_within_bounds(q, identified.values[q.id], entries[q.id]) for q in table]
    equations = joint_equations(joint, parameters=parameters, prismatic=slides, friction=friction, drive=drive)
    found = with_start_values(identified, start, equations)
    accuracy = without_replaced(accuracy_of_joint(identification, joint, folder), identified, found, equations)
    return build_fmu(
        equations, out, kind=kind, values=found.values, provenance=found.provenance, accuracy=accuracy,
        step=inner_step_of(identification, joint), largest_torque=largest_torque_of(identification, joint),
    )  # fmt: skip


def export_parameters(device: Device, identification: Mapping[str, Any], path: Path) -> Path:
    """Write the parameter set (SSV) of the whole device's FMU.

    Parameters
    ----------
    device
        Device of the results.
    identification
        Content of an ``identification.json``.
    path
        File to write.

    Returns
    -------
    Path
        ``path``. The set holds every parameter by FMU variable name; first guesses where none was identified.

    Raises
    ------
    InputError
        Where the identification names an unknown friction law.
    """
    equations = full_equations(device.with_friction(friction_by_joint(identification)))
    return write_ssv(path, *of_device(identification).among(equations).name_values(equations), name=device.name)


def _set_within_bounds(q: Quantity, value: float, entry: Mapping[str, Any]) -> Quantity:
    """Return the parameter at its identified value, within the bounds that the fit had where they are written down."""
    given = entry.get("lower")
    lower = q.lower if given is None or (q.scale == "log" and given <= 0) else float(given)
    upper = q.upper if entry.get("upper") is None else float(entry["upper"])
    return q.but(initial=value, lower=min(lower, value), upper=max(upper, value))


def _only_joint(data: Mapping[str, Any], wanted: tuple[int, ...] | None) -> int:
    joints = list(dict.fromkeys(c["free_joints"][0] for c in data["configurations"] if len(c["free_joints"]) == 1))
    chosen = [j for j in joints if wanted is None or j in wanted]
    if len(chosen) != 1:
        there = ", ".join(map(str, joints)) or "none: it holds no joint that was tested alone"
        got = ", ".join(map(str, wanted or ())) or "nothing"
        raise InputError("--joints", expected=f"one joint of the result ({there})", got=got)
    return int(chosen[0])


def _check_complete(entries: Mapping[str, Any], friction: str, drive: Drive | None, where: str) -> None:
    """Refuse the parameters of a joint alone where one is missing; gravity may be, where it does no work."""
    driven = () if drive is None else drive_quantities(drive)
    for q in (*joint_parameters(friction=friction), *driven):
        if q.id not in entries and not q.id.startswith("gravity"):
            raise InputError(where, expected=f"the key {q.id!r}", got=", ".join(entries) or "none")


@contextmanager
def _named_in_errors(source: Path, warnings: Sequence[str]) -> Iterator[None]:
    """Name the file of a model that overflows, and the warning about it that says why."""
    try:
        yield
    except OverflowingError as error:
        todo = warnings[0] if warnings else error.todo
        raise InputError(str(source), expected=error.expected, got=error.got, todo=todo) from None


def _packaging(kind: Kind, fmi: str) -> Kind:
    if fmi == "2.0":
        return kind
    if kind == "python":
        raise InputError("--fmi 3.0", expected="--kind native", got="python", todo="pythonfmu writes FMI 2.0")
    return "native3"


def _effects_of(path: Path) -> str:
    """Say where the FMU of a joint with its effects is, or why there is none."""
    try:
        data = read_discrepancy(path)
    except InputError:  # a file of another kind
        return "of a joint alone, haptid missing writes the FMU with the effects that it names"
    if data.get("fmu"):
        return f"haptid missing has written the FMU of the joint with its effects: {path.parent.parent / data['fmu']}"
    return f"{path} has the verdict {data['verdict']!r}, and haptid missing wrote no FMU of the joint with effects"


def _file_of_result(source: Path) -> Path:
    """Return the file of a result, of which the folder may be named; refuse a finding, which goes to --with."""
    if source.is_dir():
        return source / "identification.json"
    try:
        read_discrepancy(source)
    except InputError:  # whatever else is wrong with the file, its reader says
        return source
    todo = f"--with takes its effects along into the FMU of a whole device; {_effects_of(source)}"
    raise InputError(str(source), expected="an identification.json", got="a finding of haptid missing", todo=todo)


def _kind_for(out: Path, stated: Kind | Form | None) -> Kind | Form:
    """Return the kind of file that was asked for: stated, or by the file's name."""
    by_name = FORMS.get(out.suffix.lower())
    if stated is None:
        return by_name or "python"
    is_fmu = stated not in FORMS.values()
    if is_fmu and by_name is not None:
        got, todo = f"--kind {stated}", f"state --kind {by_name}, or choose a name that ends in .fmu"
        raise InputError(
            str(out), expected=f"--kind {by_name} for a name that ends in {out.suffix}", got=got, todo=todo
        )
    if not is_fmu and out.suffix == ".fmu":
        got, todo = f"--kind {stated}", "leave --kind away, or name a file that ends in .urdf or .xml"
        raise InputError(str(out), expected="--kind python or native for a name that ends in .fmu", got=got, todo=todo)
    return stated


@dataclass(frozen=True, slots=True, kw_only=True)
class Packaged:
    """A result that was packaged as an FMU.

    Parameters
    ----------
    fmu
        The FMU.
    taken
        Lines on the effects that were taken along, or left behind.
    warnings
        Sentences on values that no real device has, and on joints of which nothing was identified.
    """

    fmu: Fmu
    taken: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def package_result(  # noqa: PLR0913 # one argument an option
    source: Path,
    out: Path,
    kind: Kind = "python",
    *,
    joints: tuple[int, ...] | None = None,
    named: Sequence[Path] = (),
    start: Path | None = None,
    effects: Path | None = None,
    device: Device | str | None = None,
) -> Packaged:
    """Package the model that an identification.json holds.

    Parameters
    ----------
    source
        File identification.json.
    out
        FMU to write.
    kind
        Packaging.
    joints
        Number of the joint to package alone; None for the whole device.
    named
        Findings of single joints, whose effects are taken along.
    start
        Parameter set whose values overrule the identification.
    effects
        Folder with effects of the user's own.
    device
        Device of the results, or its file; None for the one that the results name.

    Returns
    -------
    Packaged

    Raises
    ------
    InputError
        Where the result, a finding or the parameter set is at fault or holds no such model, or the FMU's name does not
        end in ``.fmu``.
    """
    if out.suffix != ".fmu":  # hosts know an FMU by its name
        todo = f"call the FMU {out.stem}.fmu; a URDF ends in .urdf, an MJCF in .xml"
        raise InputError(str(out), expected="a name that ends in .fmu", got=repr(out.name), todo=todo)
    data = read_identification(source)
    if data["device"] == SINGLE or joints:
        if named:
            raise InputError("--with", expected="the whole device", got="a joint alone", todo=_effects_of(named[0]))
        joint = _only_joint(data, joints)
        law = friction_by_joint(data)[joint]
        _check_complete(entries_of(data, joint), law, drive_of(data, joint), f"{source}: parameters of joint {joint}")
        with _named_in_errors(source, []):
            return Packaged(fmu=export_joint(data, joint, out, kind, start, source.parent))
    catalogue = with_folder(effects)
    findings = [read_finding(path, catalogue) for path in named]
    machine = device if isinstance(device, Device) else device_of_results(device, data, source)
    check_for_device(data, machine, str(source))
    taken = tuple(taken_along(findings, data, machine, str(source)))  # refused before an FMU is written
    values = of_device(data).values
    check_orders(values, machine, str(source))
    for finding in findings:  # each by itself, so that an error names the file at fault
        check_orders(values | finding.values, machine, finding.source)
    warnings = (*impossible_links(values, machine), *_first_guesses(data, machine))
    with _named_in_errors(source, warnings):
        fmu = export_full(machine, data, out, kind, findings, start, source.parent)
    return Packaged(fmu=fmu, taken=taken, warnings=warnings)


def _first_guesses(data: Mapping[str, Any], machine: Device) -> Iterator[str]:
    tested = [joint for entry in data["configurations"] for joint in entry["free_joints"]]
    one = f"; --joints {min(tested)} packages an identified joint alone" if tested else ""
    yield from (f"{sentence}{one}" for sentence in tell_first_guesses(data, machine))


def export_result(  # noqa: PLR0913, PLR0917 # one argument an option
    source: Path,
    out: Path,
    kind: Kind | Form | None,
    fmi: str,
    joints: str | None,
    named: tuple[Path, ...],
    start: Path | None,
    effects: Path | None,
    device: str | None,
    friction: FrictionOf,
) -> dict[str, Any]:
    """Package the model that an identification.json holds, and tell which file was written.

    Parameters
    ----------
    source
        File identification.json, or the folder that holds it.
    out
        File to write.
    kind
        Packaging of the FMU, or format of a multibody file; None to go by the name of ``out``.
    fmi
        Version of FMI, ``2.0`` or ``3.0``.
    joints
        Number of the joint to export alone; None for the whole device.
    named
        Findings of single joints, whose effects are taken along.
    start
        Parameter set whose values overrule the identification.
    effects
        Folder with effects of the user's own.
    device
        File of the device, where the results have no copy of it.
    friction
        Friction of an MJCF.

    Returns
    -------
    dict
        Path, packaging, digest and size of the FMU; path, format and losses of a multibody file.

    Raises
    ------
    InputError
        Where a file or an option is at fault, or an effect is to be taken along to a joint alone.
    NumericalError
        Where the compiler fails.
    """
    source, kind = _file_of_result(source), _kind_for(out, kind)
    if kind == "urdf" or kind == "mjcf":  # noqa: PLR1714 # mypy narrows a comparison, not a set
        _refuse_for_bodies({"--joints": joints, "--with": named, "--effects": effects, "--fmi 3.0": fmi == "3.0"}, kind)
        return _export_bodies(source, out, kind, friction, start, device)
    kind, wanted = _packaging(kind, fmi), parse_joints(joints)
    packaged = package_result(
        source, out, kind, joints=wanted, named=named, start=start, effects=effects, device=device
    )  # fmt: skip
    for sentence in packaged.warnings:
        click.echo(f"warning: {source}: {sentence}", err=True)
    for line in packaged.taken:
        click.echo(line)
    fmu = packaged.fmu
    size = fmu.path.stat().st_size / 1024
    click.echo(f"{fmu.path}: {fmu.equations.title}; {fmu.kind}, FMI {fmi}, {size:.0f} kB, digest {fmu.digest}")
    about = {"title": fmu.equations.title, "kind": fmu.kind, "fmi": fmi, "digest": fmu.digest}
    return {"fmu": str(fmu.path), **about, "bytes": fmu.path.stat().st_size}


def _refuse_for_bodies(options: Mapping[str, object], form: Form) -> None:
    """Refuse what bodies cannot hold: a joint alone has none, effects are formulas that no simulator of bodies has."""
    for option, stated in options.items():
        if stated:
            todo = "effects, joints alone and versions of FMI go into FMUs"
            raise InputError(option, expected=f"--kind python or native with {option}", got=form, todo=todo)


def _export_bodies(
    source: Path, out: Path, form: Form, friction: FrictionOf, start: Path | None, device: str | None
) -> dict[str, Any]:
    machine = multibody_of_result(source, device, start)
    written = write_multibody(machine, out, form, friction)
    for sentence in machine.guessed:
        click.echo(f"warning: {source}: {sentence}", err=True)
    click.echo(f"{out}: {machine.title}; {form.upper()}, {out.stat().st_size / 1024:.0f} kB")
    for sentence in written.losses:
        click.echo(f"not carried: {sentence}")
    return {"file": str(out), "title": machine.title, "kind": form, "losses": list(written.losses)}


if __name__ == "__main__":
    main()
