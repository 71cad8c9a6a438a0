"""Lines above a header that say how many counts make a turn."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.naming.encoder_counts import counts_of_a_turn
from haptid.measurement.naming.encoder_lines import counts_in_line
from haptid.measurement.new import main
from haptid.measurement.tables.table import Table


def told_by(*lines: str) -> tuple[int, str] | None:
    tables = [Table(path=Path(f"{k}.csv"), frame=pd.DataFrame(), preamble=(line,)) for k, line in enumerate(lines)]
    told = counts_of_a_turn(tables)
    return (told[0].number, told[0].file) if len(told) == 1 and told[0].number is not None else None


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
    ("line", "number"),
    [
        ("# encoder: 1024 lines, quadrature x4", 4096),
        ("# resolution: 1024 CPR x4", 4096),
        ("encoder;PPR;500;4x decoding", 2000),
        ("lines per turn = 1024 (x 2)", 2048),
        ("# 1024 x 4 counts/rev", 4096),
        ("encoder 1024 cycles per revolution, x1", 1024),
        ("counts per turn: 4096 (1024 lines x4)", 4096),
        ("# encoder: 1,024 lines, quadrature x4", 4096),
        ("# encoder: 1024 lines, quadrature: off", 1024),
        ("encoder 1024 PPR, no quadrature", 1024),
        ("# absolute encoder: 12 bit", 4096),
        ("# encoder resolution 14-bit", 16384),
    ],
)
def test_lines_of_an_encoder_times_what_each_makes(line: str, number: int):
    assert told_by("# rig 3", line) == (number, "1.csv")


@pytest.mark.parametrize(
    ("line", "counts"),
    [
        ("# encoder: 1024 lines, quadrature", (4096, 2048, 1024)),
        ("resolution: 1024 CPR", (4096, 2048, 1024)),  # cycles, or counts
        ("PPR: 1024, gear x4", (4096, 2048, 1024)),
        ("# 1024 lines per turn, x40", (4096, 2048, 1024)),
        ("counts per turn: 4096, x4", (4096, 16384)),  # is the factor in the number?
    ],
)
def test_what_may_be_several_numbers_is_open(line: str, counts: tuple[int, ...]):
    read = counts_in_line(line)
    assert read is not None
    assert read.counts == counts


@pytest.mark.parametrize(
    "line",
    ["# 3000 lines x4", "# 10 cycles at 4x speed", "12 bit ADC", "encoder 1.024 CPR x4", "# 1024.5 PPR x4", "x4"],
)
def test_lines_that_are_none_of_an_encoder_say_nothing(line: str):
    assert counts_in_line(line) is None


@pytest.mark.parametrize(
    ("lines", "number"),
    [
        (("# encoder: 1024 lines", "# quadrature: x4"), 4096),
        (("# decoding: 2x", "# encoder PPR = 500"), 1000),
        (("# encoder: 1024 lines", "# quadrature: x4", "# decoder x 2"), None),  # two factors
        (("# encoder: 1024 lines", "# gear x4"), None),
        (("# counts per turn: 4096", "# quadrature: x4"), 4096),
    ],
)
def test_the_factor_may_stand_in_a_line_of_its_own(lines: tuple[str, ...], number: int | None):
    (told,) = counts_of_a_turn([Table(path=Path("a.csv"), frame=pd.DataFrame(), preamble=lines)])
    assert told.number == number
    if number == 4096 and "lines" in lines[0]:
        assert told.says == "a.csv says 'encoder: 1024 lines; quadrature: x4'"
        assert told.means == ", which is 1024 × 4"


def test_a_number_explains_a_line_that_leaves_it_open():
    assert told_by("# encoder: 1024 lines", "# counts per turn: 4096") == (4096, "1.csv")
    assert told_by("# encoder: 1024 lines", "# counts per turn: 5000") is None


@pytest.mark.parametrize(
    "lines",
    [
        ("# discounts per turn: 4096",),
        ("# lines per turn: 1024",),  # a line makes one, two or four counts
        ("# encoder: 1024 lines", "# counts per turn: 8000"),
        ("# 4096.5 counts per turn",),
        ("# counts per turn: 0",),
        ("# counts per turn: 4096", "# counts per turn: 8192"),
        (),
    ],
)
def test_what_does_not_say_one_number_is_left_alone(lines: tuple[str, ...]):
    assert told_by(*lines) is None


def counted_table(path: Path, name: str, *lines: str) -> None:
    """Write a table with a position in counts, and lines above its header."""
    t = np.arange(400) * 0.005
    joint = re.sub(r"\D", "", name) or "0"
    counts = np.round(300 * np.sin(3 * t)).astype(int)
    frame = pd.DataFrame({"time_s": t, f"torque_{joint}_Nm": np.cos(3 * t), name: counts})
    path.parent.mkdir(exist_ok=True)
    path.write_text("".join(f"{line}\n" for line in lines) + frame.to_csv(index=False))


def made(folder: Path, *more: str) -> Result:
    return CliRunner().invoke(main, [str(folder), "--measured", "--out", str(folder.parent / "made"), *more])


def test_tables_of_one_joint_that_say_different_counts_are_refused(tmp_path: Path):
    folder = tmp_path / "tables"
    counted_table(folder / "a.csv", "encoder counts", "# counts per turn: 4096")
    counted_table(folder / "b.csv", "encoder counts", "# counts per turn: 8192")
    counted_table(folder / "c.csv", "encoder counts", "# counts per turn: 8192")
    done = made(folder)
    assert done.exit_code == 2
    assert (
        "a.csv, b.csv: expected one number of counts per turn, got 4096 ('counts per turn: 4096' in a.csv) and 8192 "
        "('counts per turn: 8192' in b.csv); a joint has one encoder: make a campaign of each, or state by --resolution"
    ) in done.output
    assert made(folder, "--resolution", "2*pi/4096").exit_code == 0


def test_tables_of_different_joints_are_told_the_angle_of_each(tmp_path: Path):
    folder = tmp_path / "tables"
    counted_table(folder / "a.csv", "joint 1 encoder counts", "# counts per turn: 4096")
    counted_table(folder / "b.csv", "joint 2 encoder counts", "# counts per turn: 8192")
    done = made(folder)
    assert done.exit_code == 2
    options = re.findall(r"--map '([^']*)'", done.output)
    assert options == [
        "joint 1 encoder counts=position_1_rad*2*pi/4096",
        "joint 2 encoder counts=position_2_rad*2*pi/8192",
    ]
    done = made(folder, *(word for option in options for word in ("--map", option)))
    assert done.exit_code == 0, done.output
    travels = [np.ptp(run.y) for run in read_campaign(tmp_path / "made").runs]
    np.testing.assert_allclose(travels, [600 * 2 * np.pi / 4096, 600 * 2 * np.pi / 8192])


def test_a_table_without_counts_says_nothing_of_those_of_another(tmp_path: Path):
    folder = tmp_path / "tables"
    counted_table(folder / "a.csv", "position_0_rad", "# counts per turn: 4096")
    counted_table(folder / "b.csv", "encoder counts", "# counts per turn: 8192")
    assert "a count is 2*pi/8192 rad: b.csv says" in made(folder).output


def test_a_script_says_how_lines_make_counts(tmp_path: Path):
    counted_table(tmp_path / "tables" / "log.csv", "encoder counts", "# encoder: 1024 lines, quadrature x4")
    done = made(tmp_path / "tables")
    assert done.exit_code == 0, done.output
    says = "log.csv says 'encoder: 1024 lines, quadrature x4' above its header, which is 1024 × 4 (--resolution)"
    assert f"a count is 2*pi/4096 rad: {says}" in done.output
    assert np.ptp(read_campaign(tmp_path / "made").runs[0].y) == pytest.approx(600 * 2 * np.pi / 4096)


def test_a_script_is_told_of_a_line_that_leaves_the_counts_open(tmp_path: Path):
    counted_table(tmp_path / "tables" / "log.csv", "encoder counts", "# encoder: 1024 CPR")
    done = made(tmp_path / "tables")
    assert done.exit_code == 2
    assert (
        "log.csv: expected the counts of a turn, got 'encoder: 1024 CPR'; is it multiplied by 4 (quadrature)? "
        "--resolution 2*pi/4096, else 2*pi/1024"
    ) in done.output


def test_a_script_takes_the_step_from_the_file_and_says_so(tmp_path: Path):
    counted_table(tmp_path / "tables" / "log.csv", "encoder counts", "# counts per turn: 4096")
    done = made(tmp_path / "tables")
    assert done.exit_code == 0, done.output
    assert (
        "a count is 2*pi/4096 rad: log.csv says 'counts per turn: 4096' above its header (--resolution)" in done.output
    )
    assert np.ptp(read_campaign(tmp_path / "made").runs[0].y) == pytest.approx(600 * 2 * np.pi / 4096)
