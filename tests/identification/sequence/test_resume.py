"""A run that was interrupted and continued writes what a run without interruption writes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from click.testing import CliRunner

import haptid.identification.job.identify as flow
import haptid.identification.run as command
from haptid.measurement.values.run import Run
from tests.identification.controlled_cases import controlled_joint, slow_sweep, truth_of
from tests.identification.plain_joint import plain_run

OPTIONS = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton", "--starts", "2", "--no-export")
OF_THE_RUN = {"command", "wall_s"}
"""Keys of the results that tell of the run of the command."""


def write_campaign(folder: Path, runs: Sequence[Run], stated: str = "") -> Path:
    folder.mkdir()
    text = f'[campaign]\ntitle = "resumed"\ndevice = "single_joint"\nmeasured = false\n{stated}'
    for run in runs:
        table = {"time_s": run.t, "torque_0_Nm": run.u[:, 0], "position_0_rad": run.y[:, 0]}
        pd.DataFrame(table).to_csv(folder / run.file, index=False)
        text += f'\n[[runs]]\nfile = "{run.file}"\nfree_joints = [0]\nuse = "{run.use}"\nhold = "{run.hold}"\n'
    (folder / "campaign.toml").write_text(text)
    return folder


def campaign_of(outcome: str, folder: Path) -> Path:
    if outcome == "torque_scored":
        true = truth_of(0)
        known = "".join(f"{id} = {{ fixed = {true[id]} }}\n" for id in ("gravity_cos", "gravity_sin"))
        sweeps = [
            controlled_joint(0, slow_sweep, seconds=24, seed=seed, use=use, extra=0.01)
            for seed, use in ((2, "fit"), (3, "validate"))
        ]
        return write_campaign(folder, sweeps, f"[joint.0.parameters]\n{known}")
    # Friction held far from the truth: the fit cannot follow, and the plain model can.
    runs = [plain_run(1, seconds=8.0), plain_run(3, use="validate", seconds=8.0)]
    return write_campaign(folder, runs, "[joint.0.parameters]\nFc = { fixed = 1.0 }\nFs = { fixed = 1.0 }\n")


def identify(campaign: Path, out: Path) -> int:
    return CliRunner().invoke(command.main, [str(campaign), "--out", str(out), *OPTIONS]).exit_code


def results(out: Path) -> str:
    def without_times(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: without_times(entry) for key, entry in value.items() if key not in OF_THE_RUN}
        return [without_times(entry) for entry in value] if isinstance(value, list) else value

    return json.dumps(without_times(json.loads((out / "identification.json").read_text())))


@pytest.mark.long
@pytest.mark.parametrize("outcome", ["plain", "torque_scored"])
def test_a_continued_run_writes_the_bytes_of_a_run_in_one_go(outcome, tmp_path, monkeypatch):
    campaign, whole, continued = campaign_of(outcome, tmp_path / "campaign"), tmp_path / "whole", tmp_path / "continued"
    assert identify(campaign, whole) == 0
    assert json.loads(results(whole))["configurations"][0]["outcome"] == outcome
    write = flow.write_json

    def stop_after_first(path: Path, data: dict[str, Any]) -> None:
        write(path, data)
        raise KeyboardInterrupt

    monkeypatch.setattr(flow, "write_json", stop_after_first)
    assert identify(campaign, continued) == 130
    monkeypatch.setattr(flow, "write_json", write)
    fitted: list[object] = []
    monkeypatch.setattr("haptid.identification.sequence.sequence.fit_runs", lambda *a, **_: fitted.append(a))
    assert identify(campaign, continued) == 0
    assert fitted == []
    assert results(continued) == results(whole)
