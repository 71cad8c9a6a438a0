"""Units of positions and torques as told to people: those of joints that turn, slide, or both."""

from __future__ import annotations

from collections.abc import Iterable

from haptid.model.equations.joint_parameters import sliding


def unit_for(unit: str, prismatic: Iterable[bool]) -> str:
    """Return a turning joint's unit where all joints turn, what it becomes where all slide, else both.

    >>> unit_for("mrad", [False]), unit_for("N m", [True]), unit_for("rad", [False, True])
    ('mrad', 'N', 'rad or m')
    """
    return " or ".join(sliding(unit) if slides else unit for slides in sorted(set(prismatic)))
