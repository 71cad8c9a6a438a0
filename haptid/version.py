"""The version of this haptid, read without importing any of its packages."""

from __future__ import annotations

import re
from pathlib import Path


def version() -> str:
    """Return the version of the installed haptid, or that of a clone that is run in place."""
    from importlib import metadata  # noqa: PLC0415 (30 ms, which no help needs)

    try:
        return metadata.version("haptid")
    except metadata.PackageNotFoundError:
        project = (Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8")
        stated = re.search(r'^version = "(.+)"$', project, re.MULTILINE)
        return f"{stated[1] if stated else 'unknown'}, in a clone"
