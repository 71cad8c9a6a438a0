"""The usual commands on a campaign of real measurements: folder in, their results as read from JSON out."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Call:
    """One call of a command.

    Parameters
    ----------
    command
        The call as a user would type it.
    outcome
        ``done``, or in words why there is no result.
    wall_s
        Wall time [s].
    result
        Content of the JSON that it wrote; None without a result.
    """

    command: str
    outcome: str
    wall_s: float
    result: dict[str, Any] | None

    def as_json(self) -> dict[str, Any]:
        """Return the call without its result."""
        return {"command": self.command, "outcome": self.outcome, "wall_s": round(self.wall_s, 1)}


def identify(campaign: Path, out: Path, limit: float) -> Call:
    """Run ``identification.run`` with its defaults, without the export of FMUs."""
    arguments = ("identification.run", "--no-export")
    return _call(arguments, campaign, out, limit, out / "identification.json")


def find_missing(campaign: Path, joints: Sequence[int], out: Path, limit: float) -> Call:
    """Run ``discrepancy.run`` on one joint, or on several that move together."""
    named = ",".join(map(str, joints))
    chosen = ("--joint", named) if len(joints) == 1 else ("--free", named)
    name = f"joint{joints[0]}.json" if len(joints) == 1 else f"joints{''.join(map(str, joints))}.json"
    return _call(("discrepancy.run", *chosen), campaign, out, limit, out / "discrepancy" / name)


def _call(arguments: Sequence[str], campaign: Path, out: Path, limit: float, written: Path) -> Call:
    module, *options = arguments
    words = [sys.executable, "-m", module, str(campaign), "--out", str(out), "--quiet", *options]
    # An earlier result must not stand for a call that fails.
    written.unlink(missing_ok=True)
    began = time.perf_counter()
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        outcome = f"stopped after {limit:.0f} s"
    else:
        outcome = "done" if done.returncode == 0 else _last_error(done.stderr, campaign)
    wall_s = time.perf_counter() - began
    result = json.loads(written.read_text(encoding="utf-8")) if outcome == "done" else None
    return Call(command=_shown(module, options, campaign), outcome=outcome, wall_s=wall_s, result=result)


def _shown(module: str, options: Sequence[str], campaign: Path) -> str:
    return " ".join(["python -m", module, campaign.name, *options])


def _last_error(told: str, campaign: Path) -> str:
    """Return the line with which a command refused its input, without the folder of this machine."""
    errors = [line for line in told.splitlines() if line.startswith("error:")]
    return errors[-1].removeprefix("error: ").replace(f"{campaign}/", "") if errors else "failed"
