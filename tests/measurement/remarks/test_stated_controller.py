"""A stated controller is held against the recorded command: gains in another unit, and another controller."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.checks.recorded_torque import with_torques_that_were
from haptid.measurement.checks.summary import summarise
from haptid.measurement.commands import check
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.remarks.remarks import remarks_of
from haptid.measurement.remarks.stated_controller import find_other_controllers
from haptid.measurement.thresholds import THRESHOLDS
from haptid.support.errors import LONGEST

T = np.arange(0.0, 4.0, 0.002)
REFERENCE = 0.5 * np.sin(3 * T) + 0.2 * np.sin(11 * T)
STEP = 2 * np.pi / 4096
POSITION = np.round((0.45 * np.sin(3 * T - 0.15) + 0.15 * np.sin(11 * T - 0.5)) / STEP) * STEP
SPEED = np.gradient(POSITION, T)
COMMAND = np.clip(25.0 * (REFERENCE - POSITION) - 0.35 * SPEED, -3.0, 3.0)
"""Output of the firmware's loop, by its gains; it saturates in a part of the rows."""
LOOP = '[joint.0.controller]\nkind = "pd"\ngain = {gain}\nderivative_gain = {damping}\nlimit = {limit}\n'
AMPERE = LOOP.format(gain=25.0, damping=0.35, limit=3.0)
CONSTANT = "[joint.0]\ntorque_constant_Nm_per_A = 0.08\n"
CURRENT = '[joint.0.drive]\nkind = "current"\ntorque_constant = 0.08\n'


def campaign(folder: Path, tables: str, **columns: np.ndarray) -> Path:
    table = {"time_s": T, "position_0_rad": POSITION, "reference_0_rad": REFERENCE, **columns}
    rows = np.column_stack(list(table.values()))
    entries = ""
    for name, use in (("a", "fit"), ("b", "fit"), ("c", "validate")):
        scaled = rows * np.where(np.arange(len(table)) > 0, {"a": 1.0, "b": 0.9, "c": 1.1}[name], 1.0)
        np.savetxt(folder / f"{name}.csv", scaled, delimiter=",", header=",".join(table), comments="")
        entries += f'[[runs]]\nfile = "{name}.csv"\nfree_joints = [0]\nuse = "{use}"\n'
    head = '[campaign]\ndevice = "single_joint"\nmeasured = false\n'
    (folder / "campaign.toml").write_text(head + tables + entries, encoding="utf-8")
    return folder


def test_gains_in_amperes_without_a_drive_are_told_once_with_the_drive_to_state(tmp_path: Path) -> None:
    read = campaign_for_command(campaign(tmp_path, CONSTANT + AMPERE, current_0_A=COMMAND))
    (remark,) = [one for one in read.remarks if "are its gains" in one]
    assert remark.startswith("a.csv, joint 0: the stated controller gives 12.5 times the recorded torque, which")
    assert "are its gains in A/rad?" in remark
    assert ": 1/torque_constant_Nm_per_A; are its" in remark
    assert remark.endswith('[joint.0.drive] kind = "current", torque_constant = 0.08 in place of that key')
    assert len(remark) < LONGEST, "a command would cut the remedy"


@pytest.mark.parametrize(
    ("tables", "columns"),
    [
        (CURRENT + AMPERE, {"current_0_A": COMMAND}),
        (AMPERE, {"torque_0_Nm": COMMAND}),
        (AMPERE, {"torque_0_Nm": np.roll(COMMAND, 2)}),
        (AMPERE, {"torque_0_Nm": COMMAND + 0.2 * np.random.default_rng(0).standard_normal(T.size)}),
        (CONSTANT + LOOP.format(gain=2.0, damping=0.028, limit=0.24), {"current_0_A": COMMAND}),
        (AMPERE, {}),
    ],
)
def test_the_right_unit_a_delay_and_what_was_not_recorded_get_no_remark(
    tmp_path: Path, tables: str, columns: dict[str, np.ndarray]
) -> None:
    assert find_other_controllers(read_campaign(campaign(tmp_path, tables, **columns))) == {}


def test_remarks_on_a_torque_are_on_the_recorded_one(tmp_path: Path) -> None:
    """The torque of a controller that is not that of the runs took work, and a wrong sign of the torque was told."""
    # The stated law makes -10 times the recorded torque of these runs.
    backwards = POSITION - SPEED / 50.0
    tables, columns = LOOP.format(gain=25.0, damping=0.0, limit=30.0), {"torque_0_Nm": 0.05 * SPEED}
    read = read_campaign(campaign(tmp_path, tables, reference_0_rad=backwards, **columns))
    assert np.mean(read.runs[0].u[:, 0] * SPEED) < 0
    rows = summarise(read)
    told = [remark for row in rows for remark in row.remarks]
    assert any("the stated controller is not the one of these runs" in remark for remark in told)
    assert not any("sign" in remark for remark in told)
    assert rows[0].facts["torque_half_range_Nm"] == pytest.approx(np.ptp(0.05 * SPEED) / 2)
    # Nothing is recorded: what the controller gives is all there is to show.
    (tmp_path / "other").mkdir()
    alone = summarise(read_campaign(campaign(tmp_path / "other", tables, reference_0_rad=backwards)))
    assert alone[0].facts["torque_half_range_Nm"] == pytest.approx(np.ptp(0.5 * SPEED) / 2, rel=1e-3)


def test_a_controller_of_another_size_or_of_other_runs_is_told(tmp_path: Path) -> None:
    small = LOOP.format(gain=2.0, damping=0.028, limit=0.24)
    told = find_other_controllers(read_campaign(campaign(tmp_path, CURRENT + small, current_0_A=COMMAND)))
    assert "gives 0.08 times the recorded current" in told["a.csv", 0]
    assert "the output of this drive's controller is in A: are its gains in A/rad?" in told["a.csv", 0]
    other = 0.3 * np.cos(7 * T)
    told = find_other_controllers(read_campaign(campaign(tmp_path, AMPERE, torque_0_Nm=other)))
    assert "is not the one of these runs: the recorded torque does not follow it" in told["a.csv", 0]


def moved(share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, speed of the loop and torque; ``share`` of a new speed counts at once.

    The joint has 0.02 kg m², 0.05 N m s/rad and 0.1 N m of dry friction; the loop runs once a row, the joint ten times.
    """
    q = v = speed = 0.0
    before, position, speeds, torque = 0.0, np.zeros_like(T), np.zeros_like(T), np.zeros_like(T)
    dt = (T[1] - T[0]) / 10
    for k, wanted in enumerate(REFERENCE):
        reading = round(q / STEP) * STEP
        speed += share * ((reading - before) / (10 * dt) - speed)
        before = reading
        u = 25.0 * (wanted - reading) - 0.35 * speed
        position[k], speeds[k], torque[k] = reading, speed, u
        for _ in range(10):
            v += dt * (u - 0.05 * v - 0.1 * np.tanh(v / 0.02)) / 0.02
            q += dt * v
    return position, speeds, torque


LAW = LOOP.format(gain=25.0, damping=0.35, limit=50.0)


def test_the_recorded_torque_takes_the_place_of_a_law_that_did_not_make_it(tmp_path: Path) -> None:
    position, _, torque = moved(share=0.1)
    read = campaign_for_command(campaign(tmp_path, LAW, position_0_rad=position, torque_0_Nm=torque))
    assert read.drives == {}
    (run, *_) = read.runs_of((0,), "fit")
    assert run.drive_inputs == {}
    assert run.u[:, 0] == pytest.approx(torque)
    (remark,) = [one for one in read.remarks if "recorded torque is used" in one]
    assert remark.startswith("joint 0: the torque of the stated controller is ")


def test_the_check_tells_the_law_that_is_left_out_and_no_drift_of_a_law_that_stays(tmp_path: Path) -> None:
    """Beside a stated controller the check said that a simulation would drift, and not that it left the law out."""
    for share, stays in ((0.1, False), (1.0, True)):
        position, speed, torque = moved(share)
        columns = {"position_0_rad": position, "torque_0_Nm": torque}
        columns |= {"velocity_0_rad_s": speed} if stays else {}
        folder = tmp_path / str(share)
        folder.mkdir()
        checked = CliRunner().invoke(check, [str(campaign(folder, LAW, **columns))])
        assert checked.exit_code == 0, checked.output
        assert ("the recorded torque is used, and the controller left out" in checked.output) != stays
        assert ("would drift" in checked.output) != stays
    open_loop = [remark for one in remarks_of(read_campaign(folder)) for remark in one.by_joint[0]]
    assert any("would drift" in remark for remark in open_loop)


def test_readings_that_rest_show_no_noise_below_their_step(tmp_path: Path) -> None:
    """A joint that rests for most of its run showed a noise of 7e-10 rad beside a step of 0.0015."""
    position = STEP * np.round(0.3 * np.tanh(40 * (T - 2.0)) / STEP)
    row = summarise(read_campaign(campaign(tmp_path, "", position_0_rad=position, torque_0_Nm=COMMAND)))[0]
    assert row.facts["noise_rad"] < 1e-6
    assert row.cells[-2:] == (f"<{STEP / np.sqrt(12):.2g}", f"~{STEP:.2g}")


def test_a_law_that_made_the_torque_stays(tmp_path: Path) -> None:
    position, speed, torque = moved(share=1.0)
    columns = {"position_0_rad": position, "velocity_0_rad_s": speed, "torque_0_Nm": torque}
    read = campaign_for_command(campaign(tmp_path, LAW, **columns))
    assert 0 in read.drives
    assert not [one for one in read.remarks if "recorded torque" in one]


def test_a_noisy_reading_of_the_torque_does_not_take_the_place_of_the_law(tmp_path: Path) -> None:
    position, _, torque = moved(share=1.0)
    noisy = torque + 2.0 * np.std(torque) * np.random.default_rng(0).standard_normal(T.size)
    assert 0 in campaign_for_command(campaign(tmp_path, LAW, position_0_rad=position, torque_0_Nm=noisy)).drives
    (tmp_path / "none").mkdir()
    assert 0 in campaign_for_command(campaign(tmp_path / "none", LAW, position_0_rad=position)).drives


def test_runs_too_short_to_tell_keep_the_stated_law(tmp_path: Path) -> None:
    position, _, torque = moved(share=0.1)
    read = read_campaign(campaign(tmp_path, LAW, position_0_rad=position, torque_0_Nm=torque))
    assert with_torques_that_were(read).drives == {}

    def cut(run):
        rows = slice(0, THRESHOLDS.least_differences_of_noise - 1)
        columns = {name: column[rows] for name, column in run.extra.items()}
        inputs = {name: column[rows] for name, column in run.drive_inputs.items()}
        return run.but(t=run.t[rows], u=run.u[rows], y=run.y[rows], extra=columns, drive_inputs=inputs)

    short = read.but(runs=tuple(cut(run) for run in read.runs))
    assert 0 in with_torques_that_were(short).drives
