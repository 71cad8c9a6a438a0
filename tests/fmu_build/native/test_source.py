"""The C source of the native FMU: any C99 compiler takes it, and the binaries for other platforms export FMI."""

from __future__ import annotations

import shutil
import subprocess
import zipfile

import numpy as np
import pytest

from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.native.platforms import PLATFORMS
from tests.fmu_build.fmu_cases import STEP, Client, equations, fmu, initial, kernel, torques

COMPILER = shutil.which("cc") or shutil.which("gcc")
FLAGS = (
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-Wall",
    "-Wextra",
    "-Wno-unused",
    "-Werror",
    "-shared",
    "-fPIC",
)


@pytest.mark.skipif(COMPILER is None, reason="no C compiler on this machine; the project needs none")
@pytest.mark.parametrize("name", ["joint4", "freedom6s"])
def test_another_compiler_takes_the_source_and_gives_the_same_bits(name: str, tmp_path):
    built = fmu(name, "native")
    with zipfile.ZipFile(built.path) as archive:
        archive.extractall(tmp_path / "fmu")
    (binary,) = (tmp_path / "fmu" / "binaries").glob("*/*")
    source = tmp_path / "fmu" / "sources" / "all.c"
    done = subprocess.run([COMPILER, *FLAGS, source, "-o", binary, "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    again = shutil.make_archive(str(tmp_path / "again"), "zip", tmp_path / "fmu")
    e, t = equations(name), STEP * np.arange(101)
    got = Client(shutil.move(again, tmp_path / "again.fmu")).start().go().run(e, t, torques(e, t))
    expected = kernel(name).simulate(t, torques(e, t), initial(e), np.zeros(len(e.states)))
    np.testing.assert_array_equal(got, expected)


def test_binaries_of_every_platform_export_fmi(tmp_path):
    built = build_fmu(equations("joint4"), tmp_path / "all.fmu", kind="native", platforms=PLATFORMS)
    with zipfile.ZipFile(built.path) as archive:
        binaries = [archive.read(name) for name in archive.namelist() if name.startswith("binaries/")]
    assert len(binaries) == 5
    for binary in binaries:
        for function in (
            b"fmi2DoStep",
            b"fmi2GetDerivatives",
            b"fmi2DeSerializeFMUstate",
            b"fmi2GetDirectionalDerivative",
        ):
            assert function in binary


def test_the_binary_needs_no_library(tmp_path):
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm is not installed")
    with zipfile.ZipFile(fmu("freedom6s", "native").path) as archive:
        name = next(name for name in archive.namelist() if name.startswith("binaries/"))
        path = tmp_path / "model.so"
        path.write_bytes(archive.read(name))
    undefined = subprocess.run([nm, "-D", "--undefined-only", path], capture_output=True, text=True, check=True).stdout
    assert undefined.strip() == ""
