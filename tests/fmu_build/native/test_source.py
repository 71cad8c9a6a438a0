"""The C source of the native FMU: any C99 compiler takes it, and the binaries for other platforms export FMI."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.fmu_build.native.platforms import PLATFORMS
from haptid.support.processes.c_compiler import run_c_compiler
from tests.fmu_build.exports import exported
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


def unpacked_source(kind: Kind, tmp_path: Path) -> Path:
    with zipfile.ZipFile(fmu("joint4", kind).path) as archive:
        (tmp_path / "all.c").write_bytes(archive.read("sources/all.c"))
    return tmp_path / "all.c"


def compile_c(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMPILER, *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.mark.skipif(COMPILER is None, reason="no C compiler on this machine; the project needs none")
@pytest.mark.parametrize(("kind", "version"), [("native", 2), ("native3", 3)])
def test_two_fmus_can_be_linked_into_one_program(kind: Kind, version: int, tmp_path):
    source = unpacked_source(kind, tmp_path)
    for prefix in ("one_", "two_"):
        names = f"-DFMI{version}_FUNCTION_PREFIX={prefix}"
        done = compile_c("-std=c99", "-O1", "-fPIC", names, "-c", source, "-o", tmp_path / f"{prefix}.o")
        assert done.returncode == 0, done.stderr
    both = tmp_path / "both.so"
    assert compile_c("-shared", tmp_path / "one_.o", tmp_path / "two_.o", "-o", both, "-lm").returncode == 0
    library = ctypes.CDLL(str(both))
    for prefix in ("one_", "two_"):
        function = getattr(library, f"{prefix}fmi{version}GetVersion")
        function.restype = ctypes.c_char_p
        assert function() == f"{version}.0".encode()
    assert not hasattr(library, f"fmi{version}DoStep")
    names = exported(both)
    assert len(names) == 2 * len({name.partition("_")[2] for name in names})


@pytest.mark.skipif(COMPILER is None, reason="no C compiler on this machine; the project needs none")
@pytest.mark.parametrize("flag", ["-ffast-math", "-ffinite-math-only"])
def test_arithmetic_that_would_be_wrong_is_refused(flag: str, tmp_path):
    done = compile_c("-O2", flag, "-c", unpacked_source("native", tmp_path), "-o", tmp_path / "all.o")
    assert done.returncode != 0
    assert "expected arithmetic by IEEE 754" in done.stderr


def test_wrong_arithmetic_that_no_macro_tells_of_is_refused_at_instantiation(tmp_path):
    """Clang's -funsafe-math-optimizations defines nothing; the whole device was wrong by 0.3 rad, without a word."""
    folder = tmp_path / "fmu"
    with zipfile.ZipFile(fmu("joint4", "native").path) as archive:
        archive.extractall(folder)
    (binary,) = (folder / "binaries").glob("*/*")
    flags = ["-std=c99", "-O2", "-funsafe-math-optimizations", "-shared", "-fPIC"]
    run_c_compiler([*flags, "sources/all.c", "-o", str(binary.relative_to(folder)), "-lm"], folder)
    packed = shutil.move(shutil.make_archive(str(tmp_path / "unsafe"), "zip", folder), tmp_path / "unsafe.fmu")
    client = object.__new__(Client)
    with pytest.raises(Exception, match="Failed to instantiate"):
        client.__init__(packed)
    assert client.messages == ["expected arithmetic by IEEE 754, got a part of -ffast-math: compile without it"]


def test_no_multiplication_is_fused_with_an_addition(tmp_path):
    source = unpacked_source("native", tmp_path)
    text, target = tmp_path / "all.s", "aarch64-linux-gnu.2.17"
    run_c_compiler(
        ["-target", target, "-O3", "-g0", "-fno-sanitize=undefined", "-S", source.name, "-o", text.name], tmp_path
    )
    assert b"fmul" in text.read_bytes()
    assert not re.search(rb"\b(fmadd|fmsub|fnmadd|fnmsub|fmla|fmls)\b", text.read_bytes())


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


@pytest.mark.long
@pytest.mark.parametrize("kind", ["native", "native3", "python"])
def test_binaries_are_the_same_bytes_wherever_they_are_built_and_hold_no_path(kind: Kind, tmp_path, monkeypatch):
    archives = []
    for folder in (tmp_path / "here", tmp_path / "elsewhere" / "deeper"):
        folder.mkdir(parents=True)
        monkeypatch.setenv("HAPTID_CACHE", str(folder))
        built = build_fmu(equations("joint4"), folder / "all.fmu", kind=kind, platforms=PLATFORMS)
        archives.append(built.path.read_bytes())
        with zipfile.ZipFile(built.path) as archive:
            content = [archive.read(name) for name in archive.namelist()]
        for name in (str(tmp_path), tmp_path.name, str(Path.home()), tempfile.gettempdir()):
            assert not [data for data in content if name.encode() in data], name
    assert archives[0] == archives[1]
