"""TOML and JSON that would trip a reader up end in one line."""

from __future__ import annotations

import pytest

from haptid.support.errors import InputError
from haptid.support.files.data import parse_json, parse_toml

HUGE = "9" * 400
LONGER = "9" * 5000
DEEP = "[" * 5000 + "]" * 5000


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = 1\nb = [", "a.toml, line 2: expected valid TOML"),
        (f"a = 1\nb = {HUGE}", "a.toml, line 2: expected numbers of at most 64 bits, got a number of 400 digits"),
        (f"a = 1\nb = {LONGER}", "a.toml, line 2: expected numbers of at most 64 bits, got a number of 5000 digits"),
        (f"b = {DEEP}", "a.toml: expected at most 64 levels of brackets"),
        (
            f"f = 0.{HUGE}\nb = {HUGE}",
            "a.toml, line 2: expected numbers of at most 64 bits, got a number of 400 digits",
        ),
        ("b = 0xFFFFFFFFFFFFFFFFFF", "a.toml: b: expected numbers of at most 64 bits, got a number of 22 digits"),
        ("b = " + "[" * 70 + "]" * 70, "a.toml: expected at most 64 levels of brackets"),
        ("[a]\nb = [1.0, nan]", r"a.toml: a.b[1]: expected a finite number, got nan"),
        ("[a]\nmass = inf", r"a.toml: a.mass: expected a finite number, got inf"),
    ],
)
def test_toml_is_refused(text: str, words: str):
    with pytest.raises(InputError) as caught:
        parse_toml(text, "a.toml", finite=True)
    assert str(caught.value).startswith(words)


def test_an_open_bound_may_be_infinite():
    found = parse_toml("upper = inf\nposition_limits = [-inf, inf]", "a.toml", finite=True)
    assert found["upper"] == float("inf")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"a": 1,\n', "a.json, line 2: expected JSON"),
        ('{"a": [1, NaN]}', "a.json: a[1]: expected JSON, got NaN"),
        ('{"a": {"b": -Infinity}}', "a.json: a.b: expected JSON, got -Infinity"),
        ('{"c": {"a": 1, "a": 2}}', "a.json: c: expected JSON, got 'a' twice in one object"),
        (
            f'{{"f": 0.{HUGE}, "a": {HUGE}}}',
            "a.json: a: expected numbers of at most 64 bits, got a number of 400 digits",
        ),
        ('{"a": 1, "a": 2}', "a.json: expected JSON, got 'a' twice in one object"),
        (f'{{"f": 0.{HUGE}, "a": {LONGER}}}', "a.json: a: expected numbers of at most 64 bits, got a number of 5000"),
        ('{"a": -9223372036854775809}', "a.json: a: expected numbers of at most 64 bits, got a number of 19 digits"),
        (DEEP, "a.json: expected at most 64 levels of brackets"),
    ],
)
def test_json_is_refused(text: str, words: str):
    with pytest.raises(InputError) as caught:
        parse_json(text, "a.json")
    assert str(caught.value).startswith(words)
