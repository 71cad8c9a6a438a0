"""The import contracts are read, and they catch what they forbid."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from haptid.support.check import CHECKS
from haptid.support.installing.environment import ROOT

PACKAGES = (
    "support", "model", "virtual_device", "measurement", "fmu_build", "identification", "noise", "uq", "discrepancy",
    "report", "api",
)  # fmt: skip


def contracts(project: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *CHECKS["import contracts"]], cwd=project, capture_output=True, text=True, check=False
    )


@pytest.fixture
def skeleton(tmp_path: Path) -> Path:
    """The packages with every module empty, under the project's own contracts."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for source in [p for name in (*PACKAGES, "studies") for p in (ROOT / name).rglob("*.py")]:
        place = source.relative_to(ROOT)
        empty = tmp_path / (place if place.parts[0] == "studies" else "haptid" / place)
        empty.parent.mkdir(parents=True, exist_ok=True)
        empty.touch()
    # The modules of haptid/ itself, beside its links to the packages.
    for own in (*(ROOT / "haptid").glob("*.py"), *(ROOT / "haptid" / "fleet").glob("*.py")):
        empty = tmp_path / own.relative_to(ROOT)
        empty.parent.mkdir(exist_ok=True)
        empty.touch()
    return tmp_path


def test_clean_packages_pass(skeleton: Path):
    assert contracts(skeleton).returncode == 0


@pytest.mark.parametrize(
    ("module", "imported"),
    [
        ("model/joint/slots.py", "measurement"),
        ("model/equations/quantity.py", "model.kernel.generate"),
        ("identification/result/fit.py", "report"),
        ("report/common/page.py", "api"),
        ("identification/job/identify.py", "api"),
        ("identification/problem/loss.py", "identification.fit.multistart"),
        ("uq/density/forward.py", "discrepancy"),
        ("virtual_device/machine/arm.py", "model"),
        ("model/plan.py", "virtual_device"),
        ("identification/sequence/step.py", "virtual_device"),
        ("support/errors.py", "model"),
        ("api/campaign.py", "command_line"),
        ("noise/thresholds.py", "noise.arma"),
        ("noise/terms.py", "noise.gram"),
        ("version.py", "doctor"),
        ("fleet/comparison.py", "fleet.page"),
    ],
)
def test_upward_and_sideward_imports_are_caught(skeleton: Path, module: str, imported: str):
    (skeleton / "haptid" / module).write_text(f"import haptid.{imported}\n")
    done = contracts(skeleton)
    assert done.returncode == 1
    assert "BROKEN" in done.stdout


def test_commands_may_hand_their_results_to_the_report(skeleton: Path):
    (skeleton / "haptid" / "report" / "common" / "page.py").write_text("import haptid.identification\n")
    (skeleton / "haptid" / "identification" / "identify_campaign.py").write_text("import haptid.report.common.page\n")
    assert contracts(skeleton).returncode == 0, contracts(skeleton).stdout


def test_a_module_without_a_room_is_caught(skeleton: Path):
    (skeleton / "haptid" / "uq" / "odd.py").touch()
    assert contracts(skeleton).returncode == 1
