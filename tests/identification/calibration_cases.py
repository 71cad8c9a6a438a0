"""Campaigns about reference FMUs, simulated by fmpy with other values than the FMUs' own."""

from __future__ import annotations

import shutil
from pathlib import Path

import fmpy
import numpy as np
import pandas as pd

from tests.real_data import DATA

DECAY = """[campaign]
title = "decay"
measured = false
model = "decay.fmu"
[outputs]
x = { column = "level", noise = 0.005 }
[parameters]
k = { initial = 1.0, lower = 0.1, upper = 5.0 }
[[runs]]
file = "a.csv"
use = "fit"
start = { x = 2.0 }
[[runs]]
file = "b.csv"
use = "validate"
"""
BALL = """[campaign]
title = "ball"
measured = false
model = "ball.fmu"
[outputs]
h = { column = "h", noise = 0.01 }
[parameters]
g = { initial = -9.81, lower = -12.0, upper = -7.0 }
e = { initial = 0.7, lower = 0.5, upper = 1.0 }
[[runs]]
file = "a.csv"
use = "fit"
[[runs]]
file = "b.csv"
use = "validate"
start = { h = 1.5 }
"""


def simulated(fmu: Path, t, start, outputs, seed=0, noise=0.0):
    """Simulate an FMU by fmpy and return a table with white noise."""
    result = fmpy.simulate_fmu(
        str(fmu),
        stop_time=float(t[-1]),
        output_interval=float(t[1] - t[0]),
        start_values=start,
        output=outputs,
        fmi_type="CoSimulation",
        record_events=False,
    )
    rng = np.random.default_rng(seed)
    columns = {name: result[name] + noise * rng.standard_normal(result.size) for name in outputs}
    return pd.DataFrame({"time_s": result["time"].round(9), **columns})


def write_decay(folder: Path, version: str = "fmi2") -> Path:
    """Write a campaign about ẋ = −k·x with k = 0.63; its second run begins at the FMU's own start value."""
    folder.mkdir(parents=True, exist_ok=True)
    fmu = shutil.copy(DATA / "foreign_fmus" / version / "Dahlquist.fmu", folder / "decay.fmu")
    t = np.linspace(0.0, 4.0, 41)
    for seed, (file, start) in enumerate((("a.csv", 2.0), ("b.csv", 1.0))):
        table = simulated(fmu, t, {"k": 0.63, "x": start}, ["x"], seed, 0.005)
        table.rename(columns={"x": "level"}).to_csv(folder / file, index=False)
    (folder / "campaign.toml").write_text(DECAY, encoding="utf-8")
    return folder


def write_ball(folder: Path, version: str = "fmi2") -> Path:
    """Write a campaign about a bouncing ball with g = −9.3 m/s² and e = 0.82: its cost has jumps."""
    folder.mkdir(parents=True, exist_ok=True)
    fmu = shutil.copy(DATA / "foreign_fmus" / version / "BouncingBall.fmu", folder / "ball.fmu")
    t = np.linspace(0.0, 2.0, 201)
    for seed, (file, start) in enumerate((("a.csv", 1.0), ("b.csv", 1.5))):
        table = simulated(fmu, t, {"g": -9.3, "e": 0.82, "h": start}, ["h"], seed, 0.01)
        table.to_csv(folder / file, index=False)
    (folder / "campaign.toml").write_text(BALL, encoding="utf-8")
    return folder
