"""Synthetic joints under position control: no name where nothing is hidden, the right one where something is."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from fmpy import simulate_fmu

from haptid.discrepancy.run import main
from haptid.discrepancy.torque import choice
from haptid.identification.sequence.carried_fit import EarlierResidual
from tests.identification.controlled_cases import controlled_joint, rich_motion


def campaign(folder: Path, hidden: float) -> Path:
    """Write three runs of a joint with a hidden torque of this size [N m] that is a sine of the position."""
    text = '[campaign]\ntitle = "controlled"\ndevice = "single_joint"\nmeasured = false\n'
    for k, use in enumerate(("fit", "fit", "validate")):
        run = controlled_joint(0, rich_motion, seconds=24, seed=10 + k, extra=hidden)
        table = {"time_s": run.t, "torque_0_Nm": run.u[:, 0], "position_0_rad": run.y[:, 0]}
        pd.DataFrame(table).to_csv(folder / f"r{k}.csv", index=False)
        text += f'\n[[runs]]\nfile = "r{k}.csv"\nfree_joints = [0]\nuse = "{use}"\n'
    (folder / "campaign.toml").write_text(text)
    return folder


@pytest.mark.long
@pytest.mark.parametrize(("hidden", "verdict", "names"), [(0.0, "nothing_missing", []), (0.01, "named", ["cogging"])])
def test_a_controlled_joint_gets_the_name_of_what_is_hidden(tmp_path, hidden, verdict, names):
    out = tmp_path / "out"
    (tmp_path / "campaign").mkdir()
    options = ["--fmu", "native", "--quiet", "--workers", "2", "--out", str(out)]
    done = CliRunner().invoke(main, [str(campaign(tmp_path / "campaign", hidden)), *options])
    assert done.exit_code == 0, done.output
    found = json.loads((out / "discrepancy" / "joint0.json").read_text())
    assert found["verdict"] == verdict
    assert [effect["id"] for effect in found["effects"]] == names
    if names:
        assert found["residual"] == "torque"
        assert found["effects"][0]["stability"] > 0.8
        assert found["gap"]["validate"]["after"] < 0.7 * found["gap"]["validate"]["before"]
        assert found["refit"]["Fs"] >= found["refit"]["Fc"] * (1 - 1e-6)
        (fmu,) = (out / "fmu").glob("*.fmu")
        assert np.isfinite(simulate_fmu(fmu, stop_time=0.05)["joint0.reading"]).all()


def test_a_joint_that_was_judged_in_torque_is_not_fitted_through_an_observer_again(tmp_path, monkeypatch):
    fitted: list[object] = []
    monkeypatch.setattr(choice, "earlier_residual", lambda *_: EarlierResidual(at_noise=False, plain=False))
    monkeypatch.setattr(choice, "fit_simulated", lambda *a, **_: fitted.append(a))
    # A single stage is refused for such a joint, before anything is searched.
    done = CliRunner().invoke(main, [str(campaign(tmp_path, 0.01)), "--stage", "gap", "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "swept by position" in done.output
    assert fitted == []
