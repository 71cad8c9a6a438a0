"""Where the resources of a Python FMU lie: every spelling of a path is found, and what is missing ends no host.

A host of its own is asked each time: what is tried here ended it before the guard decoded the path and looked.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

import fmpy
import pytest

from tests.fmu_build.fmu_cases import fmu

HOST = """
import sys
import fmpy
from fmpy.fmi2 import *
folder, uri = sys.argv[1:]
callbacks = fmi2CallbackFunctions()
callbacks.logger = fmi2CallbackLoggerTYPE(lambda _, __, status, category, message: print(status, message.decode()))
callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
about = fmpy.read_model_description(folder)
slave = FMU2Slave(guid=about.guid, unzipDirectory=folder, modelIdentifier=about.coSimulation.modelIdentifier)
made = slave.fmi2Instantiate(b"a", 1, about.guid.encode(), uri.encode(), byref(callbacks), 0, 0)
print("made" if made else "refused")
"""


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unpacked") / "fmu"
    fmpy.extract(str(fmu("joint4", "python").path), unzipdir=str(folder))
    return folder


def told(folder: Path, uri: str) -> list[str]:
    command = [sys.executable, "-B", "-c", HOST, str(folder), uri]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize("name", ["plain", "mit Blank", "Prüfstand Ø", "a#b?c", "q\"'&;", "100%", "a%41b", "a\\b"])
def test_a_uri_is_decoded(name: str, unpacked: Path, tmp_path: Path):
    folder = shutil.copytree(unpacked, tmp_path / name)
    assert told(folder, (folder / "resources").as_uri()) == ["made"]


@pytest.mark.parametrize("form", ["{}", "file:{}", "file://{}", "file://localhost{}", "file://{}/"])
def test_every_form_is_understood(form: str, unpacked: Path):
    assert told(unpacked, form.format(quote(str(unpacked / "resources")))) == ["made"]


@pytest.mark.parametrize(
    "uri", ["", "resources", "http://a/b", "file:", "file:///", "file:///%00", "file:///a%", "/" * 9999]
)
def test_what_is_no_such_folder_is_refused(uri: str, unpacked: Path):
    message, end = told(unpacked, uri)
    assert end == "refused"
    assert message.startswith("3 resource location: expected ")


def test_a_message_may_be_printed_as_printf_does(unpacked: Path, tmp_path: Path):
    """A host's logger takes the text as a format: a per cent sign of the path ended it, or wrote anywhere."""
    folder = tmp_path / "%n%s 50% a#r5#b" / "resources"
    message, end = told(unpacked, folder.as_uri())
    assert end == "refused"
    path = str(folder).replace("#", "##")
    assert (message % ()).endswith(f"got {path}/slavemodule.txt")


def test_a_name_that_the_loader_cannot_take_is_told(unpacked: Path, tmp_path: Path):
    folder = shutil.copytree(unpacked, tmp_path / "a%20b")
    message, end = told(folder, (folder / "resources").as_uri())
    assert end == "refused"
    assert "a path without %20" in message % ()


@pytest.mark.parametrize("lost", ["", "slavemodule.txt", "joint4_*[0-9a-f].py", "joint4_*_slave.py", "plan.json"])
def test_what_is_missing_is_told(lost: str, unpacked: Path, tmp_path: Path):
    folder = shutil.copytree(unpacked, tmp_path / "fmu")
    resources = folder / "resources"
    for path in list(resources.glob(lost)) if lost else []:
        path.unlink()
    if not lost:
        shutil.rmtree(resources)
    *messages, end = told(folder, resources.as_uri())
    assert end == "refused"
    assert messages


ONE_PLACE = """
import shutil
import sys
import fmpy
place, *archives = sys.argv[1:]
for archive in archives:
    shutil.rmtree(place, ignore_errors=True)
    fmpy.extract(archive, unzipdir=place)
    rows = fmpy.simulate_fmu(place, stop_time=0.1, output_interval=0.005)
    print(rows[rows.dtype.names[1]].tobytes().hex())
"""


def test_one_fmu_unpacked_where_another_was_is_itself(tmp_path: Path):
    """A process loads a library once for each path, and this process has loaded the first FMU's from there."""

    def rows_of(*names: str) -> list[str]:
        paths = [str(fmu(name, "python").path) for name in names]
        command = [sys.executable, "-B", "-c", ONE_PLACE, str(tmp_path / "place"), *paths]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        return done.stdout.splitlines()

    assert rows_of("joint4", "freedom6s")[1] == rows_of("freedom6s")[0]
