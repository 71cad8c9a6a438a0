"""A small campaign on disk, from which each test changes one thing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.real_data import DATA

TOML = """[campaign]
title = "A test"
device = "single_joint"
measured = false

[sensor]
noise_rad = 2e-4
resolution_rad = 1.5e-4

[joint.4.parameters]
inertia = { initial = 2.2e-4, lower = 2e-5, upper = 2e-3 }

[[runs]]
file = "a.csv"
free_joints = [4]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [4]
use = "validate"
"""


class Folder:
    """A campaign folder whose text and tables can be changed."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.toml = path / "campaign.toml"
        self.toml.write_text(TOML)
        t = np.arange(40) * 0.005
        self.frame = pd.DataFrame({"time_s": t, "torque_4_Nm": np.cos(20 * t), "position_4_rad": 0.1 * np.sin(20 * t)})
        for name in ("a.csv", "b.csv"):
            self.frame.to_csv(path / name, index=False)

    def replace(self, old: str, new: str) -> None:
        text = self.toml.read_text()
        assert old in text
        self.toml.write_text(text.replace(old, new, 1))

    def line(self, number: int, text: str, name: str = "a.csv") -> None:
        """Put ``text`` on a line of a table (the header is line 1)."""
        lines = (self.path / name).read_text().splitlines()
        lines[number - 1] = text
        (self.path / name).write_text("\n".join(lines) + "\n")


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    path = tmp_path / "campaign"
    path.mkdir()
    return Folder(path)


@pytest.fixture(scope="session")
def shared() -> Path:
    return DATA
