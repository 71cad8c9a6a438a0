"""Describe which effects of findings the FMU of the whole device includes: findings in, sentences out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from haptid.fmu_build.exchange.discrepancy_json import Finding
from haptid.fmu_build.exchange.identification_check import check_joints
from haptid.fmu_build.exchange.identification_json import entries_of
from haptid.model.device.device import Device
from haptid.support.errors import InputError


def taken_along(findings: Sequence[Finding], data: Mapping[str, Any], device: Device, source: str) -> Iterator[str]:
    """Describe the effects of each finding that the FMU of the whole device includes, and those that it does not.

    Parameters
    ----------
    findings
        One per joint.
    data
        Content of the ``identification.json``, for the inertia before the refit.
    device
        Device of the results.
    source
        Name of the ``identification.json``, for errors.

    Yields
    ------
    str
        Sentences with the effects, the change of the joint's inertia in the refit [%], and the reason for each effect
        that is not included.

    Raises
    ------
    InputError
        Where the device has no such joint, or an inertia is missing.
    """
    for f in findings:
        check_joints([f.joint], device, f"{f.source}: joint")
        if f.effects:
            taken = ", ".join(e.id for e in f.effects)
            yield f"joint {f.joint}: {taken}; {_inertia_moved(f, data, source)}, links stay as identified"
        else:
            yield f"joint {f.joint}: nothing"
        yield from (f"  without {id}: {reason}" for id, reason in f.left)


def _inertia_moved(finding: Finding, data: Mapping[str, Any], source: str) -> str:
    before = {id: entry["value"] for id, entry in entries_of(data, finding.joint).items()}
    after = {id.removesuffix(f"_{finding.joint}"): value for id, value in finding.values.items()}
    for values, where in ((before, f"{source}: joint {finding.joint}"), (after, f"{finding.source}: refit")):
        if "inertia" not in values:
            raise InputError(where, expected="its inertia, identified and refitted", got="none")
    return f"its inertia moved by {100 * (after['inertia'] / before['inertia'] - 1):+.2g} % in the refit"
