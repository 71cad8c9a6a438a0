"""Questions to the user where no flag answers them: a wrong reply is asked again, and the others are kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from haptid.measurement.making.answers import find_device, propose_device, propose_validation, select_runs
from haptid.measurement.making.mapping import TORQUE, Target, parse_map
from haptid.measurement.making.units_in_names import understand_columns
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError

T = TypeVar("T")


def ask_facts(folder: Path, tables: list[Table], flags: dict[str, Any]) -> dict[str, Any]:
    """Ask for title, device, origin and validation runs where no flag gives them.

    Parameters
    ----------
    folder
        Folder of the tables.
    tables
        The user's tables.
    flags
        Options by name; None, or empty, where absent.

    Returns
    -------
    dict
        The options with the replies.
    """
    flags, names = dict(flags), [table.file_name for table in tables]
    if flags["title"] is None:
        flags["title"] = click.prompt("Title", default=folder.resolve().name)
    if flags["device"] is None:
        question = "Device (built-in name, device TOML or URDF, or single_joint)"
        flags["device"] = _ask(question, propose_device(folder), lambda reply: find_device(reply, folder))
    if flags["measured"] is None:
        flags["measured"] = click.confirm("Were the data measured on a real device?", default=True)
    if not flags["validate"] and len(tables) > 1:
        question = f"Runs to keep from every fit, of {' '.join(names)} (names or val_*.csv, separated by spaces)"
        flags["validate"] = _ask(
            question, " ".join(propose_validation(names)), lambda reply: select_runs(reply.split(), names)
        )
    return flags


def assume_facts(folder: Path, tables: list[Table], flags: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Take what `ask_facts` would propose, without a question.

    Parameters
    ----------
    folder
        Folder of the tables.
    tables
        The user's tables.
    flags
        Options by name; None, or empty, where absent.

    Returns
    -------
    flags, assumed
        The options with the proposals, and a sentence on each with the flag that says otherwise.
    """
    flags, names, assumed = dict(flags), [table.file_name for table in tables], list[str]()
    if flags["title"] is None:
        flags["title"] = folder.resolve().name
        assumed.append(f"the title is {flags['title']!r} (--title)")
    if flags["device"] is None:
        flags["device"] = propose_device(folder)
        assumed.append(f"the device is {flags['device']} (--device)")
    if flags["measured"] is None:
        flags["measured"] = True
        assumed.append("the data were measured on a real device (--synthetic)")
    flags, kept = assume_validation(tables, flags)
    assumed += kept
    if not flags["validate"] and len(names) > 1:
        assumed.append("no run is kept from every fit (--validate)")
    if flags["noise"] is None:
        assumed.append("the position's noise is to be estimated from the data (--noise)")
    return flags, assumed


def assume_validation(tables: list[Table], flags: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Keep runs from every fit whose names say so, where no flag names any.

    Parameters
    ----------
    tables
        The user's tables.
    flags
        Options by name; None, or empty, where absent.

    Returns
    -------
    flags, assumed
        The options with the runs, and a sentence on them; none where no name says so.
    """
    if flags["validate"]:
        return flags, []
    kept = propose_validation([table.file_name for table in tables])
    told = [f"kept from every fit: {', '.join(kept)} (--validate)"] if kept else []
    return {**flags, "validate": kept}, told


def ask_columns(table: Table, stated: dict[str, Target], step: float | None) -> dict[str, Target]:
    """Ask for the meaning of the columns whose names do not say it, where time, position or what drives is lacking.

    Parameters
    ----------
    table
        First of the user's tables.
    stated
        What flags say of columns.
    step
        Size of an encoder count [rad] or [m]; None where it is not stated.

    Returns
    -------
    dict
        Column of the format by column of the user's tables, ``stated`` included.

    Raises
    ------
    InputError
        Where two names stand for the same column, or a position in counts has no step.
    """
    known = understand_columns(table.columns, stated, step)
    names = {known[column].name if column in known else column for column in table.columns}
    driven = any(TORQUE.fullmatch(name) for name in names)
    if "time_s" in names and driven and any(name.startswith("position_") for name in names):
        return stated
    click.echo(f"{table.path.name} has the columns {', '.join(table.columns)}. Empty keeps a column as it is.")
    replies = dict(stated)
    for column in table.columns:
        if column not in known:
            replies |= _ask_column(column)
    return replies


def _ask_column(column: str) -> dict[str, Target]:
    def read(reply: str) -> dict[str, Target]:
        return parse_map((f"{column}={reply}",)) if reply else {}

    return _ask(f"{column} is (time_s, torque_0_Nm, position_0_rad*0.0174533, …)", "", read)


def ask_step() -> float:
    """Ask for the angle of one encoder count, without which counts cannot be converted.

    Returns
    -------
    float
        Angle [rad], 0 or more.
    """
    step: float = click.prompt("Angle of one encoder count [rad] (2π/4096 = 0.00153398)", type=click.FloatRange(min=0))
    return step


def ask_supply() -> float:
    """Ask for the supply, without which a duty says nothing of a voltage.

    Returns
    -------
    float
        Voltage of the motor's amplifier [V], above 0.
    """
    volts: float = click.prompt("Supply of the motor's amplifier [V]", type=click.FloatRange(min=0, min_open=True))
    return volts


def ask_constant(key: str) -> float:
    """Ask for the torque of an ampere, without which a current says nothing of a torque.

    Parameters
    ----------
    key
        Key of the campaign that states it.

    Returns
    -------
    float
        Torque [N m] or force [N] of an ampere, not 0.
    """
    what = "Force of an ampere [N/A]" if key.startswith("force") else "Torque of an ampere [N m/A]"
    return _ask(f"{what} (1 where nobody knows it: masses and friction are then in amperes)", "", _factor)


def _factor(reply: str) -> float:
    try:
        number = float(reply)
    except ValueError:
        number = 0.0
    if not 0.0 < abs(number) < float("inf"):
        raise InputError("torque of an ampere", expected="a number, not 0", got=repr(reply))
    return number


def ask_noise() -> float | None:
    """Ask for the noise of the position.

    Returns
    -------
    float or None
        Standard deviation [rad] ([m]); None where it is to be estimated from the data.
    """
    question = "Standard deviation of the position's noise [rad] (empty: estimated from the data)"
    return _ask(question, "", _number_or_none)


def _number_or_none(reply: str) -> float | None:
    if not reply:
        return None
    try:
        number = float(reply)
    except ValueError:
        number = 0.0
    if not number > 0.0:
        raise InputError("noise", expected="a number above 0, or nothing", got=repr(reply))
    return number


def _ask(question: str, default: str, read: Callable[[str], T]) -> T:
    """Ask until ``read`` accepts the reply."""

    def check_reply(reply: str) -> T:
        try:
            return read(reply.strip())
        except InputError as error:
            raise click.UsageError(str(error)) from None  # click shows it and asks again

    answer: T = click.prompt(question, default=default, value_proc=check_reply)
    return answer
