"""The same bits on every platform: binaries of FMUs on their reference runs, by qemu and wine where they are foreign.

A small host in C is cross-compiled beside them. What runs on no machine here (macOS) is built a second time, in another
cache and another temporary folder, and compared byte for byte, as all archives are. Debian's packages qemu-user,
libc6-arm64-cross and wine64 have what this needs; a platform whose emulator is missing is stored with the reason.
Results go to ``docs/results/platforms.json`` and to the page on FMUs.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from zipfile import ZipFile

import fmpy
import numpy as np

from benchmarks.simulators import page, whole
from benchmarks.simulators.drivers import Array, Drive, drive_of
from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.fmu_build.native.platforms import PLATFORMS, Platform, this_platform
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.support.files.files import write_json
from haptid.support.processes.c_compiler import run_c_compiler
from haptid.support.terminal import Count
from studies.ledger.version import origin_of

OUT = Path(__file__).parents[2] / "docs" / "results" / "platforms.json"
HOST = Path(__file__).with_suffix(".c")
STEPPED: tuple[Literal["native", "native3"], ...] = ("native", "native3")
BUILT: tuple[Kind, ...] = ("python", "native", "native3")
LIMIT_S = 600
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
"""Where Debian keeps the C library of aarch64."""
PLACES = re.compile(rb"/(?:tmp|root|home|work|Users|var|private)/[\w./-]+")
"""A path on the machine that built something."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Emulator:
    """What runs programs of a platform here.

    Parameters
    ----------
    name
        As a reader knows it.
    command
        What stands before the program; empty where it runs as it is.
    missing
        Why there is none; empty where there is.
    version
        First line of what it says of itself.
    """

    name: str
    command: tuple[str, ...] = ()
    missing: str = ""
    version: str = ""


def _first_line(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return (done.stdout.splitlines() or [""])[0].strip()


def emulator_of(target: Platform) -> Emulator:
    """Return what runs programs of a platform here."""
    if target in this_platform():
        return Emulator(name="this machine", version=platform.machine())
    if target.python == "linux-aarch64":
        program = shutil.which("qemu-aarch64")
        if program and ARM_LIBRARIES.is_dir():
            words = _first_line(program, "--version")
            return Emulator(name="qemu", command=(program, "-L", str(ARM_LIBRARIES)), version=words)
        return Emulator(name="qemu", missing="qemu-user or libc6-arm64-cross is not installed")
    if target.python == "win32-x86_64":
        program = shutil.which("wine64") or shutil.which("wine")
        if program:
            return Emulator(name="wine", command=(program,), version=_first_line(program, "--version"))
        return Emulator(name="wine", missing="wine64 is not installed")
    return Emulator(name="none", missing="no emulator of macOS runs here")


def cases() -> Iterator[tuple[Equations, Mapping[str, float] | None]]:
    """Yield a joint, two joints and the whole device at its identified values."""
    for free in ((4,), (0, 1)):
        yield configuration_equations(whole.device(), free), None
    yield whole.equations(), whole.values()


def build(folder: Path) -> dict[tuple[str, Kind], Path]:
    """Build the FMUs in all packagings for all platforms."""
    fmus = {}
    for equations, values in cases():
        for kind in BUILT:
            path = folder / kind / f"{equations.name}.fmu"
            fmus[equations.name, kind] = build_fmu(equations, path, kind=kind, values=values).path
    return fmus


def compile_host(target: Platform, folder: Path) -> Path:
    """Compile the host in C for a platform."""
    shutil.copy(HOST, folder / HOST.name)
    name = f"host_{target.python}{'.exe' if target.suffix == '.dll' else ''}"
    libraries = () if target.suffix == ".dll" else ("-ldl",)
    run_c_compiler(["-target", target.triple, "-O1", "-w", HOST.name, "-o", name, *libraries], folder)
    return folder / name


def plan_of(archive: Path, drive: Drive) -> bytes:
    """Return what the host reads: sizes, value references, times and inputs."""
    references = {v.name: int(v.valueReference) for v in fmpy.read_model_description(str(archive)).modelVariables}
    numbers = [references[name] for name in (*drive.inputs, *drive.outputs)]
    sizes = (drive.t.size, len(drive.inputs), len(drive.outputs))
    head = struct.pack(f"<{3 + len(numbers)}I", *sizes, *numbers)
    return head + np.column_stack([drive.t, drive.u]).astype("<f8").tobytes()


def binary_of(archive: Path, target: Platform) -> str:
    """Return the name of a platform's binary within an archive."""
    about = fmpy.read_model_description(str(archive))
    place = target.fmi3 if about.fmiVersion[0] == "3" else target.fmi2[0]
    return f"binaries/{place}/{about.coSimulation.modelIdentifier}{target.suffix}"


def size_of(archive: Path, target: Platform) -> int:
    """Return the size of a platform's binary [bytes]."""
    with ZipFile(archive) as files:
        return files.getinfo(binary_of(archive, target)).file_size


def step(archive: Path, drive: Drive, target: Platform, host: Path, emulator: Emulator) -> Array:
    """Step a platform's binary through the reference run.

    Raises
    ------
    RuntimeError
        With the host's own words, where it fails.
    """
    about = fmpy.read_model_description(str(archive))
    version = about.fmiVersion[0]
    own_wine = {"WINEPREFIX": str(host.parent / "wine"), "WINEDEBUG": "-all"}
    with tempfile.TemporaryDirectory() as name:
        with ZipFile(archive) as files:
            binary = Path(files.extract(binary_of(archive, target), name)).rename(Path(name) / f"model{target.suffix}")
        host = Path(shutil.copy(host, name))
        # a bare name means another place to a loader of libraries than to Windows
        own = binary.name if target.suffix == ".dll" else f"./{binary.name}"
        done = subprocess.run(
            [*emulator.command, f"./{host.name}", own, version, about.guid], cwd=name, input=plan_of(archive, drive),
            capture_output=True, env={**own_wine, **os.environ}, timeout=LIMIT_S, check=False,
        )  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stderr.decode(errors="replace").strip() or f"exit code {done.returncode}")
    return np.frombuffer(done.stdout, dtype="<f8").reshape(drive.t.size, len(drive.outputs))


def run_all(fmus: Mapping[tuple[str, Kind], Path], folder: Path) -> list[dict[str, Any]]:
    """Step every native FMU on every platform that runs here; one row each."""
    rows = []
    for target in PLATFORMS:
        emulator = emulator_of(target)
        size = size_of(fmus["joint4", "native"], target)
        about = {"platform": target.fmi3, "by": emulator.name, "version": emulator.version, "joint_bytes": size}
        if emulator.missing:
            rows.append({**about, "missing": emulator.missing})
            continue
        host = compile_host(target, folder)
        for (name, kind), archive in Count(list(fmus.items()), title=target.fmi3):
            if kind not in STEPPED:
                continue
            drive = drive_of(archive)
            outputs = step(archive, drive, target, host, emulator)
            rows.append({
                **about, "fmu": name, "kind": kind, "rows": drive.t.size, "columns": len(drive.outputs),
                "sha256": hashlib.sha256(outputs.tobytes()).hexdigest(),
                "largest_difference": float(np.abs(outputs - drive.y[: drive.t.size]).max()),
            })  # fmt: skip
    return rows


def build_again(folder: Path) -> dict[tuple[str, Kind], Path]:
    """Build the same FMUs in a process with a cache and a temporary folder of its own."""
    own = {"HAPTID_CACHE": str(folder / "another cache"), "TMPDIR": str(folder / "another temporary folder")}
    for path in own.values():
        Path(path).mkdir()
    command = [sys.executable, "-m", "benchmarks.simulators.platforms", "--build-only", str(folder / "again")]
    subprocess.run(command, env={**os.environ, **own}, check=True)
    return {(path.stem, kind): path for kind in BUILT for path in (folder / "again" / kind).glob("*.fmu")}


def compare_archives(first: Mapping[tuple[str, Kind], Path], second: Mapping[tuple[str, Kind], Path]) -> dict[str, Any]:
    """Compare two builds byte for byte, and look for paths of the builder's machine in what is ours."""
    same = [key for key in first if first[key].read_bytes() == second[key].read_bytes()]
    places = set()
    for path in first.values():
        with ZipFile(path) as files:
            for name in files.namelist():
                if "pythonfmu-export" not in name:  # pythonfmu's own loaders, as PyPI has them
                    places |= {f"{name}: {place.decode()}" for place in PLACES.findall(files.read(name))}
    return {"built_twice": len(first), "same_bytes": len(same), "places": sorted(places)}


def main() -> None:
    """Build, step on all platforms, build again, compare; write results and page."""
    if sys.argv[1:2] == ["--build-only"]:
        build(Path(sys.argv[2]))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmus = build(folder)
        rows = run_all(fmus, folder)
        archives = compare_archives(fmus, build_again(folder))
    write_json(
        OUT,
        {
            **origin_of("python -m benchmarks.simulators.platforms"),
            "rows": rows,
            "archives": archives,
        },
    )
    page.write()


if __name__ == "__main__":
    main()
