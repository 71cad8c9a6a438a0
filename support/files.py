"""Files that are written whole or not at all, and JSON that is read with an error a user can act on."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from support.errors import InputError


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


def read_json(path: Path, wanted: str) -> dict[str, Any]:
    """Return the object that a JSON file holds; ``wanted`` says in words what it should be.

    Raises
    ------
    InputError
        Where the file cannot be read, is no JSON, or holds no object.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        where = f"{path}, line {error.lineno}"
        raise InputError(where, expected="JSON", got=error.msg) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), expected="a text file that can be read", got=str(error)) from None
    if not isinstance(data, dict):
        raise InputError(str(path), expected=wanted, got=type(data).__name__)
    return data


def cache_folder(name: str) -> Path:
    """Return (and make) the cache folder ``name`` below $HAPTID_CACHE, default ``.cache/haptid`` in the home folder."""
    base = Path(os.environ.get("HAPTID_CACHE", Path.home() / ".cache" / "haptid"))
    folder = base / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder
