"""Files that are written whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any


def write_bytes(path: Path, data: bytes) -> Path:
    """Write ``data`` to ``path`` through a temporary file in the same folder and an atomic rename."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path


def write_text(path: Path, text: str) -> Path:
    """Write ``text`` as UTF-8, whole or not at all."""
    return write_bytes(path, text.encode())


def write_json(path: Path, value: dict[str, Any]) -> Path:
    """Write ``value`` as indented JSON (NaN is refused), whole or not at all."""
    return write_text(path, json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def cache_folder(name: str) -> Path:
    """Return (and make) the cache folder ``name`` below $HAPTID_CACHE, default ``.cache/haptid`` in the home folder."""
    base = Path(os.environ.get("HAPTID_CACHE", Path.home() / ".cache" / "haptid"))
    folder = base / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder
