"""The files below ``extra/haptid`` of an FMU, read as a host reads them."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from pathlib import Path
from typing import Any

FILES = ("verification.json", "parameters.csv", "correlation.csv", "draws.csv", "effects.json", "digests.json")


def text_of(fmu: Path, name: str) -> str:
    with zipfile.ZipFile(fmu) as archive:
        return archive.read(name).decode()


def table_of(fmu: Path, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text_of(fmu, f"extra/haptid/{name}"))))


def json_of(fmu: Path, name: str) -> dict[str, Any]:
    return json.loads(text_of(fmu, f"extra/haptid/{name}"))


def draws_of(fmu: Path) -> list[dict[str, float]]:
    """Start values by FMU variable name, a dictionary a draw."""
    rows = table_of(fmu, "draws.csv")
    return [{name: float(x) for name, x in row.items() if name != "draw"} for row in rows]


def page_of(fmu: Path) -> str:
    return text_of(fmu, "documentation/index.html")
