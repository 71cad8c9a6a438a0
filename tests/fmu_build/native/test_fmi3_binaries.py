"""FMI 3.0: what the binaries export and need, other compilers, reproducible bytes."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest

from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.native.platforms import PLATFORMS, Platform, this_platform
from tests.fmu_build.exports import exported
from tests.fmu_build.fmi3_client import FMPY, Client3, fmu3
from tests.fmu_build.fmu_cases import FOLDER, STEP, equations, fmu, torques
from tests.fmu_build.native.test_source import COMPILER, FLAGS

T = STEP * np.arange(101)


@pytest.fixture(scope="module")
def everywhere() -> Path:
    """The FMU of joint 4 for all platforms, unpacked."""
    built = build_fmu(equations("joint4"), FOLDER / "everywhere.fmu", kind="native3", platforms=PLATFORMS)
    return Path(fmpy.extract(str(built.path), unzipdir=str(FOLDER / "everywhere")))


@pytest.mark.parametrize("platform", PLATFORMS, ids=lambda p: p.fmi3)
def test_binaries_of_every_platform_export_all_of_fmi_3_and_nothing_else(everywhere: Path, platform: Platform):
    header = (FMPY / "c-code" / "fmi3FunctionTypes.h").read_text()
    functions = set(re.findall(r"\b(fmi3\w+)TYPE\b", header))
    assert len(functions) > 70
    binary = everywhere / "binaries" / platform.fmi3 / f"joint4{platform.suffix}"
    assert {name for name in exported(binary) if name.startswith("fmi")} == functions


def test_the_linux_binary_asks_for_memory_alone(everywhere: Path):
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm is not installed")
    path = everywhere / "binaries" / "x86_64-linux" / "joint4.so"
    undefined = subprocess.run([nm, "-D", "--undefined-only", path], capture_output=True, text=True, check=True).stdout
    assert undefined.split() == ["U", "calloc", "U", "free"]


@pytest.mark.skipif(COMPILER is None, reason="no C compiler on this machine; the project needs none")
def test_another_compiler_takes_the_source_and_gives_the_same_bits(tmp_path: Path):
    unpacked = Path(fmpy.extract(str(fmu3().path), unzipdir=str(tmp_path / "fmu")))
    (binary,) = (unpacked / "binaries").glob("*/*")
    command = [COMPILER, *FLAGS, unpacked / "sources" / "all.c", "-o", binary]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    again = shutil.move(shutil.make_archive(str(tmp_path / "again"), "zip", unpacked), tmp_path / "again.fmu")
    e, u = equations("joint4"), torques(equations("joint4"), T)
    expected = Client3(fmu3()).start().go().run(e, T, u)
    np.testing.assert_array_equal(Client3(again).start().go().run(e, T, u), expected)


def test_the_same_content_gives_the_same_bytes(tmp_path: Path):
    first, second = (
        build_fmu(equations("joint4"), tmp_path / name, kind="native3", platforms=this_platform())
        for name in ("one.fmu", "two.fmu")
    )
    assert first.path.read_bytes() == second.path.read_bytes()
    third = build_fmu(equations("joint4"), tmp_path / "third.fmu", kind="native3", values={"Ks": 0.02}, platforms=())
    tokens = {fmpy.read_model_description(str(x.path)).guid for x in (first, second, third, fmu("joint4", "native"))}
    assert len(tokens) == 3
