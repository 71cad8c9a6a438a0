"""Variables of a MATLAB file of version 7.3, which is HDF5: its bytes in, values by name out.

Both functions run in a process of their own: HDF5 is compiled, and a damaged file may end its process.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np

from haptid.measurement.recordings.mat_values import Unread

DEEPEST = 4
"""Structures and cells within each other that are looked into."""
MOST_ELEMENTS = 100_000
"""Elements of arrays of structures and of cells that are looked at; a damaged file may hold one array in another."""
TEXT = (b"char", b"cell", b"string")
"""Classes of MATLAB that are stored as numbers and are none."""
LONGEST_TEXT = 200
"""Characters of a text that is read; a longer one is no label of a signal."""


def declared_bytes(content: bytes) -> list[int]:
    """Return the size of all arrays as the file declares it.

    Parameters
    ----------
    content
        Bytes of the file.

    Returns
    -------
    list of int
        Their sum [bytes], 8 a number.
    """
    import h5py  # noqa: PLC0415 (an extra)

    with h5py.File(BytesIO(content), "r") as file:
        return [8 * sum(int(one.size) for one in _datasets(_Walk(file).members(file, DEEPEST)))]


def load_variables(content: bytes) -> dict[str, Any]:
    """Return the variables of a file.

    Parameters
    ----------
    content
        Bytes of the file.

    Returns
    -------
    dict
        Values by name, as `mat_values` takes them apart.
    """
    import h5py  # noqa: PLC0415 (an extra)

    with h5py.File(BytesIO(content), "r") as file:
        return {name: _load(value) for name, value in _Walk(file).members(file, DEEPEST).items()}


def _datasets(value: Any) -> Iterator[Any]:
    """Yield the arrays in a value whose arrays are not loaded."""
    if isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _datasets(one)
    elif value is not None and not isinstance(value, Unread | _Text):
        yield value


def _load(value: Any) -> Any:
    """Return a value with its arrays loaded."""
    if isinstance(value, dict):
        return {name: _load(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_load(one) for one in value]
    if isinstance(value, _Text):
        return "".join(map(chr, np.ravel(value.codes[()])))
    # MATLAB stores columns first: what it shows as n × 2 is 2 × n here.
    return value if value is None or isinstance(value, Unread) else np.squeeze(value[()].T)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Text:
    """A short text that is not loaded yet: an array of the codes of its characters."""

    codes: Any


class _Walk:
    """Values of an open file, their arrays not loaded yet; nothing that lies in another file.

    Parameters
    ----------
    file
        The file, as h5py opens it.
    """

    def __init__(self, file: Any) -> None:
        self.file = file
        self.elements = 0

    def members(self, group: Any, deepest: int) -> dict[str, Any]:
        """Return the variables of the file, or the fields of a structure, by name."""
        import h5py  # noqa: PLC0415 (an extra)

        names = [name for name in group if not name.startswith("#")]
        inside = [name for name in names if isinstance(group.get(name, getlink=True), h5py.HardLink)]
        return {name: self._value(group[name], deepest) for name in inside}

    def _value(self, one: Any, deepest: int) -> Any:
        import h5py  # noqa: PLC0415 (an extra)

        if isinstance(one, h5py.Group):
            return self._structure(one, deepest - 1) if deepest else Unread(kind=f"more than {DEEPEST} levels deep")
        if not isinstance(one, h5py.Dataset) or one.external or one.is_virtual:
            return None
        kind = one.attrs.get("MATLAB_class", b"double")
        if "MATLAB_object_decode" in one.attrs and kind not in TEXT:
            return Unread(kind=f"a {kind.decode(errors='replace')} of MATLAB")
        if one.dtype == h5py.ref_dtype and kind == b"cell":
            return self._elements(one, deepest - 1) if deepest else Unread(kind=f"more than {DEEPEST} levels deep")
        if kind == b"char" and one.dtype == np.uint16 and one.size <= LONGEST_TEXT:
            return None if one.attrs.get("MATLAB_empty", 0) else _Text(codes=one)
        # Of an empty array MATLAB stores the shape as numbers.
        is_numeric = one.dtype.kind in "fiub" and kind not in TEXT and not one.attrs.get("MATLAB_empty", 0)
        return one if is_numeric else None

    def _structure(self, group: Any, deepest: int) -> Any:
        """Return a structure as a dict, or an array of structures as a list of these: its fields hold references."""
        import h5py  # noqa: PLC0415 (an extra)

        fields = [group[name] for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)]
        is_array = bool(fields) and all(
            isinstance(one, h5py.Dataset) and one.dtype == h5py.ref_dtype and one.attrs.get("MATLAB_class") != b"cell"
            for one in fields
        )
        if not is_array:
            return self.members(group, deepest)
        columns = {name: self._elements(group[name], deepest) for name in group}
        columns = {name: values if isinstance(values, list) else [values] for name, values in columns.items()}
        return [
            {name: values[k] for name, values in columns.items() if k < len(values)}
            for k in range(max(map(len, columns.values())))
        ]

    def _elements(self, references: Any, deepest: int) -> Any:
        """Return what an array of references refers to; of one reference the value itself."""
        self.elements += references.size
        if self.elements > MOST_ELEMENTS or references.external or references.is_virtual:
            msg = f"more than {MOST_ELEMENTS} elements, or references in another file"
            raise ValueError(msg)
        found = [self._value(self.file[one], deepest) if one else None for one in np.ravel(references[()])]
        return found[0] if len(found) == 1 else found
