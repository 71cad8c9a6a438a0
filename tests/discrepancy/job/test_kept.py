"""An interrupted search of several joints says what it leaves, and how the others are searched."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.command_line import main
from haptid.discrepancy import search_campaign as module
from haptid.measurement.format.embedded import embedded_campaign


@pytest.mark.parametrize(
    ("stop", "told"),
    [
        (1, "discrepancy/joint4.json kept; go on with: haptid missing 'my runs' --seed 3 --joints 5,3"),
        (2, "discrepancy/joint4.json, discrepancy/joint5.json kept; go on with: haptid missing 'my runs' --seed 3 "
            "--joints 3"),
        (0, "nothing was finished yet"),
    ],
)  # fmt: skip
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
    typed = ["haptid", "missing", "my runs", "--joints", "4,5,3", "--seed", "3", "--free=0,1"]
    monkeypatch.setattr("sys.argv", typed)
    stopped = CliRunner().invoke(main, ["missing", *arguments], prog_name="haptid")
    assert stopped.exit_code == 130
    assert [line for line in stopped.stderr.splitlines() if "kept" in line or "interrupted" in line] == [
        f"interrupted: {told}"
    ]
