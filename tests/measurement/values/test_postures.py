"""Postures of locked joints: which runs share one, and what is said of runs that stand alone."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from click.testing import CliRunner

from haptid.api.campaign import Campaign
from haptid.identification.sequence.configurations import configurations_of
from haptid.measurement import check, new
from haptid.measurement.checks.preparation import ready_for_fits
from haptid.measurement.format.embedded import FOLDERS, embedded_campaign
from haptid.measurement.format.reading import open_source, read_campaign
from haptid.measurement.format.run_entries import _posture
from haptid.measurement.making.writing import write_campaign
from haptid.measurement.values.campaign import Campaign as Values
from haptid.measurement.values.postures import join_postures, locked_posture
from haptid.measurement.values.run import Run
from haptid.model.device.reader import load_device

ARM = Path(__file__).parents[3] / "docs" / "examples" / "two_joints.urdf"
ALL = ("campaign", "sensor", "joint", "runs", "controller")
T = np.arange(1000) * 0.002


def table(free: int, held_at: float, seed: int) -> pd.DataFrame:
    """A run of a logger that records both joints of the arm, of which one is held."""
    rng = np.random.default_rng(seed)
    torques = {joint: np.zeros(T.size) for joint in (0, 1)}
    positions = {joint: held_at + rng.normal(0.0, 2e-4, T.size) for joint in (0, 1)}
    torques[free] = 0.1 * np.cos((3.0 + seed) * T)
    positions[free] = 0.5 * np.sin((3.0 + seed) * T) + rng.normal(0.0, 2e-4, T.size)
    frame = pd.DataFrame({"time_s": T})
    for joint in (0, 1):
        frame[f"torque_{joint}_Nm"] = torques[joint]
        frame[f"position_{joint}_rad"] = positions[joint]
    return frame


def frames(held_at: Sequence[float]) -> dict[str, pd.DataFrame]:
    made = {}
    for k, at in enumerate(held_at):
        for joint in (0, 1):
            made[f"j{joint}_{k}"] = table(joint, at, seed=2 * k + joint)
    return made


def written(campaign: Values, folder: Path) -> Path:
    runs = tuple(run.but(file=f"{run.file}.csv") for run in campaign.runs)
    write_campaign(campaign.but(device=ARM.name, runs=runs), folder)
    shutil.copy(ARM, folder)
    return folder


def grouped(campaign: Values) -> dict[tuple[int, ...], list[list[str]]]:
    """Files of each configuration, by its free joints."""
    found: dict[tuple[int, ...], list[list[str]]] = {}
    for one in configurations_of(campaign, load_device(str(ARM))):
        found.setdefault(one.free_joints, []).append([run.file for run in one.runs])
    return found


def test_readings_of_held_joints_make_one_posture_of_one_lock(tmp_path: Path) -> None:
    tables = tmp_path / "tables"
    tables.mkdir()
    for name, frame in frames([0.3, 0.3, 0.3, 0.3]).items():
        frame.to_csv(tables / f"{name}.csv", index=False)
    # The last run of each joint validates.
    flags = ["--out", str(tmp_path / "made"), "--yes", "--device", str(ARM), "--validate", "j?_3.csv"]
    result = CliRunner().invoke(new.main, [str(tables), *flags])
    assert result.exit_code == 0, result.output
    campaign = read_campaign(tmp_path / "made")
    expected = {(j,): [[f"j{j}_{k}.csv" for k in range(4)]] for j in (0, 1)}
    assert grouped(campaign) == expected
    entries = open_source(tmp_path / "made", ALL).data["runs"]
    assert len({tuple(entry["locked_positions_rad"]) for entry in entries}) == 2
    assert "posture" not in CliRunner().invoke(check.main, [str(tmp_path / "made")]).output


def test_frames_and_a_campaign_by_hand_do_alike(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values = Campaign.from_frames(frames([0.3, 0.3, 0.3]), device=str(ARM), validate=["j0_2", "j1_2"]).values
    assert [len(postures) for postures in grouped(values).values()] == [1, 1]
    folder = written(values, tmp_path / "written")
    text = (folder / "campaign.toml").read_text()
    assert text.count("locked_positions_rad") == 6
    runs = read_campaign(folder).runs
    by_hand = [run.but(posture=run.posture + 1e-3 * k) for k, run in enumerate(runs)]
    joined = join_postures(by_hand)
    for joint in (0, 1):
        own = [locked_posture(run) for run in joined if run.free_joints == (joint,)]
        assert len(set(own)) == 1
        held = [run.posture[1 - joint] for run in by_hand if run.free_joints == (joint,)]
        assert own[0][1 - joint] == np.median(held)


def test_postures_that_differ_stay_apart() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = Campaign.from_frames(frames([0.0, 0.0, 0.3, 0.3]), device=str(ARM), validate=["j0_1", "j1_3"])
    assert grouped(made.values) == {(j,): [[f"j{j}_0", f"j{j}_1"], [f"j{j}_2", f"j{j}_3"]] for j in (0, 1)}


def test_a_coarse_stated_step_decides() -> None:
    def run(at: float, step: float) -> Run:
        values = Campaign.from_frames({"a": table(0, at, seed=1)}, device=str(ARM)).values
        return values.runs[0].but(posture=np.array([0.0, at]), resolution=np.array([step]))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        coarse = [run(0.0, 0.02), run(0.02, 0.02)]
        of_the_held = coarse[0].but(free_joints=(1,), posture=np.zeros(2))
    apart = join_postures(coarse)
    assert locked_posture(apart[0]) != locked_posture(apart[1])  # the step is the free joint's
    joined = join_postures([*coarse, of_the_held])
    assert locked_posture(joined[0]) == locked_posture(joined[1]) == (0.0, 0.01)


def test_the_embedded_campaigns_keep_their_postures() -> None:
    for name in FOLDERS:
        folder = embedded_campaign(name)
        entries = open_source(folder, ALL).data["runs"]
        device = str(open_source(folder, ALL).data["campaign"]["device"])
        for run, entry in zip(read_campaign(folder).runs, entries, strict=True):
            np.testing.assert_array_equal(run.posture, _posture(entry, device, 6))


def test_runs_that_stand_alone_in_their_posture_are_remarked_on(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = Campaign.from_frames(frames([0.0, 0.0, 0.3, 0.6]), device=str(ARM), validate=["j0_3", "j1_3"]).values
    folder = written(made, tmp_path / "written")
    told = CliRunner().invoke(check.main, [str(folder)]).output
    assert "j0_3.csv, joint 0: no run to fit has its posture (1 at +0.6): it is compared with nothing" in told
    assert "j1_2.csv, joint 1: the only run to fit in its posture (0 at +0.3)" in told
    assert "j0_0.csv, joint 0: the only run" not in told
    # The commands that fit, and haptid init at its end, tell the same.
    assert any("the only run to fit in its posture" in remark for remark in ready_for_fits(made).remarks)
