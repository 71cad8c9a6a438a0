"""Cases that stand in for the panel of the study of thresholds: they read two thresholds and take no time."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any


def make(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "campaign.toml").write_text("")


def work(_campaign: Path, _out: Path) -> dict[str, Any]:
    from haptid.noise.thresholds import THRESHOLDS  # noqa: PLC0415 (a reader is loaded after the change)

    few = THRESHOLDS.most_lines >= 4 and THRESHOLDS.least_line_over_spectrum > 0
    return outcome("few" if few else "none", ["lines"] if few else [], 10 * THRESHOLDS.most_lines)


def count_places(_campaign: Path, _out: Path) -> dict[str, Any]:
    from haptid.discrepancy.unnamed.splines import PLACES  # noqa: PLC0415

    return outcome("none", [], len(PLACES))


def outcome(verdict: str, names: list[str], simulations: int) -> dict[str, Any]:
    figures = {"closed": None, "times_noise": None, "values": {}}
    return {"verdict": verdict, "names": names, "simulations": simulations, **figures}


def raises(_campaign: Path, _out: Path) -> dict[str, Any]:
    raise ZeroDivisionError


def hangs(_campaign: Path, _out: Path) -> dict[str, Any]:
    time.sleep(60.0)
    return {}


def dies(_campaign: Path, _out: Path) -> dict[str, Any]:
    os._exit(1)
