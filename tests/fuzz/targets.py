"""The readers that are fuzzed, in one table."""

from __future__ import annotations

import gzip
import io
from pathlib import Path

import numpy as np
import pandas as pd

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.tables.table import read_table
from tests.fuzz.devices import DEVICES
from tests.fuzz.fmi_calls import FMI_CALLS
from tests.fuzz.harness import Target
from tests.fuzz.others import OTHERS
from tests.fuzz.recordings import RECORDINGS
from tests.fuzz.results import RESULTS

FRAME = pd.DataFrame(
    {
        "time_s": np.arange(12) * 0.005,
        "torque_4_Nm": np.cos(np.arange(12.0)),
        "position_4_rad": 0.1 * np.sin(np.arange(12.0)),
    }
)
CSV = FRAME.to_csv(index=False).encode()
CAMPAIGN = b"""[campaign]
title = "A test"
device = "single_joint"
measured = false
hold = "zero"

[sensor]
noise_rad = 2e-4
resolution_rad = 1.5e-4

[joint.4]
torque_constant_Nm_per_A = 0.05

[joint.4.parameters]
inertia = { initial = 2.2e-4, lower = 2e-5, upper = 2e-3 }
Kp = { prior = { mean = 0.1, std = 0.01 } }
Fc = { fixed = 1e-3 }

[joint.4.sensor]
noise_rad = 3e-4

[[runs]]
file = "a.csv"
free_joints = [4]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [4]
use = "validate"
hold = "linear"
"""
SEVERAL_JOINTS = b"""[campaign]
device = "freedom6s"
measured = true

[[runs]]
file = "a.csv"
free_joints = [4]
locked_positions_rad = [0, 0.1, 0.2, 0, 0, 0]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [4]
use = "excluded"
reason = "stopped"
"""


def _parquet() -> bytes:
    stream = io.BytesIO()
    FRAME.to_parquet(stream, index=False)
    return stream.getvalue()


def read_campaign_file(content: bytes, folder: Path) -> None:
    """Read ``content`` as the ``campaign.toml`` beside two valid tables."""
    (folder / "campaign.toml").write_bytes(content)
    (folder / "a.csv").write_bytes(CSV)
    (folder / "b.csv").write_bytes(CSV.replace(b"0.1", b"0.2", 1))
    read_campaign(folder)


def _read_as(name: str, content: bytes, folder: Path) -> None:
    path = folder / name
    path.write_bytes(content)
    table = read_table(path)
    table.time()
    for column in table.columns:
        table.loosely(column)
    table.numbers("torque_4_Nm")


def read_csv(content: bytes, folder: Path) -> None:
    """Read ``content`` as a CSV table."""
    _read_as("a.csv", content, folder)


def read_gzipped_csv(content: bytes, folder: Path) -> None:
    """Read ``content`` as a gzipped CSV table."""
    _read_as("a.csv.gz", content, folder)


def read_parquet(content: bytes, folder: Path) -> None:
    """Read ``content`` as a Parquet table."""
    _read_as("a.parquet", content, folder)


_TARGETS = (
    Target(
        name="campaign", examples=(CAMPAIGN, SEVERAL_JOINTS), read=read_campaign_file, nasty=(b"[sensor]", b"a = 1")
    ),
    Target(name="csv", examples=(CSV, CSV.replace(b"\n", b"\r\n")), read=read_csv),
    Target(name="csv_gz", examples=(gzip.compress(CSV, mtime=0),), read=read_gzipped_csv),
    Target(name="parquet", examples=(_parquet(),), read=read_parquet),
)
TARGETS = {target.name: target for target in (*_TARGETS, *DEVICES, *RESULTS, *OTHERS, *RECORDINGS, *FMI_CALLS)}
