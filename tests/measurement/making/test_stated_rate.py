"""A table without a time takes it from the rate that a line before its header states."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.making.logged_table import read_logged_table
from haptid.measurement.making.stated_rate import with_time_of_rate
from haptid.measurement.naming.mapping import Target
from haptid.measurement.tables.table import Table

ROWS = 12


def logged(folder: Path, line: str, names: str = "sample,torque (Nm),angle (deg)", count: str = "{}") -> Table:
    rows = [f"{count.format(n)},0.5,{n}.5" if names.startswith("sample") else f"0.5,{n}.5" for n in range(3, 3 + ROWS)]
    (folder / "a.csv").write_text("\n".join(["Logger 7", line, names, *rows]) + "\n", encoding="utf-8")
    return read_logged_table(folder / "a.csv")[0]


@pytest.mark.parametrize(
    ("line", "interval"),
    [
        ("Sampling rate: 250 Hz", 0.004),
        ("# Sample Rate [Hz]: 250", 0.004),
        ("sample rate (kHz),0.25", 0.004),
        ("fs = 250", 0.004),
        ("Abtastrate;250 Hz", 0.004),
        ("Scan rate: 1e3 samples/s", 0.001),
        ("Sample time: 4 ms", 0.004),
        ("dt = 0.004 s", 0.004),
        ("Abtastzeit: 4,0 ms", 0.004),
        ("Sampling interval 4000 µs", 0.004),
    ],
)
def test_the_counter_becomes_the_time(tmp_path: Path, line: str, interval: float):
    table, told = with_time_of_rate(logged(tmp_path, line), {})
    assert table.columns == ("time_s", "torque (Nm)", "angle (deg)")
    np.testing.assert_allclose(table.numbers("time_s"), interval * np.arange(ROWS), rtol=1e-12)
    assert told == f"'sample' as the number of the row; rows {interval:.6g} s apart as {line!r} says"


def test_rows_are_counted_where_no_column_does(tmp_path: Path):
    table, told = with_time_of_rate(logged(tmp_path, "Sampling rate: 500 Hz", "torque (Nm),angle (deg)"), {})
    np.testing.assert_allclose(table.numbers("time_s"), 0.002 * np.arange(ROWS), rtol=1e-12)
    assert told.startswith("no time; rows 0.002 s apart")


def test_a_row_that_is_missing_is_missed(tmp_path: Path):
    """A counter that goes on by two left a row out: the time does as well."""
    logged(tmp_path, "Sampling rate: 250 Hz")
    path = tmp_path / "a.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([*lines[:5], *lines[6:]]) + "\n", encoding="utf-8")
    table, _ = with_time_of_rate(read_logged_table(path)[0], {})
    np.testing.assert_allclose(np.diff(table.numbers("time_s")), [0.004, 0.008, *[0.004] * (ROWS - 4)], rtol=1e-12)


@pytest.mark.parametrize(
    "line",
    [
        "PWM frequency: 20 kHz",
        "Sampling rate: unknown",
        "Sampling rate: 0 Hz",
        "Sampling rate: 250 rpm",
        "Sampling rate: 1 Hz",
        "Sample mass: 250 g",
    ],
)
def test_other_lines_state_no_rate(tmp_path: Path, line: str):
    table = logged(tmp_path, line)
    assert with_time_of_rate(table, {}) == (table, "")


def test_rates_that_differ_are_not_guessed(tmp_path: Path):
    table = logged(tmp_path, "Sampling rate: 250 Hz\nSample time: 1 ms")
    assert with_time_of_rate(table, {}) == (table, "")


def test_a_time_of_the_table_goes_before(tmp_path: Path):
    table = logged(tmp_path, "Sampling rate: 250 Hz", "sample,time (ms),angle (deg)")
    assert with_time_of_rate(table, {})[1] == ""
    table = logged(tmp_path, "Sampling rate: 250 Hz")
    assert with_time_of_rate(table, {"sample": Target(name="time_s", factor=0.01)})[1] == ""
