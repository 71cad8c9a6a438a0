"""Read a LeRobot data set: ``meta/info.json`` and Parquet files below ``data/`` in, one run an episode out.

Its vectors (``observation.state``, ``action`` …) become a column an element, under the names that ``info.json`` gives
them. The format states no units, so that only ``timestamp`` is understood, in s: the others are named with ``--map``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from haptid.measurement.recordings.one_run import Recording, recording_of
from haptid.measurement.tables.table import read_parquet
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError
from haptid.support.files.files import is_file, read_json
from haptid.support.installing.extras import need

INFO = Path("meta") / "info.json"
TIME, EPISODE = "timestamp", "episode_index"
COUNTERS = (EPISODE, "frame_index", "index", "task_index")
"""Columns that count frames and measure nothing."""


def is_data_set(folder: Path) -> bool:
    """Return whether a folder holds a LeRobot data set.

    Parameters
    ----------
    folder
        Any folder.

    Returns
    -------
    bool
    """
    return is_file(folder / INFO)


def read_data_set(folder: Path) -> list[Recording]:
    """Read all episodes.

    Parameters
    ----------
    folder
        Root of the data set.

    Returns
    -------
    list of Recording
        In the order of the episodes.

    Raises
    ------
    InputError
        Where the extra for Parquet is not installed, a file is damaged, or there are no frames.
    """
    need("parquet", str(folder))
    names = _element_names(read_json(folder / INFO, "the description of a LeRobot data set"))
    paths = sorted((folder / "data").rglob("*.parquet"))
    if not paths:
        raise InputError(str(folder / "data"), expected="Parquet files of a LeRobot data set", got="none")
    return [recording for path in paths for recording in _episodes(path, names)]


def _element_names(info: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the names of the elements of each vector; older versions group them, as ``{"motors": [...]}``."""
    features = info.get("features")
    found: dict[str, list[str]] = {}
    for name, feature in features.items() if isinstance(features, dict) else ():
        listed = feature.get("names") if isinstance(feature, dict) else None
        if isinstance(listed, dict):
            listed = [one for group in listed.values() if isinstance(group, list) for one in group]
        if isinstance(listed, list):
            found[name] = [str(one) for one in listed]
    return found


def _episodes(path: Path, names: Mapping[str, list[str]]) -> Iterator[Recording]:
    frame = read_parquet(path)
    for column in (TIME, EPISODE):
        if column not in frame:
            got = ", ".join(map(str, frame.columns))
            raise InputError(str(path), expected=f"a column {column} of a LeRobot data set", got=got)
    for _, rows in frame.groupby(EPISODE, sort=True):
        columns = {"time_s": rows[TIME].to_numpy(dtype=np.float64)}
        for name in rows.columns:
            if name not in (TIME, *COUNTERS):
                columns |= _elements(path, str(name), rows[name], names)
        part = f"episode_{int(rows[EPISODE].iloc[0]):06d}"
        yield recording_of(path, columns, part=part)


def _elements(path: Path, name: str, cells: pd.Series[Any], names: Mapping[str, list[str]]) -> dict[str, Array]:
    """Return a column an element of a vector; nothing of what holds no numbers."""
    if pd.api.types.is_numeric_dtype(cells.dtype):
        return {name: cells.to_numpy(dtype=np.float64)}
    try:
        values = np.array([np.asarray(cell, dtype=np.float64) for cell in cells])
    except (TypeError, ValueError):  # texts, pictures, or vectors of several lengths
        return {}
    if values.ndim != 2:
        return {}
    stated = names.get(name, [])
    elements = stated if len(stated) == values.shape[1] else [str(k) for k in range(values.shape[1])]
    if len(set(elements)) < len(elements):
        raise InputError(str(path), expected=f"a name of its own for each element of {name}", got=", ".join(elements))
    return {f"{name}.{element}": values[:, k] for k, element in enumerate(elements)}
