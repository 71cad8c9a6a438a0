"""Read a MATLAB file: ``.mat`` of any version in, its runs out.

Variables that are vectors of one length are the columns, as are the fields of a structure. Where two structures have a
field of one name, names begin with that of the structure. A matrix gives a column per joint, ``q_0``, ``q_1`` ….
Elements of an array of structures or of cells are runs, or stand side by side (`mat_runs`). Signals of Simulink
have their labels for names (`simulink_structure`). Scalars and other texts are left out. Objects of MATLAB (``table``,
``timetable``) cannot be read outside it, and are named. Files of version 7.3 need the extra ``matlab``.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from haptid.measurement.recordings import mat_hdf5
from haptid.measurement.recordings.mat_runs import runs_of
from haptid.measurement.recordings.mat_values import Unread, take_apart
from haptid.measurement.recordings.one_run import Recording
from haptid.measurement.tables.damage import damage_in_one_line
from haptid.measurement.tables.layout import refuse_bomb
from haptid.support.files.files import read_content
from haptid.support.installing.extras import need
from haptid.support.processes.pool import Pool

HDF5 = b"MATLAB 7.3"
"""Begin of a file of version 7.3."""
HEADER_BYTES, ENDIAN = 128, slice(126, 128)
"""Length of the header of version 5, and where it states the order of bytes: ``IM`` is little-endian."""
COMPRESSED = 15
"""Type of a compressed element."""
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
        One for each element of an array that holds runs, and that of the vectors. The first says what was left out.

    Raises
    ------
    InputError
        Where it is damaged, unpacks to an absurd size, holds no vectors of one length, or needs an extra that is not
        installed.
    """
    content = read_content(path, "a MATLAB file")
    if content[:HEADER_BYTES].startswith(HDF5):
        need("matlab", str(path))
        declared, load = mat_hdf5.declared_bytes, mat_hdf5.load_variables
    else:
        declared, load = declared_bytes, load_variables
        for unpacked in _unpacked_bytes(content):
            refuse_bomb(path, unpacked)
    # The readers are compiled, and a damaged file can end their process (measured on mutated files).
    with damage_in_one_line(path, "a MATLAB file", "save it again"), Pool(1) as child:
        for size in child.submit(declared, content).result():
            refuse_bomb(path, size)
        variables = child.submit(load, content).result()
    return runs_of(path, take_apart(variables))


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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on variables that cannot be read, which are left out
        variables = io.loadmat(BytesIO(content), squeeze_me=True, struct_as_record=False)
    values = {name: _value(value) for name, value in variables.items() if not name.startswith("__")}
    # SciPy gives objects the name None, and keeps theirs within.
    return {value.name if isinstance(value, Unread) and value.name else name: value for name, value in values.items()}


def _value(value: Any) -> Any:
    """Return a value as `mat_values` takes it apart; None where it holds neither numbers nor one text."""
    if isinstance(value, io.matlab.mat_struct):
        return {name: _value(getattr(value, name)) for name in value._fieldnames}
    if isinstance(value, io.matlab.MatlabFunction):
        return None
    if isinstance(value, io.matlab.MatlabOpaque):
        return _object(value)
    if isinstance(value, io.matlab.MatlabObject):
        return Unread(kind="an object of MATLAB")
    if isinstance(value, np.ndarray) and value.dtype.kind == "O":
        return [_value(one) for one in value.ravel(order="F")]
    is_numeric = isinstance(value, np.ndarray) and value.dtype.kind in "fiub"
    return value if is_numeric or isinstance(value, str) else None


def _object(value: Any) -> Unread | None:
    """Return a table or another object of MATLAB by its name and class; None for a text."""
    name, _, kind = (str(value[field].item()).strip("b'") for field in ("s0", "s1", "s2"))
    return None if kind == "string" else Unread(kind=f"a {kind} of MATLAB", name=name)


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
