"""Runs of a MATLAB file: its variables, taken apart, in; `Recording`s out.

1. Vectors of the commonest length are the columns of a run.
2. Each element of an array of structures, or of cell arrays side by side, is a run where it holds a time, where the
   array is named after runs, where the lengths differ, or where no vector of that length stands beside the array.
3. Elements of any other array stand side by side in the run of the vectors, as joints do.
4. What holds numbers and is in no run is named.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from haptid.measurement.recordings.mat_values import Elements, Parts, Vectors
from haptid.measurement.recordings.one_run import Place, Recording, named_by_place, recording_of
from haptid.measurement.tables.misnamed import looks_like_time
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

LEAST_COLUMNS = 2
RUNS = re.compile(r"(runs?|trials?|tests?|experiments?|rep(etition)?s?|takes?|sweeps?|meas(urements?)?)", re.IGNORECASE)
"""Names of arrays whose elements are runs, also where one time beside them is that of all."""
JOINTS = re.compile(r"(joints?|axis|axes|motors?|drives?|links?|gelenke?|achsen?)", re.IGNORECASE)
"""Names of arrays whose elements are joints."""
OTHER_LENGTH = "left out for their length"
"""Says of vectors that they are in no run."""
TODO = "save time, torque and position as vectors, a table by table2struct(T, 'ToScalar', true)"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Found:
    """What was found in a file so far.

    Parameters
    ----------
    runs
        Columns by the part of the file that the run is; the run of the vectors is the file itself.
    about
        Sentences for the user.
    shorter
        Rows of vectors of another length than their run's, by name.
    unread
        What could not be taken apart, in words, by name.
    """

    runs: dict[str, dict[str, Array]] = field(default_factory=dict)
    about: list[str] = field(default_factory=list)
    shorter: dict[str, int] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)

    def add(self, part: str, columns: Mapping[str, Array], prefix: str = "") -> bool:
        """Add the vectors of the commonest length as a run, and say whether they are enough for one."""
        rows, count = _rows_of(columns.values())
        is_run = count >= LEAST_COLUMNS
        if is_run:
            # Two arrays may have one name, in structures or as cells.
            part = f"{part}_{len(self.runs)}" if part in self.runs else part
            self.runs[part] = {name: values for name, values in columns.items() if values.size == rows}
        others = {name: values.size for name, values in columns.items() if not is_run or values.size != rows}
        self.shorter.update({f"{prefix}{name}": size for name, size in others.items()})
        return is_run


def runs_of(path: Path, parts: Parts) -> list[Recording]:
    """Return the runs of a MATLAB file.

    Parameters
    ----------
    path
        The file.
    parts
        Its variables.

    Returns
    -------
    list of Recording
        Those of elements of arrays, then that of the vectors. The first says what was left out.

    Raises
    ------
    InputError
        Where there is no run.
    """
    found = _Found(unread=dict(parts.unread))
    vectors, used = dict(parts.vectors), set[Place]()
    for one in parts.elements:
        if _are_runs(one, parts.vectors):
            used |= _add_elements(found, one, parts.vectors)
        else:
            joined = _without_times(one).side_by_side()
            vectors |= joined.vectors | _one_time_of(one)
            found.unread.update(joined.unread)
            found.about.append(f"elements of {one.words} stand side by side, numbered from 0")
    main = {place: values for place, values in vectors.items() if place not in used}
    if found.runs and _time_of(main) is None:
        # Beside runs with a time these are settings or results, and would make a run that nothing can use.
        found.unread.update({".".join(place): f"{values.size} values without a time" for place, values in main.items()})
    else:
        found.add("", named_by_place(main.items()))
    if not found.runs:
        told = [f"{name} of {rows}" for name, rows in found.shorter.items()]
        told += [f"{name} ({kind})" for name, kind in found.unread.items()]
        raise InputError(str(path), expected="vectors of one length", got=", ".join(told) or "none", todo=TODO)
    about = [*found.about]
    if found.shorter:
        told = [f"{name} ({rows} values)" for name, rows in found.shorter.items()]
        about.append(f"{OTHER_LENGTH}: {', '.join(told)}")
    if found.unread:
        told = [f"{name} ({kind})" for name, kind in found.unread.items()]
        about.append(f"not read and left out: {', '.join(told)} ({TODO})")
    recordings = [recording_of(path, columns, part=part) for part, columns in found.runs.items()]
    return [replace(recordings[0], about="; ".join(about)), *recordings[1:]]


def _are_runs(elements: Elements, beside: Vectors) -> bool:
    """Whether each element of an array is a run of its own."""
    times = _times_of(elements)
    if times:
        # Joints that were logged together have one clock.
        return not (_are_joints(elements) and all(np.array_equal(time, times[0]) for time in times))
    rows = [_rows_of(parts.vectors.values()) for parts in elements.each if parts.vectors]
    if any(count < LEAST_COLUMNS for _, count in rows) and not beside:
        return False
    lengths = {length for length, _ in rows}
    is_named = len(elements.names) == 1 and RUNS.fullmatch(elements.names[0]) is not None
    return is_named or len(lengths) > 1 or not any(values.size in lengths for values in beside.values())


def _times_of(elements: Elements) -> list[Array]:
    """Return the time of each element that holds vectors; none where one of them has no time."""
    times = [_time_of(parts.vectors) for parts in elements.each if parts.vectors]
    known = [time for time in times if time is not None]
    return known if len(known) == len(times) else []


def _without_times(elements: Elements) -> Elements:
    """Return elements that stand side by side without the time that all of them have."""
    if not _times_of(elements):
        return elements
    kept = [
        {place: values for place, values in parts.vectors.items() if not looks_like_time(place[-1])}
        for parts in elements.each
    ]
    each = [replace(parts, vectors=vectors) for parts, vectors in zip(elements.each, kept, strict=True)]
    return replace(elements, each=tuple(each))


def _one_time_of(elements: Elements) -> Vectors:
    """Return the time that all elements have, by its own name."""
    first = next((parts.vectors for parts in elements.each if parts.vectors), {})
    times = {place[-1:]: values for place, values in first.items() if looks_like_time(place[-1])}
    return times if _times_of(elements) else {}


def _are_joints(elements: Elements) -> bool:
    return len(elements.names) == 1 and JOINTS.fullmatch(elements.names[0]) is not None


def _time_of(vectors: Vectors) -> Array | None:
    return next((values for place, values in vectors.items() if looks_like_time(place[-1])), None)


def _rows_of(vectors: Iterable[Array]) -> tuple[int, int]:
    """Return the commonest length of vectors, and how many have it; the longest where two are as common."""
    lengths = Counter(values.size for values in vectors)
    return max(lengths.items(), key=lambda item: (item[1], item[0]), default=(0, 0))


def _add_elements(found: _Found, elements: Elements, beside: Vectors) -> set[Place]:
    """Add a run for each element, and return the places of the vectors beside them that are columns of all these."""
    made, used = 0, set[Place]()
    for number, parts in enumerate(elements.each):
        columns = named_by_place(parts.vectors.items())
        if _time_of(parts.vectors) is None:
            rows, _ = _rows_of(columns.values())
            shared = {place: values for place, values in beside.items() if values.size == rows}
            columns = {**named_by_place(shared.items()), **columns}
            used |= set(shared)
        if _are_joints(elements):
            # Without its joint's number a column would be that of joint 0 in every run.
            joint = f"{elements.names[0]}_{number}."
            columns = {name if looks_like_time(name) else joint + name: values for name, values in columns.items()}
        label = "run" if elements.cells else "_".join((*elements.place, *elements.names))
        made += found.add(f"{label}_{number + 1}", columns, f"{elements.words}({number + 1}).")
        found.unread.update(elements.unread_in(number))
    found.about.append(f"{made} of {len(elements.each)} elements of {elements.words} are a run each")
    return used
