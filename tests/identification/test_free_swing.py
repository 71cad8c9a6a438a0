"""Runs of a free swing: no torque was recorded, so that one stated value gives gravity and friction their scale."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result
from scipy.integrate import solve_ivp

from haptid.identification.baseline.baseline import fit_baseline
from haptid.identification.run import main as identify
from haptid.measurement.check import main as check
from tests.identification.plain_joint import plain_run

INERTIA, WEIGHT, VISCOUS, COULOMB = 0.052, 1.21, 0.0031, 0.0042
TOML = """[campaign]
device = "single_joint"
measured = false

[sensor]
noise_rad = 5e-4

[[runs]]
file = "a.csv"
free_joints = [0]
use = "fit"

[[runs]]
file = "c.csv"
free_joints = [0]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [0]
use = "validate"
"""


def swing(start: float, seed: int) -> pd.DataFrame:
    """Return a pendulum that is let go at an angle [rad], with a torque of zeros and noise on the position."""

    def slope(_: float, x: list[float]) -> list[float]:
        torque = -WEIGHT * np.sin(x[0]) - VISCOUS * x[1] - COULOMB * np.tanh(x[1] / 1e-3)
        return [x[1], torque / INERTIA]

    t = np.arange(0.0, 6.0, 0.005)
    y = solve_ivp(slope, (0.0, t[-1]), [start, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=0.005).y[0]
    noise = 5e-4 * np.random.default_rng(seed).standard_normal(t.size)
    return pd.DataFrame({"time_s": t, "torque_0_Nm": np.zeros(t.size), "position_0_rad": y + noise})


def write(folder: Path, known: str = "") -> Path:
    folder.mkdir()
    swing(1.5, 0).to_csv(folder / "a.csv", index=False)
    swing(2.0, 1).to_csv(folder / "b.csv", index=False)
    swing(2.6, 2).to_csv(folder / "c.csv", index=False)
    (folder / "campaign.toml").write_text(f"{TOML}\n[joint.0.parameters]\n{known}\n", encoding="utf-8")
    return folder


def run_identify(folder: Path) -> tuple[Result, dict[str, object]]:
    out = folder.parent / "out"
    arguments = [str(folder), "--out", str(out), "--fmu", "none", "--no-export", "--starts", "2"]
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        result = CliRunner().invoke(identify, arguments)
    assert result.exit_code == 0, result.output
    (configuration,) = json.loads((out / "identification.json").read_text())["configurations"]
    return result, configuration


def test_without_a_scale_a_free_swing_ends_as_unexcited(tmp_path: Path):
    result, found = run_identify(write(tmp_path / "swing"))
    assert found["outcome"] == "unexcited"
    for said in ("end of its range", "never leave presliding", "more than all that acted"):
        assert said not in result.output
    assert "identified" not in {one["status"] for one in found["parameters"].values()}
    assert "inertia = { fixed = 0.05 }" in result.stderr
    assert "swings freely" in result.stdout
    assert "ends at 0 N m" not in result.stdout
    assert found["runs"][0]["figures"]["model"]["torque_error"] is None


@pytest.mark.parametrize(
    "known", [f"inertia = {{ fixed = {INERTIA} }}", f"gravity_sin = {{ fixed = {WEIGHT} }}"], ids=["inertia", "gravity"]
)
def test_one_stated_value_gives_the_rest(known: str, tmp_path: Path):
    result, found = run_identify(write(tmp_path / "swing", known))
    values = {id: one["value"] for id, one in found["parameters"].items()}
    assert found["outcome"] == "converged"
    assert values["inertia"] == pytest.approx(INERTIA, rel=0.01)
    assert values["gravity_sin"] == pytest.approx(WEIGHT, rel=0.01)
    assert values["sigma2"] == pytest.approx(VISCOUS, rel=0.1)
    assert values["Fc"] == pytest.approx(COULOMB, rel=0.1)
    assert "ends at 0 N m" not in result.stdout
    assert "no gravity" not in result.stdout
    told = CliRunner().invoke(check, [str(tmp_path / "swing")])
    assert "free swing" not in told.output


def test_a_torque_that_never_changes_tells_no_delay():
    runs = [plain_run(seed, seconds=5.0) for seed in (1, 2)]
    for torque in (0.0, 0.3):
        found = fit_baseline([run.but(u=np.full(run.u.shape, torque)) for run in runs], None, (), [1.0])
        assert found.delay is None
    # One run without torque must not make its weight infinite either.
    assert fit_baseline([runs[0], runs[1].but(u=np.zeros(runs[1].u.shape))], None, (), [1.0]) is not None
