"""Tables as loggers leave them: empty and repeated rows, counters that wrap, files that overlap, texts."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.logged_table import is_table, read_logged_table
from haptid.measurement.making.usable_rows import wrap_period
from haptid.support.errors import InputError
from tests.measurement.making.test_real_tables import ARM, run_init

COUNTS = 4096
STEP = 2.0 * math.pi / COUNTS
T = 0.002 * np.arange(1500)
ANGLE = 2.5 * np.sin(2.0 * T)


def table(**changes: object) -> pd.DataFrame:
    """Return a run of one joint whose counter wraps twice, with other columns where stated."""
    counts = (np.round(ANGLE / STEP).astype(int) + 3000) % COUNTS
    return pd.DataFrame({"time_s": T, "torque_0_Nm": np.cos(2.0 * T), "position counts": counts, **changes})


def make(folder: Path, frames: dict[str, pd.DataFrame], *arguments: object):
    (folder / "tables").mkdir()
    for name, frame in frames.items():
        frame.to_csv(folder / "tables" / name, index=False)
    done = run_init(folder / "tables", "--out", folder / "made", "--measured", *arguments)
    return done, (read_campaign(folder / "made").runs if done.returncode == 0 else ())


def test_a_counter_that_wraps_is_counted_on(tmp_path: Path):
    done, runs = make(tmp_path, {"a.csv": table()}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(runs[0].y[:, 0] - runs[0].y[0, 0], ANGLE, atol=STEP)
    assert "position_0_rad counted on where it wraps by 6.283 rad" in done.stderr + done.stdout


@pytest.mark.parametrize(
    ("y", "turns", "step", "period"),
    [
        (ANGLE, True, None, 0.0),
        (np.mod(ANGLE + 1.0, 2.0 * math.pi), True, None, 2.0 * math.pi),
        (np.mod(np.round(ANGLE / 1e-5) * 1e-5 + 0.05, 65536e-5), False, 1e-5, 65536e-5),
        # A spike of a turn is no wrap: the reading does not go on from it as the motion did.
        (np.where(np.arange(T.size) == 700, ANGLE + 9.0, ANGLE), True, None, 0.0),
        (np.where(T > 1.5, ANGLE + 4.0, ANGLE), True, None, 0.0),
        # A reference that goes to a turn at once has gone there.
        (np.where(T > 1.5, 2.0 * math.pi, 0.0), True, None, 0.0),
    ],
)
def test_only_a_jump_by_a_period_is_a_wrap(y: np.ndarray, turns: bool, step: float | None, period: float):
    assert wrap_period(y, turns=turns, step=step) == pytest.approx(period)


def test_rows_without_numbers_are_left_out_and_long_gaps_cut(tmp_path: Path):
    torque = np.cos(2.0 * T)
    torque[[200, 900, 901, *range(1000, 1030)]] = np.nan
    done, runs = make(tmp_path, {"a.csv": table(torque_0_Nm=torque)}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    assert [(run.file, run.t.size) for run in runs] == [("a_1.csv", 997), ("a_2.csv", 470)]
    assert runs[1].start_time == pytest.approx(T[1030])
    assert "without 33 rows with empty cells" in done.stderr + done.stdout
    assert "dropped" not in done.stdout


def test_parts_that_are_too_short_are_dropped_and_told(tmp_path: Path):
    rows = table().drop(index=[*range(1000, 1030), *range(1050, 1060)])
    done, runs = make(tmp_path, {"a.csv": rows}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    assert [run.t.size for run in runs] == [1000, 440]
    assert "cut where rows are missing, into 2 runs, 20 rows of shorter parts dropped" in done.stdout


@pytest.mark.parametrize(
    ("repeated", "told"),
    [((30,), "without 1 row that repeats a time"), ((30, 700), "without 2 rows that repeat a time")],
)
def test_rows_that_repeat_a_time_are_left_out(tmp_path: Path, repeated: tuple[int, ...], told: str):
    frame = table().iloc[np.sort(np.r_[0:1500, repeated])]
    done, runs = make(tmp_path, {"a.csv": frame}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(runs[0].t, T)
    assert told in done.stdout


def test_signals_of_two_rates_in_one_table_are_refused_as_before(tmp_path: Path):
    torque = np.where(np.arange(T.size) % 4 == 0, 1.0, np.nan)
    done, _ = make(tmp_path, {"a.csv": table(torque_0_Nm=torque)}, "--resolution", STEP)
    assert done.returncode == 2
    assert (
        "a.csv, line 3, torque_0_Nm: expected a finite number, got an empty or NaN cell; 1125 of 1500 rows"
        in done.stderr
    )


def test_a_cell_that_is_no_number_is_refused_with_its_line(tmp_path: Path):
    torque = pd.Series(np.cos(2.0 * T)).astype(object)
    torque[5], torque[900] = np.nan, "x"
    done, _ = make(tmp_path, {"a.csv": table(torque_0_Nm=torque)}, "--resolution", STEP)
    assert done.returncode == 2
    assert "expected a finite number" in done.stderr


def test_rows_that_two_files_share_count_once(tmp_path: Path):
    frame = table()
    frames = {"log_1.csv": frame.iloc[:900], "log_2.csv": frame.iloc[800:], "other.csv": table(torque_0_Nm=1.0)}
    done, runs = make(tmp_path, frames, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    assert [run.t.size for run in runs] == [900, 600, 1500]
    assert runs[1].start_time == pytest.approx(T[900])
    assert "without 100 rows that log_1.csv has as well" in done.stderr + done.stdout


@pytest.mark.parametrize(
    ("name", "factor"),
    [("Actual torque [%]", "0.024"), ("Torque actual value [0.1 %]", "0.0024"), ("torque ‰", "0.0024")],
)
def test_a_torque_in_per_cent_asks_for_the_rated_one(tmp_path: Path, name: str, factor: str):
    frame = table().rename(columns={"torque_0_Nm": name})
    done, _ = make(tmp_path, {"a.csv": frame}, "--resolution", STEP)
    assert done.returncode == 2
    assert f"--map '{name}=torque_0_Nm*{factor}' where it is 2.4 N m" in done.stderr


@pytest.mark.parametrize(
    ("header", "separator", "told"),
    [
        ("# Time [s]\tPosition [mm]\tForce [N]", "\t", "tabs, a comment sign before the header"),
        ("Time [s]  Position [mm]  Force [N]", "  ", "blanks"),
        ("time_s position_mm force_N", " ", "blanks"),
    ],
)
def test_texts_are_tables(tmp_path: Path, header: str, separator: str, told: str):
    rows = [separator.join((f"{0.01 * k:.2f}", f"{k}", "-3e-1")) for k in range(12)]
    (tmp_path / "a.txt").write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    (tmp_path / "notes.txt").write_text("The stage was warm.\nIt hums.\n", encoding="utf-8")
    read, layout = read_logged_table(tmp_path / "a.txt")
    assert (read.file_name, layout) == ("a.csv", told)
    np.testing.assert_allclose(read.numbers(read.columns[1]), np.arange(12.0))
    assert is_table(tmp_path / "a.txt")
    assert not is_table(tmp_path / "notes.txt")


def test_an_error_in_a_text_names_its_line(tmp_path: Path):
    rows = [f"{0.01 * k:.2f} {k}" for k in range(12)]
    rows[4] = "0.04 x"
    (tmp_path / "a.txt").write_text("\n".join(["time_s q_rad", *rows]) + "\n", encoding="utf-8")
    read, _ = read_logged_table(tmp_path / "a.txt")
    with pytest.raises(InputError, match=r"a.txt, line 6, q_rad: expected a finite number, got 'x'"):
        read.numbers("q_rad")


def test_texts_without_names_are_refused_with_what_to_write(tmp_path: Path):
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "a.txt").write_text("0 1\n1 2\n2 3\n", encoding="utf-8")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured")
    assert done.returncode == 2
    assert "a.txt: expected a table, got no line of names above numbers; write a line with the names" in done.stderr


def test_joints_that_are_counted_from_one(tmp_path: Path):
    columns = {"time_s": T}
    for joint in range(1, 7):
        columns |= {f"tau{joint} [Nm]": np.cos(T), f"q{joint} [deg]": 10.0 * joint * np.sin(T)}
    done, runs = make(tmp_path, {"a.csv": pd.DataFrame(columns)}, "--device", ARM)
    assert done.returncode == 0, done.stderr
    assert runs[0].free_joints == (0, 1, 2, 3, 4, 5)
    assert np.ptp(runs[0].y[:, 5]) == pytest.approx(np.deg2rad(60.0) * np.ptp(np.sin(T)))
    assert f"device {tmp_path / 'made'}" in done.stderr + done.stdout


def test_a_run_is_kept_from_fits_by_the_name_of_its_recording(tmp_path: Path):
    (tmp_path / "tables").mkdir()
    for name in ("a.txt", "b.txt"):
        text = table().to_csv(index=False, sep="\t")
        (tmp_path / "tables" / name).write_text(text, encoding="utf-8")
    arguments = ("--measured", "--resolution", STEP, "--validate", "b.txt")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", *arguments)
    assert done.returncode == 0, done.stderr
    uses = {run.file: run.use for run in read_campaign(tmp_path / "made").runs}
    assert uses == {"a.csv": "fit", "b.csv": "validate"}


def test_a_voltage_takes_what_the_motor_is_known_by(tmp_path: Path):
    frame = table().rename(columns={"torque_0_Nm": "voltage_V"})
    options = ("--resolution", STEP)
    done, _ = make(tmp_path, {"a.csv": frame}, *options)
    assert done.returncode == 0, done.stderr
    assert "state them by --torque-constant and --resistance" in done.stderr + done.stdout
    options += ("--torque-constant", 0.4, "--resistance", 2.3)
    done = run_init(tmp_path / "tables", "--out", tmp_path / "known", "--measured", *options)
    content = tomllib.loads((tmp_path / "known" / "campaign.toml").read_text(encoding="utf-8"))
    assert content["joint"]["0"]["drive"] == {"kind": "voltage", "torque_constant": 0.4, "resistance_ohm": 2.3}
    assert read_campaign(tmp_path / "known").drives[0].kind == "voltage"
    assert "--resistance" not in done.stderr + done.stdout


def test_the_torque_of_a_row_without_a_position_goes_into_the_row_before(tmp_path: Path):
    """It went with the row, so that the torque before was held for two rows: a fit left 1.14 times the noise."""
    frame = table()
    frame["position counts"] = frame["position counts"].astype(float)
    frame.loc[[400, 401, 900], "position counts"] = np.nan
    done, runs = make(tmp_path, {"a.csv": frame}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    whole, (run,) = table()["torque_0_Nm"].to_numpy(), runs
    assert run.t.size == T.size - 3
    np.testing.assert_allclose(run.u[399, 0], whole[399:402].mean(), rtol=1e-9)
    np.testing.assert_allclose(run.u[run.t == T[899], 0], whole[899:901].mean(), rtol=1e-9)
    np.testing.assert_allclose(run.u[[398, 400], 0], whole[[398, 402]], rtol=1e-9)


def test_between_rows_that_a_line_joins_nothing_is_carried(tmp_path: Path):
    frame = table()
    frame["position counts"] = frame["position counts"].astype(float)
    frame.loc[400, "position counts"] = np.nan
    done, runs = make(tmp_path, {"a.csv": frame}, "--resolution", STEP, "--hold", "linear")
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(runs[0].u[399, 0], table()["torque_0_Nm"][399], rtol=1e-9)
