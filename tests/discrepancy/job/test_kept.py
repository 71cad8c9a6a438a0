"""An interrupted search of several joints says what it leaves, and how the others are searched."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.discrepancy import run as module
from haptid.discrepancy.commands import missing
from haptid.measurement.format.embedded import embedded_campaign


@pytest.mark.parametrize(
    ("stop", "told"),
    [
        (1, "kept: discrepancy/joint4.json; the rest is searched with --joints 5,3\n"),
        (2, "kept: discrepancy/joint4.json, discrepancy/joint5.json; the rest is searched with --joints 3\n"),
        (0, ""),
    ],
)
def test_what_an_interrupted_search_leaves_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stop: int, told: str
) -> None:
    found: list[str] = []

    def find(search, *_):
        if len(found) == stop:
            raise KeyboardInterrupt
        found.append(search.name)
        return {search.name: {}}

    monkeypatch.setattr(module, "_find", find)
    arguments = [str(embedded_campaign("paper")), "--joints", "4,5,3", "--out", str(tmp_path)]
    stopped = CliRunner().invoke(missing, arguments)
    assert stopped.exit_code == 130
    notes = [line for line in stopped.stderr.splitlines(keepends=True) if line.startswith("kept")]
    assert "".join(notes) == told
