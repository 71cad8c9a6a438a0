"""Messages on the page of errors are those of the code."""

from __future__ import annotations

import ast
import re
from functools import cache

import pytest

from haptid.support.installing.environment import ROOT

PAGE = (ROOT / "docs" / "how-to" / "error_messages.md").read_text(encoding="utf-8")
PACKAGES = ("model", "measurement", "fmu_build", "identification", "noise", "uq", "discrepancy", "support", "api")
MESSAGES = [
    message
    for line in PAGE.splitlines()
    if line.startswith("| `")
    for message in re.findall(r"`([^`]+)`", line.split(" | ")[0])
]


@cache
def said_by_the_code() -> str:
    """All strings of the packages, without what is filled in, one a line."""
    strings = []
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            strings += [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
    return "\n".join(strings)


def pieces(message: str) -> list[str]:
    """Fixed parts of a message: those between what is filled in, without the words that every error has."""
    parts = re.split(r"…|, got |^expected |; ", message)
    return [part.strip(" ,;(") for part in parts if part.strip(" ,;(")]


def test_the_page_has_messages():
    assert len(MESSAGES) > 35


@pytest.mark.parametrize("message", MESSAGES)
def test_a_message_of_the_page_is_in_the_code(message: str):
    lost = [piece for piece in pieces(message) if piece not in said_by_the_code()]
    assert not lost


def test_a_message_that_nothing_says_is_noticed():
    assert any(piece not in said_by_the_code() for piece in pieces("expected a purple column, got none"))
