"""The version of this haptid, read without importing any of its packages."""

from __future__ import annotations


def version() -> str:
    """Return the version of the installed haptid, or that of a clone that is run in place."""
    from importlib import metadata  # noqa: PLC0415 (30 ms, which no help needs)

    try:
        return metadata.version("haptid")
    except metadata.PackageNotFoundError:
        return "in a clone, not installed"
