"""CSV files as loggers and spreadsheets write them."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.making.logged_table import find_layout, read_logged_table
from haptid.support.errors import InputError

ROWS = [(0.01 * k, 1.5 - 0.1 * k, 0.25 * k) for k in range(12)]
NAMES = ("time_s", "torque_0_Nm", "Angle (°)")


def write(path: Path, separator: str, *, comma: bool = False, before: str = "", encoding: str = "utf-8") -> Path:
    lines = [separator.join(NAMES), *(separator.join(f"{x:.4f}" for x in row) for row in ROWS)]
    text = "\n".join(lines) + "\n"
    text = text.replace(".", ",") if comma else text
    path.write_bytes((before + text).encode(encoding))
    return path


@pytest.mark.parametrize(
    ("separator", "options", "words"),
    [
        (",", {}, ""),
        (";", {}, "semicolons"),
        (";", {"comma": True}, "semicolons, decimal commas"),
        ("\t", {"comma": True}, "tabs, decimal commas"),
        (",", {"before": "Logger 3\nrate: 100 Hz\n\n"}, "3 lines before the header"),
        (";", {"before": "Date;2026\n", "comma": True}, "semicolons, decimal commas, 1 line before the header"),
        (",", {"before": "# "}, "a comment sign before the header"),
        (",", {"encoding": "cp1252"}, ""),
    ],
)
def test_layouts_are_understood(tmp_path: Path, separator: str, options: dict[str, object], words: str):
    path = write(tmp_path / "a.csv", separator, **options)
    table, told = read_logged_table(path)
    assert told == words
    assert table.columns == NAMES
    np.testing.assert_allclose(np.stack([table.numbers(name) for name in NAMES], axis=1), ROWS, atol=1e-12)


def test_a_line_of_units_is_read_with_the_names(tmp_path: Path):
    rows = "\n".join(",".join(map(str, row)) for row in ROWS)
    (tmp_path / "a.csv").write_text(f"Time,Torque,Angle\n(s),(Nm),(deg)\n{rows}\n", encoding="utf-8")
    table, told = read_logged_table(tmp_path / "a.csv")
    assert (table.columns, told) == (("Time (s)", "Torque (Nm)", "Angle (deg)"), "a line of units")


def test_a_first_row_without_numbers_is_no_header(tmp_path: Path):
    (tmp_path / "a.csv").write_text("time_s,torque_0_Nm\nnan,nan\n" + "\n".join(f"{k},{k}" for k in range(9)) + "\n")
    table, told = read_logged_table(tmp_path / "a.csv")
    assert (table.columns, told) == (("time_s", "torque_0_Nm"), "")


def test_an_error_names_the_line_of_the_file(tmp_path: Path):
    path = write(tmp_path / "a.csv", ";", comma=True, before="one\ntwo\n")
    path.write_text(path.read_text(encoding="utf-8").replace("1,4000", "x"), encoding="utf-8")
    table, _ = read_logged_table(path)
    assert path.read_text(encoding="utf-8").splitlines()[4 - 1].split(";")[1] != "x"
    with pytest.raises(InputError, match=r"a.csv, line 5, torque_0_Nm: expected a finite number, got 'x'"):
        table.numbers("torque_0_Nm")


@pytest.mark.parametrize("lines", [[], ["a,b"], ["1,2", "3,4", "5,6", "7,8"], ["a b", "1 2", "3 4", "5 6"]])
def test_no_header_is_guessed(lines: list[str]):
    assert find_layout(lines) is None


@pytest.mark.parametrize(("separator", "before", "line"), [(",", "", 1), (";", "Logger 3\n\n", 3)])
def test_a_column_named_twice_is_no_other_joint(tmp_path: Path, separator: str, before: str, line: int):
    rows = [separator.join(("time_s", "torque (Nm)", "angle (rad)", "angle (rad)"))]
    rows += [separator.join(f"{x:.4f}" for x in (*row, 0.0)) for row in ROWS]
    (tmp_path / "a.csv").write_text(before + "\n".join(rows) + "\n")
    with pytest.raises(
        InputError, match=rf"line {line}: expected each column once, got 2 columns named 'angle \(rad\)'"
    ):
        read_logged_table(tmp_path / "a.csv")


@pytest.mark.parametrize("sign", [";", "\t"])
@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_file_of_a_few_rows_has_too_few_whatever_separates_them(tmp_path: Path, sign: str, rows: int):
    """One row between semicolons was refused for its semicolons, which more rows may have."""
    (tmp_path / "a.csv").write_text("\n".join([sign.join(NAMES), *([sign.join(["0,1"] * 3)] * rows)]), encoding="utf-8")
    with pytest.raises(InputError, match=rf"a\.csv: expected at least 8 rows, got {rows}$"):
        read_logged_table(tmp_path / "a.csv")


@pytest.mark.parametrize(("separator", "comma"), [(",", False), (";", True)])
def test_a_gzipped_table_is_read_as_the_one_that_it_packs(tmp_path: Path, separator: str, comma: bool):
    line = "# encoder: 1024 lines, quadrature x4"
    plain = write(tmp_path / "a.csv", separator, comma=comma, before=f"{line}\n")
    packed = tmp_path / "a.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    (table, words), (same, same_words) = read_logged_table(plain), read_logged_table(packed)
    assert same_words == words
    assert same.preamble == table.preamble == (line,)
    assert same.path == packed
    assert same.frame.equals(table.frame)


def test_a_packed_table_without_its_ending_is_said_to_be_packed(tmp_path: Path):
    (tmp_path / "a.csv").write_bytes(gzip.compress(b"time_s,torque_0_Nm\n"))
    with pytest.raises(InputError, match=r"a\.csv: expected a table of a run, got one packed by gzip; name it .csv.gz"):
        read_logged_table(tmp_path / "a.csv")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_a_text_in_utf_16_is_read(tmp_path: Path, encoding: str):
    """As spreadsheets write what they call Unicode text."""
    text = (
        "\ufeff" * (encoding != "utf-16")
        + "time_s\tM (Nm)\tangle (°)\n"
        + "".join(f"{k}\t0.5\t{k}\n" for k in range(9))
    )
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    table, words = read_logged_table(tmp_path / "a.csv")
    assert (words, table.columns) == ("tabs", ("time_s", "M (Nm)", "angle (°)"))
    assert table.numbers("angle (°)")[8] == 8.0


def test_a_damaged_gzipped_table_is_said_to_be_damaged(tmp_path: Path):
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(b"# rig 3\ntime_s;torque_0_Nm\n" + b"0,1;2\n" * 4000)[:-20])
    with pytest.raises(InputError, match="a damaged archive"):
        read_logged_table(path)


def test_quoted_decimal_commas_between_commas_are_read(tmp_path: Path):
    quoted = "\n".join(",".join(f'"{x:.4f}"' for x in row).replace(".", "@") for row in ROWS).replace("@", ",")
    (tmp_path / "a.csv").write_text(",".join(NAMES) + "\n" + quoted + "\n", encoding="utf-8")
    table, told = read_logged_table(tmp_path / "a.csv")
    assert told == "decimal commas"
    np.testing.assert_allclose(np.stack([table.numbers(name) for name in NAMES], axis=1), ROWS, atol=1e-12)


def test_quoted_commas_that_may_part_thousands_are_not_taken_for_decimal_ones(tmp_path: Path):
    rows = "\n".join(f'"1,{k:03d}","2,{k:03d}"' for k in range(9))
    (tmp_path / "a.csv").write_text("time_ms,torque_mNm\n" + rows + "\n", encoding="utf-8")
    table, told = read_logged_table(tmp_path / "a.csv")
    assert told == ""
    with pytest.raises(InputError, match="a comma"):
        table.numbers("torque_mNm")
