"""Whom a call of the API shows how far it is: a terminal and a notebook where nothing is said, else as it is told."""

from __future__ import annotations

import inspect
import io
import sys

import pytest

from haptid import Campaign, Identified
from haptid.api.arguments import listener_of
from haptid.support.listener import Listener


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


Notebook = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})
CALLS = (Campaign.identify, Campaign.posterior, Campaign.find_missing, Identified.posterior, Identified.find_missing)


@pytest.mark.parametrize(
    ("stream", "progress", "shown"),
    [
        (Terminal, None, True), (Notebook, None, True), (io.StringIO, None, False), (lambda: None, None, False),
        (Terminal, False, False), (io.StringIO, True, True),
    ],
)  # fmt: skip
def test_a_call_shows_how_far_it_is_where_somebody_watches(monkeypatch, stream, progress, shown):
    """An interactive session heard nothing for minutes."""
    told: list[bool] = []

    class Nobody:
        show = staticmethod(print)

        def __init__(self, *, quiet: bool) -> None:
            told.append(quiet)

        def close(self) -> None:
            pass

    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setattr("haptid.support.command.Display", Nobody)
    with listener_of(progress):
        pass
    assert told == [not shown]


def test_a_listener_is_taken_as_it_is():
    one = Listener()
    with listener_of(one) as listener:
        assert listener is one


@pytest.mark.parametrize("call", CALLS)
def test_nothing_said_is_the_default_of_every_long_call(call):
    assert inspect.signature(call).parameters["progress"].default is None
