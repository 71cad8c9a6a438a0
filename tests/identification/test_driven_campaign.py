"""The command on a campaign with a drive: fitted through the recorded controller, written, and exported again."""

from __future__ import annotations

import json
from pathlib import Path

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner

from haptid.fmu_build import export
from haptid.identification import run
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.values.run import Run
from haptid.model.equations.drive import Controller, Drive
from haptid.model.joint.drive_terms import drive_inputs
from haptid.model.joint.locked_joint import joint_equations

TRUTH = {
    "inertia": 0.006, "gravity_sin": 0.48, "Ks": 0.0, "sigma0": 20.0, "sigma1": 0.05, "sigma2": 0.01, "vs": 0.1,
    "Fs": 0.055, "Fc": 0.05, "torque_constant": 0.4, "resistance_ohm": 3.0,
}  # fmt: skip
# Back-EMF and viscous friction add up, unless the motor is let go while the joint moves.
FIXED = ("gravity_sin", "Ks", "sigma0", "sigma1", "vs")
T = np.arange(0.0, 3.0, 0.005)


def write_campaign(folder: Path, truth: dict[str, float] = TRUTH, stated: tuple[str, ...] = FIXED) -> None:
    drive = Drive(kind="duty", controller=Controller(kind="p", gain=0.6, limit=0.5))
    equations, noise = joint_equations(0, drive=drive), np.random.default_rng(0)
    theta = np.array([truth.get(q.id, q.initial) for q in equations.parameters])
    entries = ""
    enabled = ((T < 1.2) | (T > 1.6)).astype(float)
    for name, rate, use in (("a", 2.5, "fit"), ("b", 1.7, "validate")):
        reference, supply = 1.2 * np.sin(rate * T), 7.4 + 0.2 * np.sin(0.7 * T)
        columns = {
            "reference": reference, "supply": supply, "enabled": enabled, "controller_gain": 0.6 + 0.0 * T,
        }  # fmt: skip
        made = Run(
            file=name, free_joints=(0,), t=T, u=np.zeros((T.size, 1)), y=np.zeros((T.size, 1)), noise=np.zeros(1),
            resolution=np.zeros(1), posture=np.zeros(0), use="fit",
            drive_inputs={x.id: columns[x.id] for x in drive_inputs(drive)},
        )  # fmt: skip
        position = KernelSimulator.of(equations).simulate(theta, made).y[:, 0] + noise.normal(0.0, 1e-4, T.size)
        table = np.column_stack((T, reference, position, supply, enabled))
        header = "time_s,reference_0_rad,position_0_rad,supply_V,enabled_0"
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=header, comments="")
        entries += f'[[runs]]\nfile = "{name}.csv"\nfree_joints = [0]\nuse = "{use}"\n'
    known = "".join(f"{id} = {{ fixed = {truth[id]} }}\n" for id in stated)
    known += "epos = { fixed = 0.0 }\n" if "Ks" in stated else ""
    (folder / "campaign.toml").write_text(
        '[campaign]\ndevice = "single_joint"\nmeasured = false\n[sensor]\nnoise_rad = 1e-4\nresolution_rad = 0.0\n'
        f"[joint.0.parameters]\ngravity_cos = {{ fixed = 0.0 }}\n{known}"
        '[joint.0.drive]\nkind = "duty"\nresistance_ohm = { initial = 4.0, lower = 1.0, upper = 10.0 }\n'
        "torque_constant = { initial = 0.3, lower = 0.05, upper = 3.0 }\n"
        f'[joint.0.controller]\nkind = "p"\ngain = 0.6\nlimit = 0.5\n{entries}',
        encoding="utf-8",
    )


@pytest.mark.long
def test_the_command_fits_and_exports_a_drive(tmp_path: Path):
    write_campaign(tmp_path)
    out = tmp_path / "out"
    fitted = CliRunner().invoke(run.main, [str(tmp_path), "--out", str(out), "--fmu", "native", "--quiet"])
    assert fitted.exit_code == 0, fitted.output
    (found,) = json.loads((out / "identification.json").read_text(encoding="utf-8"))["configurations"]
    assert found["drive"]["kind"] == "duty"
    assert "reference" in found["why"]
    assert found["floor"]["unit"] == "N m"
    assert found["floor"]["value"] > 0
    for id in ("torque_constant", "resistance_ohm", "inertia"):
        entry = found["parameters"][id]
        assert abs(entry["value"] - TRUTH[id]) < 0.03 * TRUTH[id]
        assert entry["std"] > 0
    for entry in found["runs"]:
        assert entry["figures"]["model"]["closed_rmse"] < 1.5e-4
        assert entry["figures"]["baseline"]["closed_rmse"] > entry["figures"]["model"]["closed_rmse"]
    fmu = tmp_path / "joint.fmu"
    options = ["--from", str(out / "identification.json"), "--out", str(fmu), "--kind", "native"]
    exported = CliRunner().invoke(export.main, options)
    assert exported.exit_code == 0, exported.output
    names = {variable.name for variable in fmpy.read_model_description(fmu).modelVariables}
    assert {"joint0.controller.reference", "joint0.drive.supply", "joint0.drive.resistance"} <= names


@pytest.mark.long
@pytest.mark.parametrize(("vs", "stiction"), [(0.05, 0.12), (0.4, 0.09)])
def test_all_parameters_of_a_driven_joint_from_its_known_weight(vs: float, stiction: float, tmp_path: Path):
    truth = TRUTH | {"vs": vs, "Fs": stiction}
    write_campaign(tmp_path, truth, stated=("gravity_sin",))
    out = tmp_path / "out"
    fitted = CliRunner().invoke(run.main, [str(tmp_path), "--out", str(out), "--no-export", "--quiet"])
    assert fitted.exit_code == 0, fitted.output
    (found,) = json.loads((out / "identification.json").read_text(encoding="utf-8"))["configurations"]
    assert found["outcome"] == "converged"
    for id in set(truth) - {"gravity_sin", "Ks"}:
        entry = found["parameters"][id]
        assert entry["status"] == "identified", id
        assert abs(entry["value"] - truth[id]) < 4.0 * entry["std"], id
    assert "no spring is seen" in fitted.output


def test_the_first_guess_of_a_drive_comes_from_weight_and_back_emf(tmp_path: Path):
    write_campaign(tmp_path, stated=("gravity_sin",))
    campaign = campaign_for_command(tmp_path)
    equations = equations_for(campaign, None, (0,))
    for id in ("torque_constant", "resistance_ohm"):
        assert abs(equations.parameter(id).initial / TRUTH[id] - 1.0) < 0.1
    assert equations.parameter("resistance_ohm").upper == 10.0
    write_campaign(tmp_path, stated=())
    equations = equations_for(campaign_for_command(tmp_path), None, (0,))
    assert equations.parameter("torque_constant").initial == 0.3, "without a known weight no torque is known in N m"
