"""Calls of FMI as a fuzzed reader: bytes are a script of calls on a native FMU, compiled with sanitizers.

There are targets where a C compiler is: FMI 2.0 and 3.0, of a joint and of two joints, whose mass matrix need not be
positive definite. Both packagings of FMI 2.0 answer by the same C files, so the Python FMU is meant as well.

A program plays one script after another, since a start under the address sanitizer takes longer than most scripts.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import random
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import IO

from haptid.fmu_build.building.packaging import interface_for
from haptid.fmu_build.native.fmi2 import native_source
from haptid.fmu_build.native.fmi3 import native_source3
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from tests.fuzz.harness import Target

COMPILER = shutil.which("gcc") or shutil.which("clang")
FLAGS = ("-std=gnu99", "-O1", "-g", "-w", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
C_FILES = Path(__file__).parent / "fmi"
RENAMED = "#define calloc give_memory\n#define free take_memory\n"
"""What counts the memory of an FMU, which in FMI 3.0 takes it from the process."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """An FMU that is fuzzed.

    Parameters
    ----------
    name
        Name of the target.
    version
        Version of FMI, 2 or 3.
    free
        Free joints.
    identification
        Whether it is an FMU for identification, which has a switch, slopes of inputs and sensitivities.
    begin
        Scripts' first bytes that get an instance of each interface going; what follows in them is any.
    """

    name: str
    version: int
    free: tuple[int, ...]
    begin: tuple[bytes, ...]
    identification: bool = False

    def source(self) -> str:
        """The C source of FMU and script player."""
        equations = configuration_equations(load_device("freedom6s"), self.free)
        interface = interface_for(equations, kind="native", identification=self.identification)
        fmu = (native_source if self.version == 2 else native_source3)(interface, "{fuzzed}")
        player = [(C_FILES / name).read_text(encoding="utf-8") for name in ("script.c", f"fmi{self.version}.c")]
        return "\n".join((RENAMED, fmu, *player))


@cache
def program(machine: Machine) -> Path:
    """The compiled program, made once for each content."""
    source = machine.source()
    digest = hashlib.sha256(f"{FLAGS}{source}".encode()).hexdigest()[:16]
    made = Path(tempfile.gettempdir()) / f"haptid_{machine.name}_{os.getuid()}_{digest}"
    if not made.exists():
        with tempfile.TemporaryDirectory(dir=made.parent) as folder:
            path = Path(folder) / "all.c"
            path.write_text(source, encoding="utf-8")
            subprocess.run([str(COMPILER), *FLAGS, str(path), "-o", f"{folder}/program", "-lm"], check=True)
            Path(folder, "program").rename(made)
    return made


@dataclass(slots=True)
class Player:
    """The running program of a machine: a new one after it has died."""

    machine: Machine
    process: subprocess.Popen[bytes] | None = None
    complaints: IO[bytes] = field(default_factory=tempfile.TemporaryFile)

    def start(self) -> subprocess.Popen[bytes]:
        """Start the program where none runs."""
        if self.process is None:
            # the address sanitizer reserves far more addresses than a reader may; blocks of memory are counted anyway
            command = ["sh", "-c", 'ulimit -S -v unlimited; exec "$0"', str(program(self.machine))]
            environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.complaints, env=environment
            )
        return self.process

    def play(self, script: bytes) -> None:
        """Play a script.

        Raises
        ------
        AssertionError
            With what the sanitizers say, where the program ends.
        """
        process = self.start()
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(len(script).to_bytes(4, "little") + script)
            process.stdin.flush()
            answer = process.stdout.readline()
        except BrokenPipeError:
            answer = b""
        if answer == b"done\n":
            return
        code = self.end()
        self.complaints.seek(0)
        said = self.complaints.read().decode(errors="replace").strip()
        self.complaints.truncate(0)
        raise AssertionError(said[:2000] or f"the program ended by {code}")

    def end(self) -> int:
        """End the program; its exit code."""
        if self.process is None:
            return 0
        self.process.communicate()
        code, self.process = self.process.returncode, None
        return code


@cache
def player(machine: Machine) -> Player:
    """The player of a machine in this process."""
    made = Player(machine)
    atexit.register(made.end)
    return made


def scripts(machine: Machine) -> tuple[bytes, ...]:
    """Scripts that get into all modes: some calls that belong together, then any."""
    numbers = random.Random(0)
    return tuple(begin + numbers.randbytes(200) for begin in machine.begin for _ in range(10))


FMI2 = (
    bytes([0, 1, 2]),
    bytes([1, 1, 2, 20]),
    bytes([0, 1, 2, 6, 1, 0, 9, 0, 1, 39, 4, 1]),
)
"""Co-simulation; model exchange in continuous-time mode; co-simulation with a torque of 1e300 N m and a step."""
FMI3 = (
    bytes([0, 0, 0, 0, 0, 1]),
    bytes([1, 0, 0, 0, 0, 1, 18]),
    bytes([0, 0, 0, 0, 0, 1, 5, 1, 0, 9, 0, 1, 1, 37, 4, 1, 1]),
)
TESTED = 500
"""Inputs of a run of the tests, of each machine."""
MACHINES = (
    Machine(name="fmi_calls", version=2, free=(0, 1), begin=FMI2),
    Machine(name="fmi_calls_identification", version=2, free=(4,), identification=True, begin=FMI2),
    Machine(name="fmi3_calls", version=3, free=(0, 1), begin=FMI3),
    Machine(name="fmi3_calls_joint", version=3, free=(4,), begin=FMI3),
)


def target(machine: Machine) -> Target:
    """The target of a machine."""

    def read(content: bytes, _folder: Path) -> None:
        player(machine).play(content)

    return Target(name=machine.name, examples=scripts(machine), read=read, nasty=machine.begin, tested=TESTED)


FMI_CALLS = tuple(target(machine) for machine in MACHINES) if COMPILER else ()
