"""One run of a recording: arrays of another program in, columns and a checked `Recording` out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from haptid.measurement.tables.table import Table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

Place = tuple[str, ...]
"""Names of the structures around a vector, from the outermost one, and its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Hold one run of a recording.

    Parameters
    ----------
    table
        Its columns.
    about
        What else the file says, in words for the user; empty where nothing.
    """

    table: Table
    about: str = ""


def recording_of(
    path: Path,
    columns: Mapping[str, Array],
    *,
    part: str = "",
    about: str = "",
    joints: tuple[str, ...] = (),
    entries: str = "",
) -> Recording:
    """Return a run as a table.

    Parameters
    ----------
    path
        File that holds it.
    columns
        Values by name, all of shape (n_t,).
    part
        What of the file it is, as ``episode_000003``; empty where the file is one run.
    about
        As in `Recording`.
    joints
        Names of joints 0, 1 … of the columns, where the file has them.
    entries
        As in `Table`.

    Returns
    -------
    Recording
        Its table becomes ``<file>_<part>.csv`` in the campaign.

    Raises
    ------
    InputError
        Where it has fewer than 8 rows.
    """
    rows = max((values.size for values in columns.values()), default=0)
    where = f"{path}, {part}" if part else str(path)
    if rows < THRESHOLDS.least_rows_of_table:
        raise InputError(where, expected=f"at least {THRESHOLDS.least_rows_of_table} rows", got=f"{rows}")
    name = f"{path.stem}_{part}" if part else path.stem
    frame = pd.DataFrame(dict(columns))
    table = Table(path=Path(where), frame=frame, file=f"{name}.csv", joints=joints, entries=entries)
    return Recording(table=table, about=about)


def named_by_place(vectors: Iterable[tuple[Place, Array]]) -> dict[str, Array]:
    """Name vectors by their own names, or by their structures too where two have the same.

    Parameters
    ----------
    vectors
        Vectors by their place.

    Returns
    -------
    dict
        Vectors by ``name``; where two have one name, by ``structure.name``, those of every other structure as well: a
        torque of one joint beside two joints' positions would be taken for that of any.
    """
    found = dict(vectors)
    own = Counter(place[-1] for place in found)
    whole = max(own.values(), default=1) > 1
    return {".".join(place) if whole else place[-1]: values for place, values in found.items()}


def vectors_of(name: str, value: Any) -> Iterator[tuple[str, Array]]:
    """Take an array of another program apart.

    Parameters
    ----------
    name
        Its name.
    value
        Anything; only arrays of numbers with enough rows for a run hold vectors.

    Yields
    ------
    name, values
        The vector itself, or each column of a matrix as ``name_0``, ``name_1`` …, shape (n_t,) each.
    """
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiub":
        return
    if value.size < THRESHOLDS.least_rows_of_table:
        return
    if value.ndim == 1:
        yield name, value.astype(np.float64)
    elif value.ndim == 2:
        matrix = value if value.shape[0] >= value.shape[1] else value.T
        for number, column in enumerate(matrix.T):
            yield f"{name}_{number}", column.astype(np.float64)
