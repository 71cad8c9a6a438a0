"""Results keep the file of their device: they are exported without their campaign and without a further option."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
from click.testing import CliRunner

from haptid.fmu_build import export
from haptid.identification import run
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations

ARM = Path(__file__).parents[3] / "docs" / "examples" / "two_joints.urdf"


def write_campaign(folder: Path) -> None:
    """Write one run of joint 1, all parameters of which are fixed: nothing is fitted."""
    shutil.copy(ARM, folder)
    t = np.arange(0.0, 1.0, 0.005)
    table = np.column_stack((t, 0.01 * np.sin(5 * t), 0.02 * np.cos(5 * t)))
    np.savetxt(folder / "a.csv", table, delimiter=",", header="time_s,torque_1_Nm,position_1_rad", comments="")
    parameters = configuration_equations(load_device(ARM), (1,), (0.0, 0.0)).parameters
    fixed = "\n".join(f"{q.id} = {{ fixed = {q.initial} }}" for q in parameters)
    (folder / "campaign.toml").write_text(
        f'[campaign]\ndevice = "{ARM.name}"\nmeasured = false\n[sensor]\nnoise_rad = 1e-4\nresolution_rad = 0.0\n'
        f'[joint.1.parameters]\n{fixed}\n[[runs]]\nfile = "a.csv"\nfree_joints = [1]\nuse = "fit"\n',
        encoding="utf-8",
    )


def test_results_of_a_campaign_with_a_urdf_are_exported_without_its_name(tmp_path):
    (tmp_path / "campaign").mkdir()
    write_campaign(tmp_path / "campaign")
    options = ["--fmu", "none", "--no-export", "--quiet", "--workers", "1", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(run.main, [str(tmp_path / "campaign"), *options])
    assert done.exit_code == 0, done.output
    shutil.rmtree(tmp_path / "campaign")  # the results may go to another machine
    data = json.loads((tmp_path / "out" / "identification.json").read_text())
    assert data["device_file"] == f"device/{ARM.name}"
    assert (tmp_path / "out" / "device" / ARM.name).read_bytes() == ARM.read_bytes()
    made = CliRunner().invoke(export.main, ["--from", str(tmp_path / "out"), "--out", str(tmp_path / "arm.urdf")])
    assert made.exit_code == 0, made.output


def test_no_copy_is_written_before_a_result(tmp_path, monkeypatch):
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    (tmp_path / "campaign").mkdir()
    write_campaign(tmp_path / "campaign")
    monkeypatch.setattr("haptid.identification.sequence.sequence.fit_runs", interrupt)
    options = ["--fmu", "none", "--no-export", "--quiet", "--workers", "1", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(run.main, [str(tmp_path / "campaign"), *options])
    assert done.exit_code == 130
    assert "interrupted: nothing was finished yet" in done.stderr
    assert not (tmp_path / "out" / "device").exists()
