"""Results that are read again, and archives of FMUs, as targets of fuzzing."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import fmpy

from haptid.fmu_build.exchange.discrepancy_json import apply_refits, read_finding
from haptid.fmu_build.exchange.identification_check import check_for_device, check_orders
from haptid.fmu_build.exchange.identification_json import Identified, of_device, of_joint, read_identification
from haptid.fmu_build.exchange.recorded_device import device_of_results
from haptid.fmu_build.exchange.start_values import with_start_values
from haptid.identification.foreign.archive import unpack_checked
from haptid.model.device.reader import load_device
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.virtual_device.recording.planned import read_planned
from tests.fmu_build.ssv_cases import GOOD
from tests.fuzz.harness import Target
from tests.identification.foreign_cases import DESCRIPTION

PARAMETER = {"value": 2.2e-4, "std": 1e-6, "unit": "kg m^2", "status": "identified", "lower": 0.0, "upper": None}
SPRING = PARAMETER | {"unit": "N m/rad"}
IDENTIFICATION = {
    "schema": "identification/1", "device": "freedom6s", "campaign": "a test", "measured": False,
    "configurations": [
        {"free_joints": [4], "parameters": {"inertia": PARAMETER, "Ks": SPRING}},
        {"free_joints": [0, 1], "parameters": {"Ks_0": SPRING, "M01_c1": PARAMETER}},
    ],
    "links": {"6": {"m": {"value": 0.1}, "I11": PARAMETER}}, "whole": {"Ks_4": 0.01},
    "verification": {"runs": [{"file": "a.csv", "mode": "open_loop", "joints": [{"joint": 4, "spread_rad": None}]}]},
}  # fmt: skip
FINDING = {
    "schema": "discrepancy/1", "joint": 4, "measured": False, "verdict": "named",
    "effects": [{"id": "cubic_spring", "variant": None, "parameters": {"k3": {"value": 0.03, "std": 0.001}}}],
    "refit": {"inertia": 2.2e-4, "k3": 0.03},
}  # fmt: skip
DEVICE = load_device("freedom6s")
JOINT = joint_equations(4)
PLAN = {"postures": {"tests": [{"free_joints": [4], "locked_positions_rad": [0, 0.1, 0, 0, 0, 0]}]}}


def _bytes(value: object) -> bytes:
    return json.dumps(value, indent=1).encode()


def read_identification_file(content: bytes, folder: Path) -> None:
    """Read ``content`` as an identification.json, with what the export takes from it."""
    path = folder / "identification.json"
    path.write_bytes(content)
    data = read_identification(path)
    check_for_device(data, DEVICE, str(path))
    check_orders(of_device(data).values, DEVICE, str(path))
    for configuration in data["configurations"]:
        if len(configuration["free_joints"]) == 1:
            of_joint(data, configuration["free_joints"][0])
    if data["device"] != IDENTIFICATION["device"]:  # to read the built-in one again and again would only take time
        device_of_results(None, data, path)


def read_finding_file(content: bytes, folder: Path) -> None:
    """Read ``content`` as a discrepancy/joint<j>.json, with the effects that it names."""
    path = folder / "joint4.json"
    path.write_bytes(content)
    apply_refits(of_device(IDENTIFICATION), [read_finding(path, catalogue())])


def read_ssv_file(content: bytes, folder: Path) -> None:
    """Read ``content`` as the parameter set from which the FMU of a joint starts."""
    (folder / "parameters.ssv").write_bytes(content)
    with_start_values(Identified(values={}, provenance={}), folder / "parameters.ssv", JOINT)


def read_plan_file(content: bytes, folder: Path) -> None:
    """Read ``content`` as a locking_plan.json."""
    (folder / "locking_plan.json").write_bytes(content)
    read_planned(folder / "locking_plan.json")


def _archive() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in _files(DESCRIPTION.encode()).items():
            archive.writestr(zipfile.ZipInfo(name), data)
    return stream.getvalue()


def _files(description: bytes) -> dict[str, bytes]:
    library = f"binaries/{fmpy.platform}/small{fmpy.sharedLibraryExtension}"
    return {"modelDescription.xml": description, library: b"is not loaded here", "resources/a.txt": 100 * b"a"}


def read_fmu(content: bytes, folder: Path) -> None:
    """Unpack ``content`` as an FMU; nothing may come to lie beside its folder."""
    path, inside = folder / "a.fmu", folder / "unpacked"
    path.write_bytes(content)
    inside.mkdir()
    unpack_checked(path, inside)


def read_description(content: bytes, folder: Path) -> None:
    """Unpack a whole archive whose modelDescription.xml is ``content``."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in _files(content).items():
            archive.writestr(name, data)
    read_fmu(stream.getvalue(), folder)


XML = (b"<ssv:Real value='1'/>", b"<ssc:Annotations>", b'unit="N m/deg"', b"&lt;", b"&a;", b"<![CDATA[", b"<!--")
KEYS = (b'"schema"', b'"value"', b'"../x.toml"', b'"configurations": []', b'"free_joints": [4, 4]', b'"joint": 77')
RESULTS = (
    Target(name="identification", examples=(_bytes(IDENTIFICATION),), read=read_identification_file, nasty=KEYS),
    Target(name="discrepancy", examples=(_bytes(FINDING),), read=read_finding_file, nasty=KEYS),
    Target(name="ssv", examples=(GOOD.encode(),), read=read_ssv_file, nasty=XML),
    Target(name="locking_plan", examples=(_bytes(PLAN),), read=read_plan_file, nasty=KEYS),
    Target(name="fmu", examples=(_archive(),), read=read_fmu, nasty=(b"PK\x03\x04", b"PK\x01\x02", b"PK\x05\x06")),
    Target(
        name="model_description", examples=(DESCRIPTION.encode(),), read=read_description,
        nasty=(b'fmiVersion="3.0"', b"&lt;", b"&a;", b"<![CDATA[", b"<!--", b'encoding="UTF-16"', b"<Real/>"),
    ),
)  # fmt: skip
