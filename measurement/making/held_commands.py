"""Carry the torque of rows that are left out into the row before them: a torque holds until the next row.

Where a position is missing, its row goes, but not what the drive did then: the torque of the row before would be held
in its place. The mean over both rows, each by its time, has the same impulse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.tables.table import Table


def with_held_commands(table: Table, kept: NDArray[np.int_], commands: Sequence[str], time: str) -> Table:
    """Keep some rows of a table, with the commands of the rows between them in the row before.

    Parameters
    ----------
    table
        The user's table.
    kept
        Indices of the rows that are kept, ascending.
    commands
        Columns whose value holds until the next row.
    time
        Column of the time.

    Returns
    -------
    Table
        The kept rows. A command is Σ uⱼ·Δtⱼ/Σ Δtⱼ over its own row and those left out after it that have one; a row
        with an empty command, or without a time, holds what was before.
    """
    t = table.loosely(time)
    less = table.keep(kept)
    frame = less.frame
    for command in commands:
        u = table.loosely(command)
        cells = frame[command].astype(object).to_numpy().copy()
        changed = False
        for place in np.flatnonzero(np.diff(kept) > 1):
            first, last = int(kept[place]), int(kept[place + 1])
            rows = [first, *(row for row in range(first + 1, last) if np.isfinite(u[row]) and np.isfinite(t[row]))]
            spans = np.diff([*t[rows], t[last]])
            if len(rows) > 1 and np.isfinite(u[first]) and spans.sum() > 0.0:
                cells[place], changed = float(u[rows] @ spans / spans.sum()), True
        if changed:
            frame = frame.assign(**{command: cells})
    return replace(less, frame=frame)
