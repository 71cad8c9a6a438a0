"""Lines above a header that say how many counts make a turn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.naming.encoder_counts import counts_of_a_turn
from haptid.measurement.new import main
from haptid.measurement.tables.table import Table


def told_by(*lines: str) -> tuple[int, str] | None:
    tables = [Table(path=Path(f"{k}.csv"), frame=pd.DataFrame(), preamble=(line,)) for k, line in enumerate(lines)]
    told = counts_of_a_turn(tables)
    return None if told is None else (told.counts, told.file)


@pytest.mark.parametrize(
    "line",
    [
        "# counts per turn: 4096",
        "encoder;counts/rev;4096",
        "4096 counts per revolution",
        "% 4096 ticks/rev, gear 50",
        "Counts per revolution = 4096",
        "counts per turn: 4096.0",
    ],
)
def test_counts_of_a_turn_are_read(line: str):
    assert told_by("# rig 3", line) == (4096, "1.csv")


@pytest.mark.parametrize(
    "lines",
    [
        ("# discounts per turn: 4096",),
        ("# lines per turn: 1024",),  # a line makes one, two or four counts
        ("# 4096.5 counts per turn",),
        ("# counts per turn: 0",),
        ("# counts per turn: 4096", "# counts per turn: 8192"),
        (),
    ],
)
def test_what_does_not_say_one_number_is_left_alone(lines: tuple[str, ...]):
    assert told_by(*lines) is None


def test_a_script_takes_the_step_from_the_file_and_says_so(tmp_path: Path):
    folder, t = tmp_path / "tables", np.arange(400) * 0.005
    folder.mkdir()
    counts = np.round(300 * np.sin(3 * t)).astype(int)
    frame = pd.DataFrame({"time_s": t, "torque_0_Nm": np.cos(3 * t), "encoder counts": counts})
    (folder / "log.csv").write_text("# counts per turn: 4096\n" + frame.to_csv(index=False))
    made = CliRunner().invoke(main, [str(folder), "--measured", "--out", str(tmp_path / "made")])
    assert made.exit_code == 0, made.output
    assert (
        "a count is 2*pi/4096 rad: log.csv says 'counts per turn: 4096' above its header (--resolution)" in made.output
    )
    assert np.ptp(read_campaign(tmp_path / "made").runs[0].y) == pytest.approx(600 * 2 * np.pi / 4096)
