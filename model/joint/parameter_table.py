"""The parameters of a locked joint: body, drive and spring, then those of its friction law."""

from __future__ import annotations

from haptid.model.equations.joint_parameters import TABLE, Row, quantities
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import DEFAULT, law_named, laws


def parameter_rows(friction: str = DEFAULT) -> tuple[Row, ...]:
    """Return the rows of a joint whose friction follows this law."""
    return (*TABLE, *law_named(friction).parameters)


def all_ids() -> tuple[str, ...]:
    """Return the ids of all parameters that a joint may have, whatever its law."""
    own = (id for law in laws().values() for id in law.ids)
    return tuple(dict.fromkeys((*(row.id for row in parameter_rows()), *own)))


def joint_parameters(*, prismatic: bool = False, friction: str = DEFAULT) -> tuple[Quantity, ...]:
    """Return the parameters of a locked joint with default ranges; a prismatic joint has no ``gravity_sin``."""
    rows = (row for row in parameter_rows(friction) if not (prismatic and row.id == "gravity_sin"))
    return quantities(rows, prismatic=prismatic)
