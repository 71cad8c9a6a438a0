"""Drives and controllers of a campaign: what is read, what is refused, and the torque at the stated values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.reading import read_campaign
from haptid.model.equations.drive import Controller, Drive
from haptid.support.errors import InputError

T = np.arange(0.0, 4.0, 0.01)
COLUMNS = {
    "position_0_rad": 0.3 * np.sin(3 * T),
    "velocity_0_rad_s": 0.9 * np.cos(3 * T),
    "reference_0_rad": 0.4 * np.sin(3 * T),
    "voltage_0_V": 2.0 * np.cos(3 * T),
    "current_0_A": 0.5 * np.cos(3 * T),
    "duty_0": 0.2 * np.cos(3 * T),
    "torque_0_Nm": 0.1 * np.cos(3 * T),
    "supply_V": 7.4 + 0.1 * np.sin(T),
    "enabled_0": (T < 3.0).astype(float),
    "temperature_0_C": 30.0 + T,
}
VOLTAGE = '[joint.0.drive]\nkind = "voltage"\ntorque_constant = 0.4\nresistance_ohm = { initial = 3.0, upper = 9.0 }\n'
DUTY = '[joint.0.drive]\nkind = "duty"\ntorque_constant = 0.4\nresistance_ohm = 3.0\n'
LOOP = '[joint.0.controller]\nkind = "p"\ngain = 0.5\nlimit = 0.1\n'


def campaign(folder: Path, tables: str, columns: dict[str, np.ndarray] | None = None, run: str = "") -> Path:
    head = '[campaign]\ndevice = "single_joint"\nmeasured = false\n[sensor]\nnoise_rad = 1e-4\nresolution_rad = 0\n'
    entry = f'[[runs]]\nfile = "a.csv"\nfree_joints = [0]\nuse = "fit"\n{run}\n'
    (folder / "campaign.toml").write_text(f"{head}{tables}{entry}", encoding="utf-8")
    table = {"time_s": T, **(COLUMNS if columns is None else columns)}
    np.savetxt(
        folder / "a.csv", np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments=""
    )
    return folder


def without(*names: str) -> dict[str, np.ndarray]:
    return {name: column for name, column in COLUMNS.items() if name not in names}


def test_a_voltage_is_an_input_and_gives_a_torque(tmp_path: Path):
    read = read_campaign(campaign(tmp_path, VOLTAGE))
    (run,), on = read.runs, COLUMNS["enabled_0"]
    assert read.drives == {0: Drive(kind="voltage")}
    assert read.parameter_overrides[0]["torque_constant"] == {"fixed": 0.4}
    assert tuple(run.drive_inputs) == ("voltage", "enabled")
    assert np.allclose(run.inputs, np.column_stack((COLUMNS["voltage_0_V"], on)))
    back_emf = 0.4 * COLUMNS["velocity_0_rad_s"]
    assert np.allclose(run.u[:, 0], on * 0.4 * (COLUMNS["voltage_0_V"] - back_emf) / 3.0)


def test_a_controller_makes_the_reference_the_input(tmp_path: Path):
    read = read_campaign(campaign(tmp_path, DUTY + LOOP, without("duty_0"), "controller_gain = 0.8"))
    (run,) = read.runs
    assert read.drives[0].controller == Controller(kind="p", gain=0.5, limit=0.1)
    assert tuple(run.drive_inputs) == ("reference", "supply", "enabled", "controller_gain")
    assert np.all(run.drive_inputs["controller_gain"] == 0.8)
    duty = np.clip(0.8 * (COLUMNS["reference_0_rad"] - COLUMNS["position_0_rad"]), -0.1, 0.1)
    voltage = duty * COLUMNS["supply_V"] - 0.4 * COLUMNS["velocity_0_rad_s"]
    assert np.allclose(run.u[:, 0], COLUMNS["enabled_0"] * 0.4 * voltage / 3.0)


def test_a_torque_is_zero_while_the_motor_is_let_go(tmp_path: Path):
    (run,) = read_campaign(campaign(tmp_path, "")).runs
    assert not run.drive_inputs
    assert np.allclose(run.u[:, 0], COLUMNS["enabled_0"] * COLUMNS["torque_0_Nm"])


def test_a_held_out_part_has_its_own_inputs(tmp_path: Path):
    prepared = campaign_for_command(campaign(tmp_path, VOLTAGE))
    assert all(run.inputs.shape == (run.t.size, 2) for run in prepared.runs)


REFUSED = (
    ('[joint.0.drive]\nkind = "volts"\n', "torque.*current.*voltage.*duty"),
    ("[joint.0.drive]\ntorque_constant = 0.1\n", "kind.*no such key"),
    ('[joint.0.drive]\nkind = "voltage"\nresistence_ohm = 3.0\n', "resistance_ohm"),
    ('[joint.0.drive]\nkind = "voltage"\nresistance_ohm = -3.0\n', "line 9.*a positive number"),
    ('[joint.0.drive]\nkind = "current"\nresistance_ohm = 3.0\n', "a voltage or a duty"),
    ('[joint.0.drive]\nkind = "voltage"\ntorque_constant = { intial = 3.0 }\n', "intial.*did you mean initial"),
    (
        '[joint.0.drive]\nkind = "voltage"\n[joint.0.parameters]\nKp = { prior = { mean = 1, std = 0.1 } }\n',
        "one free gain",
    ),
    ('[joint.0.controller]\nkind = "p"\ngain = 1.0\n', "limit"),
    ('[joint.0.controller]\nkind = "p"\ngain = 1.0\nlimit = 0\n', "a positive number"),
    ('[joint.0.controller]\nkind = "pd"\ngain = 1.0\nlimit = 1.0\n', "derivative_gain"),
    ('[joint.0.controller]\nkind = "p"\ngain = 1.0\nlimit = 1.0\nderivative_gain = 0.1\n', "pd or pid"),
)


@pytest.mark.parametrize(("tables", "words"), REFUSED, ids=[str(k) for k in range(len(REFUSED))])
def test_a_faulty_table_is_refused(tmp_path: Path, tables: str, words: str):
    with pytest.raises(InputError, match=words):
        read_campaign(campaign(tmp_path, tables))


@pytest.mark.parametrize(
    ("tables", "columns", "words"),
    [
        (VOLTAGE, without("voltage_0_V"), "a column voltage_0_V"),
        (DUTY, without("supply_V"), "a column supply_V beside a duty, got none; add it: the voltage"),
        (DUTY + LOOP, without("reference_0_rad"), "a column reference_0_rad"),
        (DUTY, {**without("supply_V"), "supply_mV": 7400.0 + T}, "supply_V.*supply_mV.*by 0.001"),
        (DUTY, {**COLUMNS, "duty_0": 100 * COLUMNS["duty_0"]}, "line 2, column duty_0.*from -1 to 1"),
        (DUTY, {**COLUMNS, "supply_V": 0.0 * T}, "line 2, column supply_V.*positive"),
        ("", {**COLUMNS, "enabled_0": 0.5 + 0.0 * T}, "line 2, column enabled_0.*0 or 1"),
    ],
)
def test_a_faulty_column_is_refused(tmp_path: Path, tables: str, columns: dict[str, np.ndarray], words: str):
    with pytest.raises(InputError, match=words):
        read_campaign(campaign(tmp_path, tables, columns))


def test_a_gain_without_a_controller_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match=r"\[joint.0.controller\]"):
        read_campaign(campaign(tmp_path, VOLTAGE, run="controller_gain = 1.0"))
