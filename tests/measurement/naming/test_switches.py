"""The names of a motor's switch."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from haptid.measurement.naming.joint_names import understand_table
from haptid.measurement.tables.table import Table, read_table


def table_of(folder: Path, name: str, cells: list[float]) -> Table:
    """Return a table of one joint with a further column."""
    file = folder / "a.csv"
    columns = {"time_s": range(8), "torque_0_Nm": 1.0, "position_0_rad": 0.0, name: 2 * cells}
    pd.DataFrame(columns).to_csv(file, index=False)
    return read_table(file, as_text=True)


@pytest.mark.parametrize("name", ["torque_enabled", "Motor Enable", "servo_enabled_0"])
def test_a_switch_is_taken(tmp_path: Path, name: str) -> None:
    table = table_of(tmp_path, name, [1, 0, 0, 1])
    assert understand_table(table, {}, None, {})[name].name == "enabled_0"


@pytest.mark.parametrize(
    ("name", "cells"),
    [("torque_enabled", [1, 1, 1, 1]), ("torque_enabled", [0, 3, 7, 7]), ("brake_enabled", [1, 0, 0, 1])],
)
def test_a_state_or_the_switch_of_something_else_is_not(tmp_path: Path, name: str, cells: list[float]) -> None:
    assert understand_table(table_of(tmp_path, name, cells), {}, None, {}) == {}
