"""The import contracts are read, and they catch what they forbid."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.check import CHECKS
from support.installing.environment import ROOT

PACKAGES = (
    "support", "model", "virtual_device", "measurement", "fmu_build", "identification", "uq", "discrepancy", "report",
)  # fmt: skip


def contracts(project: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *CHECKS["import contracts"]], cwd=project, capture_output=True, text=True, check=False
    )


@pytest.fixture
def skeleton(tmp_path: Path) -> Path:
    """The packages, empty, under the project's own contracts."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for package in PACKAGES:
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").touch()
    return tmp_path


def test_clean_packages_pass(skeleton: Path):
    assert contracts(skeleton).returncode == 0


@pytest.mark.parametrize(
    ("module", "imported"),
    [
        ("model/part.py", "measurement"),
        ("identification/result/fit.py", "report"),
        ("uq/sample.py", "discrepancy"),
        ("virtual_device/machine/arm.py", "model"),
        ("model/arm.py", "virtual_device"),
        ("identification/peek.py", "virtual_device"),
        ("support/low.py", "model"),
    ],
)
def test_upward_and_sideward_imports_are_caught(skeleton: Path, module: str, imported: str):
    (skeleton / module).write_text(f"import {imported}\n")
    done = contracts(skeleton)
    assert done.returncode == 1
    assert "BROKEN" in done.stdout


def test_commands_may_hand_their_results_to_the_report(skeleton: Path):
    (skeleton / "report" / "page.py").write_text("import identification\n")
    (skeleton / "identification" / "run.py").write_text("import report.common.page\n")
    assert contracts(skeleton).returncode == 0, contracts(skeleton).stdout
