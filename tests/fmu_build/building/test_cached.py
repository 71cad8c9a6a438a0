"""FMUs from the cache: built once, told apart by all that an FMU shows, native where pythonfmu has no loader."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.house import imports_of, reached_from, read_modules
from haptid.fmu_build.building.cached import (
    builder_digest,
    cached_fmu,
    description_digest,
    digested_files,
    identification_fmu,
)
from haptid.fmu_build.native.platforms import this_platform
from haptid.support.installing.environment import ROOT
from tests.fmu_build.fmu_cases import equations


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setattr("haptid.fmu_build.building.cached.cache_folder", lambda _: tmp_path)
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())


def test_built_once():
    e = equations("joint4")
    first = identification_fmu(e)
    stamp = first.path.stat().st_mtime_ns
    again = identification_fmu(e)
    assert again == first
    assert again.path.stat().st_mtime_ns == stamp


def test_first_guesses_tell_shipped_fmus_apart_but_not_those_of_fits():
    e = equations("joint4")
    other = e.with_parameters({"Ks": {"initial": 0.011}})
    assert description_digest(e) != description_digest(other)
    assert cached_fmu(e).path != cached_fmu(other).path
    assert identification_fmu(e).path == identification_fmu(other).path


def test_native_where_pythonfmu_has_no_loader(monkeypatch):
    monkeypatch.setattr("haptid.fmu_build.building.cached.FmuBuilder.has_binary", lambda: False)
    assert identification_fmu(equations("joint4"), kind="python").kind == "native"


@pytest.mark.parametrize(
    "name", ["fmu_names.py", "output_injection.py", "stepper.h", "fmi2_xml.py", "dahl.py", "effect.py", "thresholds.py"]
)
def test_other_code_that_writes_an_fmu_has_another_key(monkeypatch, name: str):
    before, read = builder_digest(), Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"# changed" * (path.name == name))
    assert builder_digest() != before


SERVICES = {"support.errors", "support.linear_algebra", "support.suggestion"}
"""Modules whose change leaves every archive as it is: messages of errors, and numbers by other routines."""


def test_every_module_that_builds_an_fmu_is_in_its_key():
    modules = read_modules(ROOT)
    known = {module.name for module in modules}
    graph = {module.name: imports_of(module, known) for module in modules}
    builders = reached_from(graph, "fmu_build.building.packaging")
    keyed = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in map(Path.resolve, digested_files())}
    others = builders - keyed - SERVICES
    left = {name for name in others if not name.startswith(("support.files.", "support.processes."))}
    assert "model.friction.registry" in builders
    assert left == set()
