"""JSON files: what is wrong is one line with the file in it, whatever is wrong."""

import pytest

from haptid.support.errors import InputError
from haptid.support.files.files import read_json

REFUSED = {
    "cut off": ('{"a": [1, 2', "line 1: expected JSON"),
    "nested": ("[" * 5_000 + "]" * 5_000, "64 levels of brackets"),
    "nested tables": ('{"a":' * 100_000, "64 levels of brackets"),
    "many digits": ('{"a": ' + "9" * 5_000 + "}", "numbers of at most 64 bits, got a number of 5000 digits"),
    "no double": ('{"a": ' + "9" * 350 + "}", "numbers of at most 64 bits"),
    "overflow": ('{"a": -1e999}', "a: expected a finite number, got -inf"),
    "NaN": ('{"a": NaN}', "got NaN"),
    "Infinity": ('{"a": -Infinity}', "got -Infinity"),
    "twice": ('{"a": {"b": 1, "b": 2}}', "got 'b' twice in one object"),
    "half a character": ('{"a": "\\ud800"}', "half of one"),
    "a list": ("[1]", "a table { … }, got list"),
    "empty": ("", "expected JSON"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_json_of_finite_numbers_is_refused_in_one_line(name, tmp_path):
    text, part = REFUSED[name]
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_json(path, "a result")
    line = str(caught.value)
    assert "a.json" in line
    assert part in line
    assert len(line) <= 300
    assert "\n" not in line


def test_what_is_no_text_file_is_refused(tmp_path):
    (tmp_path / "latin.json").write_bytes(b'{"a": "\xe4"}')
    for path, part in (
        (tmp_path / "latin.json", "text in UTF-8, got"),
        (tmp_path, "a result, a file, got a folder"),
        (tmp_path / "none.json", "No such file"),
        (tmp_path / ("x" * 300), "File name too long"),
        (tmp_path / "a\0b", "null"),
    ):
        with pytest.raises(InputError, match=part):
            read_json(path, "a result")


def test_a_byte_order_mark_and_a_character_in_two_halves_are_read(tmp_path):
    path = tmp_path / "a.json"
    path.write_bytes(b"\xef\xbb\xbf" + rb'{"a": "\ud83d\ude00", "b": [1e308, 1234567890123456789]}')
    assert read_json(path, "a result") == {"a": "\U0001f600", "b": [1e308, 1234567890123456789]}
