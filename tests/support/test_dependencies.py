"""Every package that the project imports is named in pyproject.toml, not merely dragged in by another."""

from __future__ import annotations

import ast
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from support.environment import ROOT, requirements

OURS = (
    "support", "model", "virtual_device", "measurement", "fmu_build", "identification", "uq", "discrepancy", "report",
)  # fmt: skip
TOOLS = ("docs", "benchmarks", "tests")
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
