"""Input errors: one line of at most 300 characters that a terminal can show."""

from __future__ import annotations

import pickle

from hypothesis import given
from hypothesis import strategies as st

from haptid.support.errors import LONGEST, InputError

TEXTS = st.text(max_size=900)


@given(where=TEXTS, expected=TEXTS, got=TEXTS, todo=TEXTS)
def test_any_parts_make_one_short_printable_line(where: str, expected: str, got: str, todo: str) -> None:
    error = InputError(where, expected=expected, got=got, todo=todo)
    assert len(str(error)) <= LONGEST
    assert str(error).isprintable()


@given(where=TEXTS, got=TEXTS)
def test_the_line_crosses_processes_unchanged(where: str, got: str) -> None:
    error = InputError(where, expected="a number", got=got)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_what_is_long_gives_way_to_what_is_short() -> None:
    error = InputError("campaign.toml, line 3, title", expected="a text", got="x" * 5000, todo="shorten it")
    assert str(error).startswith("campaign.toml, line 3, title: expected a text, got xxx")
    assert str(error).endswith("xxx; shorten it")


def test_a_remedy_of_up_to_half_a_line_stays_whole() -> None:
    todo = "use --map 'observation.effort.shoulder.position=torque_0_Nm' --map 'angle of the left elbow=position_0_rad'"
    error = InputError("/long" * 40, expected="columns time_s, torque_<j>_Nm", got="x, " * 100, todo=todo)
    assert len(str(error)) <= LONGEST
    assert str(error).endswith(f"; {todo}")
