"""Times written as dates are read as seconds from the first row; other texts are refused with what they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.measurement.making.logged_table import read_logged_table
from haptid.measurement.making.times import assume_time, with_counter_counted_on, with_seconds
from haptid.measurement.naming.mapping import Target
from haptid.measurement.tables.table import Table, read_table
from haptid.support.errors import InputError

ROWS = 12
START = pd.Timestamp("2026-03-12T23:59:59.980")


def written(folder: Path, name: str = "time_s", form: str = "%Y-%m-%dT%H:%M:%S.%f", **more: object) -> Path:
    moments = START + pd.to_timedelta(4 * np.arange(ROWS), unit="ms")
    columns = {name: moments.strftime(form), "torque (Nm)": 0.5, "angle (rad)": np.arange(ROWS) * 0.1, **more}
    pd.DataFrame(columns).to_csv(folder / "a.csv", index=False)
    return folder / "a.csv"


@pytest.mark.parametrize("name", ["time_s", "Timestamp", "Zeitstempel", "time_ms"])
@pytest.mark.parametrize(
    "form",
    ["%Y-%m-%dT%H:%M:%S.%f", "%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f+01:00", "%d.%m.%Y %H:%M:%S.%f"],
)
def test_dates_are_seconds_from_the_first_row(tmp_path: Path, name: str, form: str):
    table, told = with_seconds(read_logged_table(written(tmp_path, name, form))[0])
    assert told == f"dates in {name!r}, read as seconds from the first row"
    np.testing.assert_allclose(table.numbers("time_s"), 0.004 * np.arange(ROWS), atol=1e-9)


def test_times_of_day_pass_midnight(tmp_path: Path):
    table, _ = with_seconds(read_logged_table(written(tmp_path, "time", "%H:%M:%S.%f"))[0])
    np.testing.assert_allclose(table.numbers("time_s"), 0.004 * np.arange(ROWS), atol=1e-9)


@pytest.mark.parametrize("stem", ["", "header.stamp.", "stamp_"])
def test_two_parts_of_a_stamp_are_one_time(tmp_path: Path, stem: str):
    """As ROS exports them: whole seconds alone were taken for the time, and nanoseconds for a current."""
    nanoseconds = 1_790_000_000_990_000_000 + 4_000_000 * np.arange(ROWS)
    parts = {f"{stem}sec": nanoseconds // 10**9, f"{stem}nanosec": nanoseconds % 10**9}
    pd.DataFrame(parts | {"torque (Nm)": 0.5, "angle (rad)": 0.1}).to_csv(tmp_path / "a.csv", index=False)
    table, told = with_seconds(read_logged_table(tmp_path / "a.csv")[0])
    assert told == f"'{stem}sec' and '{stem}nanosec', read as seconds from the first row"
    assert table.columns == ("time_s", "torque (Nm)", "angle (rad)")
    np.testing.assert_allclose(table.numbers("time_s"), 0.004 * np.arange(ROWS), atol=1e-9)


def test_a_mapped_column_keeps_its_name(tmp_path: Path):
    table, _ = with_seconds(read_logged_table(written(tmp_path, "Uhr"))[0], {"Uhr"})
    np.testing.assert_allclose(table.numbers("Uhr")[:2], [0.0, 0.004], atol=1e-9)


def test_dates_beside_a_time_are_left(tmp_path: Path):
    table, told = with_seconds(read_logged_table(written(tmp_path, "Datum", time_s=np.arange(ROWS)))[0])
    assert (told, table.columns[0]) == ("", "Datum")


def test_dates_of_parquet(tmp_path: Path):
    moments = START + pd.to_timedelta(4 * np.arange(ROWS), unit="ms")
    pd.DataFrame({"time": moments, "torque_0_Nm": 0.5}).to_parquet(tmp_path / "a.parquet")
    table, _ = with_seconds(read_table(tmp_path / "a.parquet"))
    np.testing.assert_allclose(table.numbers("time_s"), 0.004 * np.arange(ROWS), atol=1e-9)


def test_durations_of_parquet(tmp_path: Path):
    durations = pd.to_timedelta(5.0 + 0.004 * np.arange(ROWS), unit="s")
    table = Table(path=tmp_path, frame=pd.DataFrame({"time": durations, "torque_0_Nm": 0.5}), in_memory=True)
    np.testing.assert_allclose(with_seconds(table)[0].numbers("time_s"), 0.004 * np.arange(ROWS), atol=1e-9)


@pytest.mark.parametrize(
    ("columns", "taken"),
    [
        ({"Time": 0.002}, "Time"),
        ({"timestamp": 0.01}, "timestamp"),
        ({"elapsed_time": 0.01, "torque_0_Nm": 1.0}, "elapsed_time"),
        ({"t": 2.0}, "t"),  # as milliseconds are
        ({"t": 2000.0}, "t"),  # as microseconds are
        ({"t": 0.2}, ""),  # of 0.2 ms or of 0.2 s
        ({"t": 5e-7}, ""),  # as hours are
        ({"t": -0.002}, ""),
        ({"t": 0.002, "Time (ms)": 2.0}, ""),
        ({"t": 0.002, "time_s": 0.002}, ""),
        ({"t": 0.002, "time": 0.002}, ""),
        ({"time_0": 0.002}, ""),
        ({"clock drift": 0.002}, ""),
        ({"stated": 0.002, "Time": 0.002}, ""),
    ],
)
def test_a_time_without_a_unit_is_in_the_only_one_that_is_likely(tmp_path: Path, columns: dict[str, float], taken: str):
    frame = pd.DataFrame({name: 1.7e9 + step * np.arange(ROWS) for name, step in columns.items()})
    table = Table(path=tmp_path, frame=frame, in_memory=True)
    made, assumed = assume_time(table, {"stated": Target(name="time_s")} if "stated" in columns else {})
    assert ("" if assumed is None else assumed.column) == taken
    assert list(made.columns) == ["time_s" if name == taken else name for name in columns]
    if taken:
        assert np.diff(made.numbers("time_s")) == pytest.approx(2e-3 if columns[taken] != 0.01 else 0.01, rel=1e-3)


def test_a_cell_that_is_no_number_stays_where_a_unit_was_assumed(tmp_path: Path):
    frame = pd.DataFrame({"Zeit": ["0", "4", "x", "12"]})
    made, assumed = assume_time(Table(path=tmp_path, frame=frame, in_memory=True), {})
    assert assumed is not None
    assert (assumed.unit, assumed.other) == ("ms", "in seconds: --map 'Zeit=time_s'")
    assert made.frame["time_s"].tolist() == [0.0, 0.004, "x", 0.012]


def test_dates_with_dots_are_of_the_day_that_comes_first(tmp_path: Path):
    """One day and one night later, by a table of decimal commas."""
    rows = ["Zeitstempel;Moment [Nm];Winkel [°]"]
    rows += [f"{1 + k % 2}.{12 - k}.2026 9:00:00,5;0,5;0,{k}" for k in range(ROWS)]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    table, told = with_seconds(read_logged_table(tmp_path / "a.csv")[0])
    assert told == "dates in 'Zeitstempel', read as seconds from the first row"
    days = table.numbers("time_s") / 86400.0
    np.testing.assert_array_equal(days[:3], [0.0, -29.0, -61.0])


def test_dates_with_slashes_after_the_year_are_read(tmp_path: Path):
    rows = ["stamp;Moment [Nm];Winkel [°]", *(f"2026/{1 + k % 2}/{12 - k} 9:00:00,5;0,5;0,{k}" for k in range(ROWS))]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    table, _ = with_seconds(read_logged_table(tmp_path / "a.csv")[0])
    np.testing.assert_array_equal(table.numbers("time_s")[:3] / 86400.0, [0.0, 30.0, -2.0])


@pytest.mark.parametrize("date", ["03/12/2026", "3-12-2026", "12.03.26"])
def test_a_date_whose_order_is_not_certain_is_refused_at_once(tmp_path: Path, date: str):
    """The advice to name its column led to a second error."""
    rows = ["Zeitstempel,Moment [Nm],Winkel [°]", *(f"{date} 10:00:00.{k:03d},0.5,0.{k}" for k in range(ROWS))]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    table = read_logged_table(tmp_path / "a.csv")[0]
    with pytest.raises(InputError) as caught:
        with_seconds(table)
    told = f"a.csv, line 2, Zeitstempel: expected a date of one day, got '{date} 10:00:00.000'; the order of the date"
    assert told in str(caught.value)
    assert "write ISO 8601, as 2026-03-12T10:00:00.004" in str(caught.value)
    # Beside a time it is no hindrance.
    timed = Table(path=tmp_path, frame=table.frame.assign(time_s=np.arange(ROWS)), in_memory=True)
    assert with_seconds(timed)[1] == ""


def test_a_cell_that_is_no_date_is_shown(tmp_path: Path):
    path = written(tmp_path)
    lines = path.read_text().splitlines()
    lines[5] = "ERR,0.5,0.4"
    path.write_text("\n".join(lines) + "\n")
    table, _ = with_seconds(read_logged_table(path)[0])
    with pytest.raises(InputError, match=r"a\.csv, line 6, time_s: expected a finite number, got 'ERR'; correct"):
        table.numbers("time_s")


@pytest.mark.parametrize(
    ("cell", "told"),
    [
        ("2026-03-12T10:00:00.000", "and no number in any other row; dates are read where a campaign is made"),
        ("12.03.2026 10:00:00.000", "and no number in any other row; dates are read where a campaign is made"),
        ("03/12/2026 10:00:00 AM", "the order of the date is not certain: write ISO 8601"),
        ('"1,000.0"', "'1,000.0' and no number in any other row; export without commas between thousands"),
        ('"1,000,000"', "export without commas between thousands"),
        ('"1,5"', "where a comma is the decimal sign"),
        ("start", "got 'start' and no number in any other row; correct the cell"),
    ],
)
def test_a_column_without_numbers_says_what_it_holds(tmp_path: Path, cell: str, told: str):
    (tmp_path / "a.csv").write_text("time_s,torque_0_Nm\n" + f"{cell},0.5\n" * ROWS)
    with pytest.raises(InputError) as caught:
        read_table(tmp_path / "a.csv").numbers("time_s")
    assert told in str(caught.value)


@pytest.mark.parametrize(("fall", "counted"), [(2**32, True), (2**31, False)])
def test_a_counter_of_microseconds_that_begins_anew_is_counted_on(fall: int, counted: bool):
    """A log across the 71st minute was refused: 0.000704 s after 4294.964 s."""
    ticks = 2**32 - 6000 + 4000 * np.arange(10)
    wrapped = np.where(ticks >= 2**32, ticks - fall, ticks)
    frame = pd.DataFrame({"micros": wrapped.astype(str), "tau": 0.0})
    table = Table(path=Path("log.csv"), frame=frame)
    made, remark = with_counter_counted_on(table, {"micros": Target(name="time_s", factor=1e-6)})
    assert bool(remark) is counted
    assert (np.diff(made.loosely("micros")) == 4000).all() == counted
    assert with_counter_counted_on(table, {"micros": Target(name="time_s", factor=1.0)})[1] == ""


def test_a_column_of_empty_dates_is_no_time():
    """It ended in an IndexError."""
    frame = pd.DataFrame({"time": pd.Series([pd.NaT] * ROWS, dtype="datetime64[ns]"), "torque_0_Nm": 0.5})
    table = Table(path=Path("a"), frame=frame, in_memory=True)
    assert with_seconds(table) == (table, "")
