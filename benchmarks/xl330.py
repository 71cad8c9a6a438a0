"""A servo with a known weight, driven by its firmware: fitted in closed loop, judged on a gain that no fit saw.

``python -m benchmarks.xl330 FOLDER``: the folder holds the 16 tables of the Dynamixel XL330 of Rhoban's BAM.

1. Write the tables as a campaign: reference, supply, switch, and the firmware's gain of each run.
2. Fit kp 100, 200 and 800 through the firmware's loop; kp 400 is for validation.
3. Print the mean absolute error of the position from the measured start, without and with friction by load.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click
import numpy as np
import pandas as pd

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import load_folder
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations

WEIGHT_NM = 0.49 * 9.80665 * 0.1
ENCODER_STEP_RAD = 2 * np.pi / 4096
DUTY_PER_COUNT = 1 / (256 * 885)
"""Duty per count of error and unit of kp, from the data's README."""
JUDGED_GAIN = 400
"""Firmware gain whose runs no fit sees."""
COLUMNS = {
    "goal_rad": "reference_0_rad",
    "position_rad": "position_0_rad",
    "velocity_rad_s": "velocity_0_rad_s",
    "torque_enabled": "enabled_0",
    "temperature_C": "temperature_0_C",
}
HEAD = f"""[campaign]
title = "XL330"
device = "single_joint"
measured = true
[sensor]
noise_rad = 1e-3
resolution_rad = {ENCODER_STEP_RAD}
[joint.0.parameters]
gravity_cos = {{ fixed = 0.0 }}
gravity_sin = {{ fixed = {WEIGHT_NM} }}
Ks = {{ fixed = 0.0 }}
epos = {{ fixed = 0.0 }}
sigma0 = {{ initial = 20.0, lower = 5.0, upper = 300.0 }}
vs = {{ initial = 0.1, lower = 0.002, upper = 0.5 }}
Fs = {{ initial = 0.05, lower = 0.001, upper = 0.3 }}
Fc = {{ initial = 0.03, lower = 1e-4, upper = 0.2 }}
[joint.0.drive]
kind = "duty"
torque_constant = {{ initial = 0.4, lower = 0.05, upper = 3.0 }}
resistance_ohm = {{ initial = 3.0, lower = 1.0, upper = 10.0 }}
[joint.0.controller]
kind = "p"
gain = {100 / ENCODER_STEP_RAD * DUTY_PER_COUNT}
limit = 1.0
"""


def write_campaign(tables: Path, folder: Path) -> None:
    """Write the tables of a folder as a campaign."""
    entries = ""
    for path in sorted(tables.glob("kp*.csv")):
        table = pd.read_csv(path).drop(columns="load_raw").rename(columns=COLUMNS)
        table.to_csv(folder / path.name, index=False)
        kp = int(path.name.split("_")[0].removeprefix("kp"))
        use = "validate" if kp == JUDGED_GAIN else "fit"
        gain = kp / ENCODER_STEP_RAD * DUTY_PER_COUNT
        entries += f'[[runs]]\nfile = "{path.name}"\nfree_joints = [0]\nuse = "{use}"\ncontroller_gain = {gain}\n'
    (folder / "campaign.toml").write_text(HEAD + entries, encoding="utf-8")


def with_load_friction(base: Equations) -> Equations:
    """Add friction by load to the equations of the joint, at the known weight as reference."""
    effect = load_folder(Path(__file__).parent / "effects")["transmitted_load_friction"]
    equations = joint_equations(
        0, parameters=base.parameters, effects=[effect], drive=base.drive, friction=base.friction[0]
    )
    return equations.with_parameters(
        {"load_reference": {"initial": WEIGHT_NM, "lower": WEIGHT_NM, "upper": 2 * WEIGHT_NM, "fixed": True}}
    )


def mean_absolute_error_mrad(found: Fit, equations: Equations, runs: tuple[Run, ...], use: str) -> float:
    """Return the mean over the runs of one use of mean |simulated − measured|, simulated from the measured start."""
    simulator = KernelSimulator.of(equations)
    theta = np.array([found.values[q.id] for q in equations.parameters])
    errors = [np.mean(np.abs(simulator.simulate(theta, run).y - run.y)) for run in runs if run.use == use]
    return 1e3 * float(np.mean(errors))


@click.command()
@click.argument("tables", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--starts", default=8, show_default=True, help="Starts of each fit.")
def main(tables: Path, starts: int) -> None:
    """Print the errors of both models, and the drive that each finds."""
    with tempfile.TemporaryDirectory() as made:
        write_campaign(tables, Path(made))
        campaign = campaign_for_command(made)
    base = equations_for(campaign, None, (0,))
    for name, equations in (("LuGre", base), ("LuGre with friction by load", with_load_friction(base))):
        options = FitOptions(starts=starts, gains=(0.0,), method="gauss_newton")
        found = fit(KernelSimulator.of(equations), campaign.runs, options=options)
        fitted, judged = (mean_absolute_error_mrad(found, equations, campaign.runs, use) for use in ("fit", "validate"))
        std = dict(zip(found.free, np.sqrt(np.diag(found.covariance)), strict=True))
        drive = ", ".join(
            f"{id} {found.values[id]:.4g} ± {std.get(id, 0.0):.2g}" for id in ("torque_constant", "resistance_ohm")
        )
        print(f"{name}: fitted {fitted:.1f} mrad, kp {JUDGED_GAIN} {judged:.1f} mrad; {drive}")


if __name__ == "__main__":
    main()
