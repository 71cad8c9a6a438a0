"""The parameters of a locked joint: body, drive and spring, then those of its friction law.

The id of a friction law comes in, rows or `Quantity` with default ranges go out.
"""

from __future__ import annotations

from haptid.model.equations.joint_parameters import TABLE, Row, quantities
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import DEFAULT, law_named, laws


def parameter_rows(friction: str = DEFAULT) -> tuple[Row, ...]:
    """Return the rows of the parameter table for a friction law.

    Parameters
    ----------
    friction
        Id of the friction law.

    Returns
    -------
    tuple of Row
        Rows of body, drive and spring, then those of the law.

    Raises
    ------
    InputError
        Where there is no such law.
    """
    return (*TABLE, *law_named(friction).parameters)


def all_ids() -> tuple[str, ...]:
    """List the parameters that a joint may have under any friction law.

    Returns
    -------
    tuple of str
        Ids, each once: those of body, drive and spring, then those of the laws.
    """
    own = (id for law in laws().values() for id in law.ids)
    return tuple(dict.fromkeys((*(row.id for row in parameter_rows()), *own)))


def joint_parameters(*, prismatic: bool = False, friction: str = DEFAULT) -> tuple[Quantity, ...]:
    """Return the parameters of a locked joint with default ranges.

    Parameters
    ----------
    prismatic
        Whether the joint slides: then units are those of forces and lengths, and there is no ``gravity_sin``.
    friction
        Id of the friction law.

    Returns
    -------
    tuple of Quantity
        Parameters in the order of `parameter_rows`.

    Raises
    ------
    InputError
        Where there is no such law.
    """
    rows = (row for row in parameter_rows(friction) if not (prismatic and row.id == "gravity_sin"))
    return quantities(rows, prismatic=prismatic)
