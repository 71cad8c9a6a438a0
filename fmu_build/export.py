"""``python -m fmu_build.export``: an identified model as an FMU, once more or in the other packaging."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.exchange.discrepancy_json import Finding, by_joint, read_finding, refitted
from haptid.fmu_build.exchange.identification_json import entries_of, of_device, of_joint, read_identification
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.model.device.device import Device
from haptid.model.device.reader import builtin_devices, load_device
from haptid.model.effects.registry import with_folder
from haptid.model.equations.joint_parameters import joint_parameters
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.whole_device import full_equations
from haptid.support.command import exit_codes, parse_joints
from haptid.support.errors import InputError

LONGEST_PATH = 1024
"""Characters of a device's path; the shortest limit among the systems, macOS's."""
SINGLE = "single_joint"
"""The name of the device that is any one joint of any machine."""


def export_full(
    device: Device,
    identification: Mapping[str, Any],
    out: Path,
    kind: Kind = "python",
    findings: Sequence[Finding] = (),
) -> Fmu:
    """Build the FMU of the whole device with the values of ``identification`` (the content of identification.json).

    ``findings`` bring effects and the parameters that were fitted with them; links stay as they were identified.
    """
    equations = full_equations(device, by_joint(findings))
    found = refitted(of_device(identification), findings).among(equations)
    return build_fmu(equations, out, kind=kind, values=found.values, provenance=found.provenance)


def export_joint(identification: Mapping[str, Any], joint: int, out: Path, kind: Kind = "python") -> Fmu:
    """Build the FMU of one joint with the values of ``identification``."""
    entries, found = entries_of(identification, joint), of_joint(identification, joint)
    slides = entries["inertia"].get("unit") == "kg"
    table = [q for q in joint_parameters(prismatic=slides) if q.id in found.values]
    parameters = [_bounded(q, found.values[q.id], entries[q.id]) for q in table]
    equations = joint_equations(joint, parameters=parameters, prismatic=slides)
    return build_fmu(equations, out, kind=kind, values=found.values, provenance=found.provenance)


def export_parameters(device: Device, identification: Mapping[str, Any], path: Path) -> Path:
    """Write the parameter set (SSV) of the whole device's FMU."""
    equations = full_equations(device)
    return write_ssv(path, *of_device(identification).among(equations).named(equations), name=device.name)


def _bounded(q: Quantity, value: float, entry: Mapping[str, Any]) -> Quantity:
    """Return the parameter at its identified value, within the bounds that the fit had where they are written down."""
    lower = q.lower if entry.get("lower") is None else float(entry["lower"])
    upper = q.upper if entry.get("upper") is None else float(entry["upper"])
    return q.but(initial=value, lower=min(lower, value), upper=max(upper, value))


def _only_joint(data: Mapping[str, Any], wanted: tuple[int, ...] | None) -> int:
    joints = [c["free_joints"][0] for c in data["configurations"] if len(c["free_joints"]) == 1]
    chosen = [j for j in joints if wanted is None or j in wanted]
    if len(chosen) != 1:
        there = ", ".join(map(str, joints)) or "none: it holds no joint that was tested alone"
        got = ", ".join(map(str, wanted or ())) or "nothing"
        raise InputError("--joints", expected=f"one joint of the result ({there})", got=got)
    return int(chosen[0])


def _packaging(kind: Kind, fmi: str) -> Kind:
    if fmi == "2.0":
        return kind
    if kind == "python":
        raise InputError("--fmi 3.0", expected="--kind native", got="python", todo="pythonfmu writes FMI 2.0")
    return "native3"


@click.command()
@click.option("--from", "source", type=click.Path(path_type=Path), required=True, help="An identification.json.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), required=True, help="The FMU to write.")
@click.option("--kind", type=click.Choice(["python", "native"]), default="python", show_default=True)
@click.option("--fmi", type=click.Choice(["2.0", "3.0"]), default="2.0", show_default=True, help="3.0: native alone.")
@click.option("--joints", default=None, metavar="4", help="This joint alone instead of the whole device.")
@click.option(
    "--with", "named", type=click.Path(path_type=Path), multiple=True, metavar="joint3.json",
    help="A discrepancy/joint<j>.json whose effects the whole device takes along; may be given several times.",
)  # fmt: skip
@click.option("--effects", type=click.Path(path_type=Path), default=None, help="Folder with the effects of your own.")
@click.option(
    "--device", default=None, metavar="FILE",
    help="The device's file, where identification.json names one outside its own folder.",
)  # fmt: skip
@exit_codes
def main(  # noqa: PLR0913, PLR0917 # one argument an option
    source: Path,
    out: Path,
    kind: Kind,
    fmi: str,
    joints: str | None,
    named: tuple[Path, ...],
    effects: Path | None,
    device: str | None,
) -> None:
    """Package the model that an identification.json holds.

    --with takes along what `discrepancy.run` named, at the values of its refit: into the 6-DOF FMU of all joints.
    """
    kind = _packaging(kind, fmi)
    data, wanted = read_identification(source), parse_joints(joints)
    if data["device"] == SINGLE or wanted:
        if named:
            todo = "discrepancy.run has written the FMU of a joint with its effects already"
            raise InputError("--with", expected="the whole device", got="a joint alone", todo=todo)
        joint = _only_joint(data, wanted)
        if "inertia" not in entries_of(data, joint):
            where = f"{source}: parameters of joint {joint}"
            raise InputError(where, expected="the key 'inertia'", got=", ".join(entries_of(data, joint)) or "none")
        fmu = export_joint(data, joint, out, kind)
    else:
        entries = with_folder(effects)
        findings = [read_finding(path, entries) for path in named]
        machine = device_of_results(device, data["device"], source)
        told = list(_taken(findings, data, machine, str(source)))
        fmu = export_full(machine, data, out, kind, findings)
        for line in told:
            click.echo(line)
    size = fmu.path.stat().st_size / 1024
    click.echo(f"{fmu.path}: {fmu.equations.title}; {fmu.kind}, FMI {fmi}, {size:.0f} kB, digest {fmu.digest}")


def device_of_results(given: str | None, recorded: str, source: Path) -> Device:
    """Return the device that the user names, else the recorded one, built in or from the results' own folder.

    A folder of results may come from a stranger: what it names elsewhere is read only where the user says so.
    """
    if given is not None:
        return load_device(given)
    if recorded in builtin_devices():
        return load_device(recorded)
    where, own = f"{source}: device", source.parent.resolve()
    path = (own / recorded).resolve() if recorded.isprintable() and len(recorded) < LONGEST_PATH else own
    if not path.is_relative_to(own):
        expected, todo = "a built-in name, or a file in the results' own folder", f"--device {recorded} if it is yours"
        raise InputError(where, expected=expected, got=repr(recorded), todo=todo)
    if not os.path.isfile(path):  # noqa: PTH113 # a name that is too long is no file, where Path.is_file raises
        todo = "--device FILE names the device's file"
        raise InputError(where, expected="a built-in name or a file", got=repr(recorded), todo=todo)
    return load_device(path)


def _taken(findings: Sequence[Finding], data: Mapping[str, Any], device: Device, source: str) -> Iterator[str]:
    """Say what of each finding went into the FMU, what stayed behind, and how far the joint's inertia had moved."""
    for f in findings:
        if f.joint >= len(device.joints):
            raise InputError("--with", expected=f"joints of {device.name}", got=f"joint {f.joint}")
        if f.effects:
            taken = ", ".join(e.id for e in f.effects)
            yield f"joint {f.joint}: {taken}; {_inertia_moved(f, data, source)}, links stay as identified"
        else:
            yield f"joint {f.joint}: nothing"
        yield from (f"  without {id}: {reason}" for id, reason in f.left)


def _inertia_moved(finding: Finding, data: Mapping[str, Any], source: str) -> str:
    before = entries_of(data, finding.joint).get("inertia", {"value": 0.0})["value"]
    after = finding.values.get(f"inertia_{finding.joint}")
    if before == 0.0 or after is None:
        where = f"{source}: joint {finding.joint}"
        raise InputError(where, expected="its inertia, identified and refitted", got="none")
    return f"its inertia moved by {100 * (after / before - 1):+.2g} % in the refit"


if __name__ == "__main__":
    main()
