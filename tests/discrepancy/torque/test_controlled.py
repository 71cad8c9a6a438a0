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


def campaign(folder: Path, hidden: float, wave: float) -> Path:
    """Write three runs of a joint with a hidden torque hidden·sin(wave·q) [N m; rad⁻¹]."""
    text = '[campaign]\ntitle = "controlled"\ndevice = "single_joint"\nmeasured = false\n'
    for k, use in enumerate(("fit", "fit", "validate")):
        run = controlled_joint(0, rich_motion, seconds=24, seed=10 + k, extra=hidden, wave=wave)
        table = {"time_s": run.t, "torque_0_Nm": run.u[:, 0], "position_0_rad": run.y[:, 0]}
        pd.DataFrame(table).to_csv(folder / f"r{k}.csv", index=False)
        text += f'\n[[runs]]\nfile = "r{k}.csv"\nfree_joints = [0]\nuse = "{use}"\n'
    (folder / "campaign.toml").write_text(text)
    return folder


def found_in(folder: Path, hidden: float, wave: float) -> dict:
    """Search a campaign below ``folder``, and return what was found."""
    (folder / "campaign").mkdir()
    options = ["--fmu", "native", "--quiet", "--workers", "2", "--out", str(folder / "out")]
    done = CliRunner().invoke(main, [str(campaign(folder / "campaign", hidden, wave)), *options])
    assert done.exit_code == 0, done.output
    return dict(json.loads((folder / "out" / "discrepancy" / "joint0.json").read_text()))


@pytest.mark.long
@pytest.mark.parametrize(("hidden", "verdict", "names"), [(0.0, "nothing_missing", []), (0.01, "named", ["cogging"])])
def test_a_controlled_joint_gets_the_name_of_what_is_hidden(tmp_path, hidden, verdict, names):
    out = tmp_path / "out"
    found = found_in(tmp_path, hidden, wave=15.0)
    assert found["verdict"] == verdict
    assert [effect["id"] for effect in found["effects"]] == names
    if names:
        assert found["residual"] == "torque"
        assert found["effects"][0]["stability"] > 0.8
        assert found["gap"]["validate"]["after"] < 0.7 * found["gap"]["validate"]["before"]
        assert found["refit"]["Fs"] >= found["refit"]["Fc"] * (1 - 1e-6)
        (fmu,) = (out / "fmu").glob("*.fmu")
        assert np.isfinite(simulate_fmu(fmu, stop_time=0.05)["joint0.reading"]).all()


@pytest.mark.long
def test_a_wave_longer_than_the_travel_is_not_told_from_a_bent_spring(tmp_path):
    position, noise = rich_motion(np.arange(0.0, 24.0, 0.005)), 9e-5
    bent = np.stack([np.ones_like(position), position, np.cos(position), position**3], axis=1)
    wave = 0.01 * np.sin(5.0 * position)
    # A constant, gravity, a spring and its cubic part leave less of this wave than the torque's noise.
    left = wave - bent @ np.linalg.lstsq(bent, wave)[0]
    assert np.sqrt(np.mean(left**2)) < noise
    found = found_in(tmp_path, hidden=0.01, wave=5.0)
    assert found["verdict"] == "ambiguous"
    said = {effect["id"] for effect in found["effects"]}
    assert "cogging" in said | {id for other in found["alternatives"] for id in other["ids"]}


def test_a_joint_that_was_judged_in_torque_is_not_fitted_through_an_observer_again(tmp_path, monkeypatch):
    fitted: list[object] = []
    monkeypatch.setattr(choice, "earlier_residual", lambda *_: EarlierResidual(at_noise=False, plain=False))
    monkeypatch.setattr(choice, "fit_simulated", lambda *a, **_: fitted.append(a))
    # A single stage is refused for such a joint, before anything is searched.
    done = CliRunner().invoke(
        main, [str(campaign(tmp_path, 0.01, 5.0)), "--stage", "gap", "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 2
    assert "swept by position" in done.output
    assert fitted == []
