"""Units of positions and torques for reports: of revolute joints, of prismatic joints, or of both."""

from __future__ import annotations

from collections.abc import Iterable

from haptid.model.equations.joint_parameters import sliding


def unit_for(unit: str, prismatic: Iterable[bool]) -> str:
    """Return the unit of a quantity for the joints of a plot or a table.

    Parameters
    ----------
    unit
        Unit of the quantity on a revolute joint, as ``N m`` or ``mrad``.
    prismatic
        Whether each joint is prismatic.

    Returns
    -------
    str
        ``unit`` where all joints are revolute, its prismatic counterpart where all are prismatic, else both.

    Examples
    --------
    >>> unit_for("mrad", [False]), unit_for("N m", [True]), unit_for("rad", [False, True])
    ('mrad', 'N', 'rad or m')
    """
    return " or ".join(sliding(unit) if slides else unit for slides in sorted(set(prismatic)))
