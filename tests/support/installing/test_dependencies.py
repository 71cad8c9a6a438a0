"""Every package that the project imports is named in pyproject.toml, not merely dragged in by another."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from click.testing import CliRunner
from packaging.requirements import Requirement

from haptid.support.installing import lock_file as locked
from haptid.support.installing import supply_chain
from haptid.support.installing.environment import ROOT, requirements
from haptid.support.installing.licence import recognise_licence

OURS = (
    "support", "model", "virtual_device", "measurement", "fmu_build", "identification", "noise", "uq", "discrepancy",
    "report", "api", "haptid",
)  # fmt: skip
TOOLS = ("docs", "benchmarks", "studies", "tests")
SPELLED_OTHERWISE = {"pinocchio": ["pin"]}
APART = ROOT / "benchmarks" / "peers"  # other tools, each in an environment of its own


def imported(folder: str) -> dict[str, Path]:
    """Return the top-level modules that a folder imports, each with a file that does."""
    found: dict[str, Path] = {}
    for path in sorted((ROOT / folder).rglob("*.py")):
        if APART in path.parents:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []
            found |= {name.partition(".")[0]: path for name in names}
    return {n: p for n, p in found.items() if n not in sys.stdlib_module_names and not (ROOT / n).is_dir()}


def optional() -> tuple[Requirement, ...]:
    """Return what the extras name; its import is inside the function that can do without."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return tuple(Requirement(line) for lines in project["optional-dependencies"].values() for line in lines)


def normal(name: str) -> str:
    return name.lower().replace("_", "-")


@pytest.mark.parametrize("folder", [*OURS, *TOOLS])
def test_imports_are_declared(folder: str):
    declared = {normal(r.name) for r in (*requirements(dev=folder in TOOLS), *optional())}
    owners = packages_distributions()
    undeclared = {
        f"{name} ({path.relative_to(ROOT)})"
        for name, path in imported(folder).items()
        if not declared & {normal(owner) for owner in (SPELLED_OTHERWISE | owners).get(name, [name])}
    }
    assert not undeclared


def test_the_locked_files_are_what_the_lock_says():
    assert supply_chain.stale() == ()


def test_every_locked_file_is_pinned_by_a_hash():
    for part in (locked.CORE, locked.DEV, *supply_chain.extras()):
        entries = locked.locked_file(part).read_text(encoding="utf-8").split("\n    --hash=sha256:")
        assert len(entries) > len(locked.pins(part)) > 0
        assert not any("==" in line and not line.endswith("\\") for e in entries for line in e.splitlines()), part


def test_sizes_of_the_lock_are_those_of_wheels_for_this_machine():
    everything = locked.amount(locked.CORE, again=True)
    assert everything.count == len(locked.pins(locked.CORE))
    assert 100e6 < everything.size < 600e6
    assert locked.amount(locked.DEV, again=True).size > everything.size


def test_the_list_of_licences_names_every_distribution_of_the_lock():
    page = supply_chain.LICENCES.read_text(encoding="utf-8")
    for pin in locked.pins(locked.DEV):
        assert f"| {pin.name} | {pin.version} |" in page, "run `make licences`"
    assert "| not stated" not in page


def test_what_the_core_takes_on_disk_was_measured():
    measured = json.loads(locked.SIZES.read_text(encoding="utf-8"))
    assert {pin.name for pin in locked.pins(locked.CORE)} <= set(measured), "run `make sizes`"
    assert locked.amount(locked.CORE, again=True).on_disk > locked.amount(locked.CORE, again=True).size


@pytest.mark.parametrize(
    ("text", "spdx"),
    [
        ("Permission is hereby granted,\nfree of charge, to any person obtaining", "MIT"),
        ("Redistribution and use in source and binary forms, with or without ...", "BSD-2-Clause"),
        ("Redistribution and use in source and binary forms ... to endorse or promote products", "BSD-3-Clause"),
        (
            "Apache License\n   Version 2.0\n ... Permission is hereby granted, free of charge, to any person",
            "Apache-2.0",
        ),
        ("All rights reserved.", ""),
    ],
)
def test_a_licence_is_recognised_by_its_text(text: str, spdx: str):
    assert recognise_licence(text) == spdx


def test_the_bill_of_materials_has_a_hash_for_every_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(supply_chain, "ROOT", tmp_path)
    monkeypatch.setattr(supply_chain, "SBOM", tmp_path / "sbom.json")
    for name in ("pyproject.toml", "uv.lock", "README.md"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    assert CliRunner().invoke(supply_chain.main, ["sbom"]).exit_code == 0
    bill = json.loads((tmp_path / "sbom.json").read_text())
    assert all(component["licenses"] for component in bill["components"])
    assert bill["bomFormat"] == "CycloneDX"
    assert {pin.name for pin in locked.pins("posterior")} <= {c["name"] for c in bill["components"]}
    files = [f for c in bill["components"] for f in c.get("externalReferences", [])]
    assert len(files) > 500
    assert all(f["hashes"] for f in files if f["type"] == "distribution")


BLOCK = """
import importlib, importlib.metadata, runpy, sys
blocked = set(sys.argv.pop(1).split(","))
found = importlib.metadata.version
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in blocked:
            raise ModuleNotFoundError(name, name=name)
def version(name):
    if name in blocked:
        raise importlib.metadata.PackageNotFoundError(name)
    return found(name)
sys.meta_path.insert(0, Absent())
importlib.metadata.version = version
sys.argv.pop(0)
*imported, last = sys.argv[0].split(",")
for name in imported:
    importlib.import_module(name)
runpy.run_module(last, run_name="__main__", alter_sys=True)
"""


def without_extras(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a module where nothing can be imported but what the core installs, ``pip`` and the like left alone."""
    only = {pin.name for pin in locked.pins(locked.DEV)} - {pin.name for pin in locked.pins(locked.CORE)}
    owners = packages_distributions()
    modules = {module for module, names in owners.items() if {normal(n) for n in names} <= only}
    command = [sys.executable, "-c", BLOCK, ",".join(only | modules), *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_the_embedded_job_runs_on_the_core_alone(tmp_path: Path):
    done = without_extras("identification.run", "--joints", "4", "--out", tmp_path, "--workers", "1", "--quiet")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report.html").is_file()


def test_a_urdf_needs_no_extra(tmp_path: Path):
    arm = ROOT / "model" / "device" / "built_in" / "arm6.urdf"
    done = without_extras("model.plan", arm, "--no-design", "--out", tmp_path)
    assert done.returncode == 0, done.stderr


def test_every_other_command_starts_on_the_core_alone():
    commands = (
        "fmu_build.run", "fmu_build.export", "discrepancy.run", "studies.blind.run", "measurement.check",
        "measurement.new", "virtual_device.make_campaign", "model.plan",
    )  # fmt: skip
    done = without_extras(",".join(commands), "--help")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (("identification.run", "--joints", "4", "--scheduler", "tcp://127.0.0.1:1"), "cluster"),
    ],
)
def test_what_needs_an_extra_names_its_command(tmp_path: Path, arguments: tuple[str | Path, ...], extra: str):
    done = without_extras(*arguments, "--out", tmp_path / "out")
    assert done.returncode == 2, done.stderr
    assert f"run `make {extra}` (" in done.stderr.splitlines()[-1]
    assert re.search(r"MB to download, about \d+ MB on disk\)", done.stderr.splitlines()[-1])


def test_missing_development_packages_are_one_line():
    done = without_extras("docs.build")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "lacks mkdocs" in done.stderr
    assert done.stderr.endswith("run `make docs`\n")
