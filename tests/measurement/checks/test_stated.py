"""A parameter that the joint does not have is told when the campaign is read, not after minutes of fitting."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.identification.run import main as identify
from haptid.measurement.check import main as check
from haptid.measurement.format.embedded import embedded_campaign


def stated(folder: Path, name: str) -> Path:
    """Copy the embedded campaign, whose joint 0 turns about the vertical, with one more parameter of joint 0."""
    shutil.copytree(embedded_campaign("paper"), folder)
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(f"{text}\n[joint.0.parameters]\n{name} = {{ initial = 0.1 }}\n", encoding="utf-8")
    return folder


@pytest.mark.parametrize("command", [check, identify])
def test_parameters_that_the_joint_lacks_are_refused(command, tmp_path: Path):
    folder = stated(tmp_path / "a", "gravity_cos")
    options = [] if command is check else ["--out", str(tmp_path / "out"), "--quiet", "--joints", "4"]
    result = CliRunner().invoke(command, [str(folder), *options])
    assert result.exit_code == 2
    assert "joint.0.parameters.gravity_cos: expected a parameter of this joint, got gravity_cos" in result.output
    assert not (tmp_path / "out").exists()


def test_parameters_that_it_has_are_read(tmp_path: Path):
    assert CliRunner().invoke(check, [str(stated(tmp_path / "a", "Ks"))]).exit_code == 0
