"""What a column is, as users write it for ``--map``: ``angle=position_0_deg`` in, `Target` out."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from haptid.measurement.format.columns import KNOWN
from haptid.measurement.naming.languages import is_bare_grad
from haptid.measurement.naming.mapping import FLAG, Target
from haptid.measurement.naming.units import unit_in_brackets, unit_of_column
from haptid.measurement.naming.units_in_names import in_counts, understand_column
from haptid.support.errors import InputError
from haptid.support.numbers import read_number


def parse_map(entries: tuple[str, ...]) -> dict[str, Target]:
    """Parse the values of ``--map``.

    Parameters
    ----------
    entries
        ``COLUMN=NAME`` or ``COLUMN=NAME*FACTOR``. A NAME may have another unit than the format, as in
        ``motor=position_0_deg``, or the factor be stated, as in ``motor=position_0_rad*0.0174533`` or
        ``enc=position_0_rad*2*pi/4096``.

    Returns
    -------
    dict
        Column of the format by column of the user's table.

    Raises
    ------
    InputError
        Where an entry has another form, the format has no column NAME, or FACTOR is no number.
    """
    targets: dict[str, Target] = {}
    for entry in entries:
        column, _, goal = entry.rpartition("=")  # from the right: the user's column may hold "=", a NAME may not
        name, _, factor = goal.partition("*")
        target = _target_of(name)
        if not column or target is None:
            expected = "COLUMN=NAME or COLUMN=NAME*FACTOR with a NAME such as torque_0_Nm or position_0_deg"
            raise InputError(FLAG, expected=expected, got=repr(entry))
        try:
            number = read_number(factor or "1")
        except ValueError:
            raise InputError(FLAG, expected=f"a number as the factor of {name}", got=repr(factor)) from None
        targets[column] = Target(name=target.name, factor=target.factor * number)
    return targets


def remarks_on_units(stated: Mapping[str, Target]) -> list[str]:
    """Remark on columns that are taken in another unit than their names say, without a factor between both.

    Parameters
    ----------
    stated
        What the user says of columns, as `parse_map` returns it.

    Returns
    -------
    list of str
        One a column.
    """
    remarks = []
    for column, target in stated.items():
        said = unit_in_brackets(column)
        if said is None or target.factor != 1.0 or said[1:] == (unit_of_column(target.name), 1.0):
            continue
        remarks.append(
            f"{column!r} is taken as {target.name} as it stands, though its name says {said[0]}: state the factor by "
            f"--map '{column}={target.name}*FACTOR'"
        )
    return remarks


def remarks_on_grad(understood: Mapping[str, Target], stated: Collection[str]) -> list[str]:
    """Remark on columns in ``grad`` that are taken for degrees, and may be in gon.

    Parameters
    ----------
    understood
        Column of the format by column of the user's tables.
    stated
        The columns of which the user says what they are.

    Returns
    -------
    list of str
        One a column.
    """
    return [
        f"{column!r} is taken in degrees: state gon (400 a turn) by --map '{column}={target.name}*pi/200'"
        for column, target in understood.items()
        if column not in stated and is_bare_grad(column)
    ]


def _target_of(name: str) -> Target | None:
    """Return the column of the format that a NAME stands for; None where it stands for none.

    What a name in counts stands for hangs on the size of a count, which ``*FACTOR`` says.
    """
    if KNOWN.fullmatch(name):
        return Target(name=name)
    return None if in_counts(name) else understand_column(name, 1.0)
