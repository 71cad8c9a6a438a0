"""``uq.run`` and ``discrepancy.run`` under kill -9: a repeat comes to the bits of an undisturbed run.

Each moment costs a minute or two, so that HAPTID_KILLS says how many are tried (``make faults``: ten).
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from haptid.virtual_device.make_campaign import main as make_campaign

ROOT = Path(__file__).parents[2]
KILLS = int(os.environ.get("HAPTID_KILLS", "0"))
LEFT_OUT = ("wall_s", "command", "date", "seconds")
COMMANDS = {
    "uq.run": (["--quick"], ("posterior.json", "parameters_posterior.csv")),
    "discrepancy.run": (["--joint", "4", "--starts", "1", "--effort", "100"], ("discrepancy/joint4.json",)),
}
"""Options, and the files that are held against each other."""

pytestmark = pytest.mark.skipif(not KILLS, reason="HAPTID_KILLS says at how many moments: make faults")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a synthetic campaign of joint 4 with one run to fit and one to validate."""
    folder = tmp_path_factory.mktemp("campaign") / "joint4"
    make_campaign(["--out", str(folder), "--joints", "4", "--quiet"], standalone_mode=False)
    head, *runs = (folder / "campaign.toml").read_text(encoding="utf-8").split("[[runs]]")
    by_use = {use: next(run for run in runs if f'use = "{use}"' in run) for use in ("fit", "validate")}
    (folder / "campaign.toml").write_text("[[runs]]".join((head, *by_use.values())), encoding="utf-8")
    return folder


def started(command: str, campaign: Path, out: Path) -> subprocess.Popen[str]:
    options = [*COMMANDS[command][0], "--workers", "1", "--quiet", "--out", str(out)]
    arguments = [sys.executable, "-m", command, str(campaign), *options]
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


def content(command: str, out: Path) -> dict[str, str]:
    """Return what the files say, times and commands apart."""

    def kept(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: kept(entry) for key, entry in value.items() if key not in LEFT_OUT}
        return [kept(entry) for entry in value] if isinstance(value, list) else value

    texts = {name: (out / name).read_text(encoding="utf-8") for name in COMMANDS[command][1]}
    return {name: json.dumps(kept(json.loads(t))) if name.endswith(".json") else t for name, t in texts.items()}


@pytest.fixture(scope="module", params=COMMANDS)
def whole(
    request: pytest.FixtureRequest, campaign: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, dict[str, str], float]:
    """Return the command, what an undisturbed run writes, and the seconds that it took."""
    out, begun = tmp_path_factory.mktemp("whole"), time.monotonic()
    process = started(request.param, campaign, out)
    _, errors = process.communicate(timeout=900)
    assert process.returncode == 0, errors
    return request.param, content(request.param, out), time.monotonic() - begun


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("moment", range(KILLS))
def test_a_killed_command_goes_on_to_the_same_bits(
    moment: int, whole: tuple[str, dict[str, str], float], campaign: Path, tmp_path: Path
):
    command, reference, seconds = whole
    process = started(command, campaign, tmp_path / "out")
    time.sleep(random.Random(moment).uniform(0.1, 0.95) * seconds)
    process.kill()
    process.communicate()
    again = started(command, campaign, tmp_path / "out")
    _, errors = again.communicate(timeout=900)
    assert again.returncode == 0, errors
    assert content(command, tmp_path / "out") == reference
