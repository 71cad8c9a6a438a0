"""MATLAB files of both kinds for tests, as MATLAB writes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

KINDS = {"f": b"double", "u": b"char", "b": b"logical", "O": b"cell"}
"""Class of MATLAB by the kind of an array."""
FEWEST_OF_PACKED = 9
"""Elements of the smallest array that is stored with options."""


def mat5(path: Path, variables: dict[str, Any]) -> None:
    """Write a file of version 5, with lists as arrays of structures or of cells."""

    def stored(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: stored(one) for name, one in value.items()}
        if not isinstance(value, list):
            return value
        if isinstance(value[0], dict):
            rows = [tuple(stored(one[field]) for field in value[0]) for one in value]
            return np.array(rows, dtype=[(field, object) for field in value[0]])
        cells = np.empty(len(value), dtype=object)
        cells[:] = [stored(one) for one in value]
        return cells

    savemat(path, stored(variables))


def mat73(path: Path, variables: dict[str, Any], **options: Any) -> None:
    """Write a file as MATLAB does: a block of its own before HDF5, columns first, a class with each array."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_group("#refs#").create_dataset("a", data=np.arange(60) * 0.01)
        for name, value in variables.items():
            _put(file, name, value, options)
    content = bytearray(path.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116, b" ") + bytes(8) + b"\x00\x02IM"
    path.write_bytes(content)


def _put(group: Any, name: str, value: Any, options: dict[str, Any]) -> None:
    if isinstance(value, dict):
        fields = _structure(group, name)
        for field, inner in value.items():
            _put(fields, field, inner, options)
    elif isinstance(value, list) and isinstance(value[0], dict):
        fields = _structure(group, name)
        for field in value[0]:
            fields.create_dataset(field, data=_references(group.file, [one[field] for one in value]))
    elif isinstance(value, list):
        group.create_dataset(name, data=_references(group.file, value)).attrs["MATLAB_class"] = np.bytes_(b"cell")
    else:
        _put_array(group, name, value, options)


def _structure(group: Any, name: str) -> Any:
    made = group.create_group(name)
    made.attrs["MATLAB_class"] = np.bytes_(b"struct")
    return made


def _references(file: Any, values: list[Any]) -> Any:
    """Store values among those that are referred to, and return the references to them."""
    h5py = pytest.importorskip("h5py")
    hidden, found = file["#refs#"], []
    for value in values:
        name = f"r{len(hidden)}"
        _put(hidden, name, value, {})
        found.append(hidden[name].ref)
    return np.array(found, dtype=h5py.ref_dtype).reshape(-1, 1)


def _put_array(group: Any, name: str, value: Any, options: dict[str, Any]) -> None:
    text = isinstance(value, str)
    array = np.array([ord(c) for c in value], dtype=np.uint16) if text else np.asarray(value)
    array = array.reshape(-1, 1) if array.ndim < 2 else array
    packed = {} if text or array.size < FEWEST_OF_PACKED else options
    stored = group.create_dataset(name, data=array.T, **packed)
    stored.attrs["MATLAB_class"] = np.bytes_(b"char" if text else KINDS[array.dtype.kind])
