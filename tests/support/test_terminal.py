"""What people see while a command runs: bars and tables on a terminal, few plain lines and plain text elsewhere."""

from __future__ import annotations

import io
import re

import pytest

from haptid.support.tables import Table, text_of
from haptid.support.terminal import LINE_EVERY_S, Display, clock, show

TABLE = Table(header=("parameter", "value", "status"), rows=[("inertia", "0.25", "identified"), ("Ks", "-", "fixed")])


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


class Clock:
    """A clock that stands until a test moves it."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_a_log_gets_few_lines(capsys: pytest.CaptureFixture[str]):
    clock = Clock()
    display = Display(now=clock)
    for step in range(1001):  # 100 s in steps of 0.1 s
        display.show("joint 4 (1 of 2)", step / 500, 2, f"start {step}")
        clock.now += 0.1
    told = capsys.readouterr().err
    lines = told.splitlines()
    assert 2 <= len(lines) <= 1 + 100.0 / LINE_EVERY_S
    assert lines[0] == "joint 4 (1 of 2): 2 %, 0:02, about 1:38 left; start 21"
    assert lines[1] == "joint 4 (1 of 2): 12 %, 0:12, about 1:28 left; start 122"
    assert "\r" not in told


def test_the_end_is_foretold_from_the_pace_of_the_present_count():
    clock = Clock()
    display = Display(now=clock)
    display.show("nominal fit")
    clock.now += 60.0
    display.show("candidates", 0, 10)
    clock.now += 5.0
    display.show("candidates", 5, 10)
    assert display.times() == "1:05, about 0:05 left"
    display.show("rivals", 0, 4)
    assert display.times() == "1:05"


def test_work_that_was_done_before_is_no_measure_of_what_is_left():
    clock = Clock()
    display = Display(now=clock)
    display.show("joint 2 (7 of 8)", 6, 8)
    clock.now += 10.0
    display.show("joint 2 (7 of 8)", 7, 8)
    assert display.times() == "0:10, about 0:10 left"


def test_an_end_that_slows_down_is_foretold_from_the_later_half():
    """Four seconds were left for two minutes: the first starts are quick, the last ones are not."""
    clock = Clock()
    display = Display(now=clock)
    display.show("joint 0", 0, 100)
    for done in range(1, 80):  # 79 % in 26 s
        clock.now += 1.0 / 3.0
        display.show("joint 0", done, 100)
    for done in range(80, 98):  # a per cent in 6 s
        clock.now += 6.0
        display.show("joint 0", done, 100)
    assert display.times() == "2:14, about 0:18 left"


def test_an_end_that_does_not_come_moves_away():
    clock = Clock()
    display = Display(now=clock)
    display.show("joint 0", 0, 100)
    clock.now += 10.0
    display.show("joint 0", 90, 100)
    assert display.times() == "0:10, about 0:01 left"
    clock.now += 50.0
    assert display.times() == "1:00, about 1:00 left"


def test_quiet_says_nothing(capsys: pytest.CaptureFixture[str]):
    Display(quiet=True).show("joint 4", 1, 2)
    assert capsys.readouterr().err == ""


def test_a_terminal_gets_a_bar_that_is_taken_away(monkeypatch: pytest.MonkeyPatch):
    stream = Terminal()
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setattr("sys.stderr", stream)
    display = Display()
    display.show("joint 4", 1, 4, "start 2 of 2")
    display.close()
    assert " 25 %" in stream.getvalue()
    assert re.search(r"joint 4 0:0\d · start 2 of 2", stream.getvalue())  # a loaded machine may need a second
    assert stream.getvalue().rstrip().endswith("\x1b[2K")  # the line is erased


def test_a_dumb_terminal_gets_lines(monkeypatch: pytest.MonkeyPatch):
    stream = Terminal()
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr("sys.stderr", stream)
    clock = Clock()
    display = Display(now=clock)
    display.show("joint 4", 0, 4)
    clock.now += 3.0
    display.show("joint 4", 1, 4)
    assert stream.getvalue() == "joint 4: 25 %, 0:03, about 0:09 left\n"


def test_a_pipe_gets_the_plain_text(capsys: pytest.CaptureFixture[str]):
    show(["before", TABLE])
    assert (
        capsys.readouterr().out
        == "before\nparameter  value  status\ninertia    0.25   identified\nKs         -      fixed\n"
    )


def test_a_terminal_gets_a_drawn_table_with_the_same_cells(monkeypatch: pytest.MonkeyPatch):
    stream = Terminal()
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setattr("sys.stdout", stream)
    show([Table(header=TABLE.header, rows=TABLE.rows, plain="a sentence for each"), "[not markup]"])
    drawn = stream.getvalue()
    assert all(cell in drawn for row in (TABLE.header, *TABLE.rows) for cell in row)
    assert "a sentence for each" not in drawn
    assert "[not markup]" in drawn
    assert "─" in drawn


def test_a_plain_table_may_have_a_rule_or_a_text_of_its_own():
    ruled = Table(header=("a", "bb"), rows=[("1", "2")], ruled=True)
    assert text_of([ruled, Table(header=("a",), rows=[("1",)], plain="a is 1")]) == "a  bb\n-----\n1  2\na is 1"


def test_clocks():
    assert [clock(s) for s in (0.4, 59.6, 3599.6)] == ["0:00", "1:00", "1:00:00"]
