"""Vectors of a MATLAB file of version 7.3, which is HDF5: its bytes in, vectors by name out.

Both functions run in a process of their own: HDF5 is compiled, and a damaged file may end its process.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np

from haptid.measurement.recordings.one_run import Place, named_by_place, vectors_of
from haptid.measurement.values.run import Array

DEEPEST = 4
"""Structures within structures that are looked into."""
TEXT = (b"char", b"cell", b"string")
"""Classes of MATLAB that are stored as numbers and are none."""


def declared_bytes(content: bytes) -> list[int]:
    """Return the size of all vectors as the file declares it.

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
        return [8 * sum(int(one.size) for _, one in _datasets(file, DEEPEST))]


def load_vectors(content: bytes) -> dict[str, Array]:
    """Return the numeric vectors of a file.

    Parameters
    ----------
    content
        Bytes of the file.

    Returns
    -------
    dict
        Vectors by name, each of shape (n_t,): of structures their fields, of matrices their columns.
    """
    import h5py  # noqa: PLC0415 (an extra)

    with h5py.File(BytesIO(content), "r") as file:
        # MATLAB stores columns first: what it shows as n × 2 is 2 × n here.
        return named_by_place(
            ((*place[:-1], own), vector)
            for place, dataset in _datasets(file, DEEPEST)
            for own, vector in vectors_of(place[-1], np.squeeze(dataset[()].T))
        )


def _datasets(group: Any, deepest: int, place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Yield the numeric arrays of a group and of the structures in it; nothing that lies in another file."""
    import h5py  # noqa: PLC0415 (an extra)

    for name in group:
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        one = group[name]
        if isinstance(one, h5py.Group) and deepest:
            yield from _datasets(one, deepest - 1, (*place, name))
        elif isinstance(one, h5py.Dataset) and one.dtype.kind in "fiub":
            elsewhere = one.external or one.is_virtual
            # Of an empty array MATLAB stores the shape as numbers.
            empty = one.attrs.get("MATLAB_empty", 0)
            if not elsewhere and not empty and one.attrs.get("MATLAB_class", b"double") not in TEXT:
                yield (*place, name), one
