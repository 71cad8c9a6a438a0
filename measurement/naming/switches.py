"""Understand the switch of a motor: ``torque_enabled`` or ``motor 1 enable`` in, ``enabled_1`` out."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from haptid.measurement.format.columns import KNOWN
from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.units_in_names import ONLY_JOINT, taken_names
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError

SWITCH = frozenset({"enable", "enabled"})
BESIDE = frozenset({"torque", "motor", "drive", "servo", "joint", "axis", "power", "amplifier", "output", "actuator"})
"""Words that may stand beside that of a switch; with any other it may switch something else."""


def understand_switches(table: Table, stated: Mapping[str, Target]) -> dict[str, Target]:
    """Return the columns that tell when a motor was let go.

    Parameters
    ----------
    table
        The user's table.
    stated
        What the user says of columns; it overrules their names.

    Returns
    -------
    dict
        Column of the format by the user's column: names of a switch whose cells are 0 and 1, both of them. A switch
        that never turns says nothing; where two stand for one joint, neither is taken.
    """
    taken = taken_names(table.columns, stated)
    found: dict[str, list[str]] = {}
    for column in table.columns:
        if column in stated or KNOWN.fullmatch(column):
            continue
        words = re.findall(r"[a-z]+|\d+", column.lower())
        numbers = [word for word in words if word.isdigit()]
        names = {word for word in words if not word.isdigit()}
        if names & SWITCH and names <= SWITCH | BESIDE and len(numbers) <= 1 and _turns(table, column):
            found.setdefault(f"enabled_{int(numbers[0]) if numbers else ONLY_JOINT}", []).append(column)
    return {columns[0]: Target(name=name) for name, columns in found.items() if len(columns) == 1 and name not in taken}


def _turns(table: Table, column: str) -> bool:
    """Whether the cells of a column are 0 and 1, and both occur."""
    try:
        values = table.numbers(column)
    except InputError:
        return False
    return set(np.unique(values).tolist()) == {0.0, 1.0}
