"""A gear whose teeth make a wave and its harmonics is named in a search in positions, with all of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.discrepancy.run import main
from haptid.virtual_device.recording.inputs import rich
from haptid.virtual_device.stranger.campaign import make_stranger_campaign, stranger_runs
from haptid.virtual_device.stranger.readings import Recorder
from tests.identification.bench_joint import TRUE

GEAR = {"gear": 4e-4, "gear_number": 60.0, "gear_phase": 0.8, "gear_second": 0.3, "gear_third": 0.2}


@pytest.mark.long
def test_harmonics_of_a_gear_are_named_with_their_sizes(tmp_path: Path) -> None:
    joint = {**TRUE, "Kp": 1.0, "law": "bristle", "sharpness": 2.0, **GEAR}
    chosen = {use: [run for run in rich(4) if run.use == use][:most] for use, most in (("fit", 4), ("validate", 3))}
    inputs = [replace(run, duration=7.0) for runs in chosen.values() for run in runs]
    runs = stranger_runs(4, joint, inputs, Recorder(white=1e-4, resolution=2e-5), seed=4)
    make_stranger_campaign(tmp_path / "gear", 4, runs, device="single_joint", known={}, noise={"noise_rad": 1e-4})
    options = ["--joint", "4", "--out", str(tmp_path), "--starts", "2", "--workers", "1", "--fmu", "native", "--quiet"]
    done = CliRunner().invoke(main, [str(tmp_path / "gear"), *options])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "discrepancy" / "joint4.json").read_text())
    # Next to this gear, the stranger's friction is near LuGre's, and not the same.
    assert found["verdict"] in ("named", "partly_named"), found["sentence"]
    (effect,) = found["effects"]
    assert (effect["id"], effect["variant"]) == ("cogging", "harmonics")
    value = {id: one["value"] for id, one in effect["parameters"].items()}
    assert value["cogging_number"] == pytest.approx(GEAR["gear_number"], rel=0.01)
    sizes = [float(abs(complex(value[f"cogging_sin_{h}"], value[f"cogging_cos_{h}"]))) for h in (1, 2, 3)]
    shares = (1.0, GEAR["gear_second"], GEAR["gear_third"])
    assert sizes == pytest.approx([GEAR["gear"] * share for share in shares], rel=0.15)
    assert found["gap"]["sealed"]["closed"] > 0.95
