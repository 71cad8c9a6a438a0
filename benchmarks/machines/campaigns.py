"""Campaigns of real measurements: a folder of tables as published in, a folder with campaign.toml out.

Each writer states units, signs and the use of every run. Nothing is smoothed, shifted or left out.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

EMPS_FORCE_PER_VOLT = 35.15065188
"""Force of the drive over its control voltage, published with the measurements [N/V]."""
XL330_WEIGHT_NM = 0.49 * 9.80665 * 0.1
"""Weight of the known mass on its rod, published with the measurements [N m]."""
XL330_DUTY_PER_RAD = (4096 / (2 * np.pi)) / (256 * 885)
"""Duty per radian of error and unit of the firmware's gain kp, published with the measurements [1/rad]."""


def write_emps(source: Path, out: Path) -> None:
    """Write the campaign of the prismatic drive: the sweep is fitted, the run with pulses is unseen."""
    uses = {"sweep.csv": "fit", "pulses.csv": "validate"}
    for file in uses:
        table = pd.read_csv(source / file)
        force = EMPS_FORCE_PER_VOLT * table["drive_V"]
        rows = {"time_s": table["time_s"], "force_0_N": force, "position_0_m": table["position_m"]}
        pd.DataFrame(rows).to_csv(out / file, index=False)
    _write_toml(out, "Electro-Mechanical Positioning System", 0, uses)


def write_simple_pendulum(source: Path, out: Path) -> None:
    """Write the campaign of the pendulum: the longer of the two swings is fitted."""
    uses = {"ddp.csv": "fit", "direct_collocation.csv": "validate"}
    names = {"position_rad": "position_0_rad", "velocity_rad_s": "velocity_0_rad_s", "torque_Nm": "torque_0_Nm"}
    for file in uses:
        pd.read_csv(source / file).rename(columns=names).to_csv(out / file, index=False)
    _write_toml(out, "DFKI simple pendulum", 0, uses)


def write_xl330(source: Path, out: Path) -> None:
    """Write the campaign of the servo: gains 100, 200 and 800 are fitted, gain 400 is unseen."""
    files = sorted(path.name for path in source.glob("kp*.csv"))
    names = {
        "goal_rad": "reference_0_rad",
        "position_rad": "position_0_rad",
        "velocity_rad_s": "velocity_0_rad_s",
        "temperature_C": "temperature_0_C",
        "torque_enabled": "enabled_0",
    }
    lines: list[str] = []
    for file in files:
        table = pd.read_csv(source / file).rename(columns=names)
        gain = XL330_DUTY_PER_RAD * int(file.removeprefix("kp").partition("_")[0])
        error = table["reference_0_rad"] - table["position_0_rad"]
        duty = np.clip(gain * error, -1.0, 1.0)
        table["duty_0"] = np.where(table["enabled_0"] > 0, duty, 0.0)
        table.drop(columns="load_raw").to_csv(out / file, index=False)
        use = "validate" if file.startswith("kp400") else "fit"
        lines += _run_lines(file, 0, use, f"controller_gain = {gain:.9g}")
    drive = [
        "[joint.0.parameters]",
        "gravity_cos = { fixed = 0.0 }",
        f"gravity_sin = {{ fixed = {XL330_WEIGHT_NM:.6g} }}",
        "",
        "[joint.0.drive]",
        'kind = "duty"',
        "torque_constant = { initial = 0.4, lower = 0.05, upper = 3.0 }",
        "resistance_ohm = { initial = 3.0, lower = 1.0, upper = 10.0 }",
        "",
        "[joint.0.controller]",
        'kind = "p"',
        f"gain = {400 * XL330_DUTY_PER_RAD:.9g}",
        "limit = 1.0",
        "",
    ]
    head = _head_lines("Dynamixel XL330 with an arm and a mass")
    (out / "campaign.toml").write_text("\n".join([*head, *drive, *lines]), encoding="utf-8")


def copy_campaign(source: Path, out: Path) -> None:
    """Copy a set that is a campaign as it stands."""
    for path in sorted(source.iterdir()):
        shutil.copyfile(path, out / path.name)


def _write_toml(out: Path, title: str, joint: int, uses: dict[str, str]) -> None:
    lines = _head_lines(title)
    for file, use in uses.items():
        lines += _run_lines(file, joint, use)
    (out / "campaign.toml").write_text("\n".join(lines), encoding="utf-8")


def _head_lines(title: str) -> list[str]:
    return ["[campaign]", f'title = "{title}"', 'device = "single_joint"', "measured = true", ""]


def _run_lines(file: str, joint: int, use: str, *more: str) -> Sequence[str]:
    return ["[[runs]]", f'file = "{file}"', f"free_joints = [{joint}]", f'use = "{use}"', *more, ""]
