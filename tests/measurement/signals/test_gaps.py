"""Rows that a recorder lost: found on an even clock and on one with jitter, not where times are irregular anyway."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.measurement.checks.preparation import ready_for_fits
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.gaps import find_gaps
from tests.measurement.making.test_real_tables import run_init
from tests.measurement.making.test_usable_rows import STEP, make, table

ROWS = 1500
EVEN = 0.002 * np.arange(ROWS)
RNG = np.random.default_rng(0)
JITTER = EVEN + 0.0008 * RNG.random(ROWS)
ROUNDED = np.round(0.0025 * np.arange(ROWS), 3)
EVENTS = np.cumsum(RNG.exponential(0.002, ROWS))
ADAPTIVE = np.cumsum(np.where(np.arange(ROWS) % 10, 0.002, 0.02))


def without(t: np.ndarray, begin: int, rows: int) -> np.ndarray:
    return np.delete(t, np.arange(begin, begin + rows))


def late(t: np.ndarray, begin: int, rows: int) -> np.ndarray:
    """Return times of which some were written late, one close after the other."""
    late_rows = np.arange(begin, begin + rows)
    changed = t.copy()
    changed[late_rows] = t[begin + rows] - 1e-5 * (begin + rows - late_rows)
    return changed


@pytest.mark.parametrize(
    ("t", "expected"),
    [
        (EVEN, []),
        (without(EVEN, 700, 2), []),
        (without(EVEN, 700, 3), [700]),
        (without(without(EVEN, 900, 5), 300, 60), [300, 840]),
        (without(JITTER, 700, 60), [700]),
        (without(ROUNDED, 700, 60), [700]),
        # A recorder that loses single rows all the time: its gap is long beside those.
        (without(np.delete(EVEN, np.arange(5, 1400, 20)), 700, 60), [700]),
        (late(EVEN, 700, 60), []),
        (EVENTS, []),
        (ADAPTIVE, []),
        (without(EVEN, 700, 60)[::-1], []),
        (np.where(np.arange(ROWS) == 900, np.nan, EVEN), []),
        (EVEN[:1], []),
    ],
)
def test_only_lost_rows_are_gaps(t: np.ndarray, expected: list[int]):
    assert np.flatnonzero(find_gaps(t)).tolist() == expected


def with_gap() -> pd.DataFrame:
    return table().drop(index=range(1000, 1030))


def test_init_cuts_where_rows_are_absent(tmp_path: Path):
    done, runs = make(tmp_path, {"a.csv": with_gap()}, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    assert [(run.file, run.t.size) for run in runs] == [("a_1.csv", 1000), ("a_2.csv", 470)]
    assert runs[1].start_time == pytest.approx(EVEN[1030])
    assert "cut where rows are missing, into 2 runs" in done.stdout


def test_parts_take_no_name_of_another_table(tmp_path: Path):
    tables = {"a.csv": with_gap(), "a_1.csv": table(torque_0_Nm=np.sin(EVEN))}
    done, runs = make(tmp_path, tables, "--resolution", STEP)
    assert done.returncode == 0, done.stderr
    assert {run.file: run.t.size for run in runs} == {"a_2.csv": 1000, "a_3.csv": 470, "a_1.csv": 1500}


def test_a_gap_of_a_campaign_that_is_read_is_remarked(tmp_path: Path):
    (tmp_path / "tables").mkdir()
    table().to_csv(tmp_path / "tables" / "a.csv", index=False)
    run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured", "--resolution", STEP)
    made = pd.read_csv(tmp_path / "made" / "a.csv")
    made.drop(index=range(1000, 1030)).to_csv(tmp_path / "made" / "a.csv", index=False)
    campaign = ready_for_fits(read_campaign(tmp_path / "made"))
    assert {run.file for run in campaign.runs} == {"a.csv"}
    (gap,) = [remark for remark in campaign.remarks if "gap" in remark]
    assert gap.startswith("a.csv, joint 0: a gap of 0.062 s after 1.998 s: rows are missing")
