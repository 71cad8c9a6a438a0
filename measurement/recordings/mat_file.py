"""Read a MATLAB file: ``.mat`` of any version in, one run out.

Variables that are vectors of one length are the columns, as are the fields of a structure. Where two structures have a
field of one name, names begin with that of the structure. A matrix gives a column per joint, ``q_0``, ``q_1`` ….
Scalars and texts are left out. Objects of MATLAB (``table``, ``timetable``) cannot be read
outside it. Files of version 7.3 need the extra ``matlab``.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from haptid.measurement.recordings import mat_hdf5
from haptid.measurement.recordings.one_run import Place, Recording, named_by_place, recording_of, vectors_of
from haptid.measurement.tables.damage import damage_in_one_line
from haptid.measurement.tables.layout import refuse_bomb
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError
from haptid.support.files.files import read_content
from haptid.support.installing.extras import need
from haptid.support.processes.pool import Pool

HDF5 = b"MATLAB 7.3"
"""Begin of a file of version 7.3."""
HEADER_BYTES, ENDIAN = 128, slice(126, 128)
"""Length of the header of version 5, and where it states the order of bytes: ``IM`` is little-endian."""
COMPRESSED = 15
"""Type of a compressed element."""
LEAST_COLUMNS = 2
PIECE_BYTES = 1 << 20


def read_mat(path: Path) -> list[Recording]:
    """Read a MATLAB file.

    Parameters
    ----------
    path
        File that ends in ``.mat``.

    Returns
    -------
    list of Recording
        The one run.

    Raises
    ------
    InputError
        Where it is damaged, unpacks to an absurd size, holds no vectors of one length, or needs an extra that is not
        installed.
    """
    content = read_content(path, "a MATLAB file")
    if content[:HEADER_BYTES].startswith(HDF5):
        need("matlab", str(path))
        declared, load = mat_hdf5.declared_bytes, mat_hdf5.load_vectors
    else:
        declared, load = declared_bytes, load_vectors
        for unpacked in _unpacked_bytes(content):
            refuse_bomb(path, unpacked)
    # The readers are compiled, and a damaged file can end their process (measured on mutated files).
    with damage_in_one_line(path, "a MATLAB file", "save it again"), Pool(1) as child:
        for size in child.submit(declared, content).result():
            refuse_bomb(path, size)
        vectors = child.submit(load, content).result()
    columns = _columns(path, vectors)
    left = ", ".join(f"{name} ({values.size} values)" for name, values in vectors.items() if name not in columns)
    return [recording_of(path, columns, about=f"of another length and left out: {left}" if left else "")]


def declared_bytes(content: bytes) -> list[int]:
    """Return the size of each variable as the file declares it.

    Parameters
    ----------
    content
        Bytes of the file.

    Returns
    -------
    list of int
        Sizes of the arrays [bytes], 8 a number.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they would be printed beside the one line of an error
        listed = io.whosmat(BytesIO(content))
    return [8 * int(np.prod(shape, dtype=np.float64)) for _, shape, _ in listed]


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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on variables that cannot be read, which are left out
        variables = io.loadmat(BytesIO(content), squeeze_me=True, struct_as_record=False)
    return named_by_place(_vectors({name: value for name, value in variables.items() if not name.startswith("__")}))


def _unpacked_bytes(content: bytes) -> Iterator[int]:
    """Yield how many bytes the compressed elements unpack to, while they are unpacked piece by piece."""
    order = "<" if content[ENDIAN] == b"IM" else ">"
    place, unpacked = HEADER_BYTES, 0
    while place + 8 <= len(content):
        kind, length = struct.unpack(f"{order}II", content[place : place + 8])
        place += 8
        if kind == COMPRESSED:
            unpacker = zlib.decompressobj()
            packed = content[place : place + length]
            while packed and not unpacker.eof:
                try:
                    unpacked += len(unpacker.decompress(packed, PIECE_BYTES))
                except zlib.error:  # said by whoever reads the file whole
                    return
                packed = unpacker.unconsumed_tail
                yield unpacked
        place += length


def _columns(path: Path, found: Mapping[str, Array]) -> dict[str, Array]:
    """Return the vectors of the commonest length."""
    lengths = Counter(values.size for values in found.values())
    rows, count = max(lengths.items(), key=lambda item: (item[1], item[0]), default=(0, 0))
    if count < LEAST_COLUMNS:
        got = ", ".join(f"{name} of {values.size}" for name, values in found.items()) or "none"
        todo = "save time, torque and position as vectors, a table by table2struct(T, 'ToScalar', true)"
        raise InputError(str(path), expected="vectors of one length", got=got, todo=todo)
    return {name: values for name, values in found.items() if values.size == rows}


def _vectors(variables: Mapping[str, Any], place: Place = ()) -> Iterator[tuple[Place, Array]]:
    """Yield the numeric vectors by their place: of structures their fields, of matrices their columns."""
    for name, value in variables.items():
        if isinstance(value, io.matlab.mat_struct):
            yield from _vectors({field: getattr(value, field) for field in value._fieldnames}, (*place, name))
        else:
            for own, vector in vectors_of(name, value):
                yield (*place, own), vector
