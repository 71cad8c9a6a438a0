"""Calls of FMI 2.0 as a fuzzed reader: bytes are a script of calls on a native FMU, compiled with sanitizers.

There is a target where a C compiler is. Both packagings answer by the same C files, so the Python FMU is meant as well.
"""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from haptid.fmu_build.building.packaging import interface_for
from haptid.fmu_build.native.fmi2 import native_source
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from tests.fuzz.harness import Target

COMPILER = shutil.which("gcc") or shutil.which("clang")
FLAGS = ("-std=c99", "-O1", "-g", "-w", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
MACHINE = (0, 1)
"""Free joints: two, whose mass matrix need not be positive definite."""


@cache
def program() -> Path:
    """The compiled program, made once for each content."""
    interface = interface_for(configuration_equations(load_device("freedom6s"), MACHINE), kind="native")
    driver = Path(__file__).with_suffix(".c").read_text(encoding="utf-8")
    source = native_source(interface, "{fuzzed}") + "\n" + driver
    digest = hashlib.sha256(f"{FLAGS}{source}".encode()).hexdigest()[:16]
    made = Path(tempfile.gettempdir()) / f"haptid_fmi_calls_{os.getuid()}_{digest}"
    if not made.exists():
        with tempfile.TemporaryDirectory(dir=made.parent) as folder:
            path = Path(folder) / "all.c"
            path.write_text(source, encoding="utf-8")
            subprocess.run([str(COMPILER), *FLAGS, str(path), "-o", f"{folder}/program", "-lm"], check=True)
            Path(folder, "program").rename(made)
    return made


def read_calls(content: bytes, _folder: Path) -> None:
    """Play ``content`` as a script of calls."""
    # the address sanitizer reserves far more addresses than a reader may
    command = ["sh", "-c", 'ulimit -S -v unlimited; exec "$0"', str(program())]
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
    done = subprocess.run(command, input=content, capture_output=True, env=environment, timeout=60, check=False)
    if done.returncode != 0 or done.stdout != b"done\n":
        said = done.stderr.decode(errors="replace").strip()
        raise AssertionError(said[:2000] or f"the program ended by {done.returncode}")


def scripts() -> tuple[bytes, ...]:
    """Scripts that get into all modes: some calls that belong together, then any."""
    numbers = random.Random(0)
    begun = bytes([1, 2])
    made = []
    for interface in (0, 1):
        for _ in range(10):
            rest = numbers.randbytes(200)
            made.append(bytes([interface]) + begun + bytes([11, 1, 0]) * interface + rest)
    return tuple(made)


FMI_CALLS = (
    (
        Target(
            name="fmi_calls", examples=scripts(), read=read_calls, nasty=(bytes([1, 2]), bytes([30, 5, 1]), b"\x0b\1\0")
        ),
    )
    if COMPILER
    else ()
)
