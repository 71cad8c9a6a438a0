"""Questions to the user where no flag answers them: a wrong reply is asked again, and the others are kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click
import pandas as pd

from haptid.measurement.making.answers import find_device, propose_device, propose_validation, select_runs
from haptid.measurement.making.mapping import TORQUE, Target, parse_map
from haptid.measurement.making.prepared import PreparedTable
from haptid.measurement.making.units_in_names import understand_columns
from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError
from haptid.support.numbers import read_number

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
        flags["measured"] = _ask_whether("Were the data measured on a real device?")
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
    question = "Angle of one encoder count [rad] (as 2*pi/4096)"
    return _ask(question, None, lambda reply: _number_of(reply, "angle of a count", least=0.0))


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
        number = read_number(reply)
    except ValueError:
        number = 0.0
    if not 0.0 < abs(number) < float("inf"):
        raise InputError("torque of an ampere", expected="a number, not 0", got=repr(reply))
    return number


def ask_sensor(prepared: Sequence[PreparedTable], resolution: float | None) -> tuple[float | None, float | None]:
    """Ask for noise and encoder step of the position, with what the data tell as the replies to a bare Enter.

    Parameters
    ----------
    prepared
        Tables with their free joints.
    resolution
        Encoder step [rad] ([m]), where it is known already.

    Returns
    -------
    noise, resolution : float or None
        Standard deviation and step [rad] ([m]); None where they are to be estimated from the data.
    """
    noises, steps = _estimate_sensor(prepared)
    noise = _ask_estimated("Standard deviation of the position's noise [rad]", "noise", noises)
    if resolution is None:
        resolution = _ask_estimated("Step of the encoder [rad] (as 2*pi/4096)", "step", steps)
    return noise, resolution


def ask_whether_to_write() -> None:
    """Ask whether the campaign is to be written as it was understood.

    Raises
    ------
    InputError
        Where it is not.
    """
    if not _ask_whether("Write the campaign as understood above?"):
        todo = "run it again; --map, --free, --device and --validate say what is meant"
        raise InputError("campaign", expected="a yes to what was understood", got="no: nothing was written", todo=todo)


def _estimate_sensor(prepared: Sequence[PreparedTable]) -> tuple[list[float], list[float]]:
    """Estimate noise and encoder step of every free joint in every table, in its unit."""
    noises, steps = [], []
    for one in prepared:
        for joint in one.free:
            for name in (f"position_{joint}_rad", f"position_{joint}_m"):
                if name in one.frame:
                    y = pd.to_numeric(one.frame[name], errors="coerce").to_numpy(dtype=float)
                    steps.append(estimate_resolution(y))
                    noises.append(estimate_noise(one.t, y, steps[-1]))
    return noises, steps


def _ask_estimated(question: str, what: str, estimates: Sequence[float]) -> float | None:
    """Ask for a number; the default shows the estimates, and stands for estimating each run's own."""
    ends = dict.fromkeys(f"{end:.2g}" for end in (min(estimates), max(estimates)))
    default = f"estimated: {' to '.join(ends)}"

    def read(reply: str) -> float | None:
        return None if reply == default else _number_of(reply, what, above=0.0)

    return _ask(question, default, read)


def _number_of(reply: str, what: str, *, least: float = -math.inf, above: float = -math.inf) -> float:
    """Read a number from a reply, which may be a product as ``2*pi/4096``."""
    try:
        number = read_number(reply)
    except ValueError:
        number = math.nan
    if not (number >= least and number > above and math.isfinite(number)):
        expected = f"a number above {above:g}" if math.isfinite(above) else f"a number of at least {least:g}"
        raise InputError(what, expected=f"{expected}, as 2e-4 or 2*pi/4096", got=repr(reply))
    return number


def _ask_whether(question: str) -> bool:
    """Ask for yes, the default, or no."""

    def read(reply: str) -> bool:
        if reply.lower() not in ("y", "yes", "n", "no"):
            raise click.UsageError("answer y or n")
        return reply.lower().startswith("y")

    return _ask(f"{question} (y/n)", "y", read)


def _ask(question: str, default: str | None, read: Callable[[str], T]) -> T:
    """Ask until ``read`` accepts the reply."""

    def check_reply(reply: str) -> T:
        try:
            return read(reply.strip())
        except InputError as error:
            raise click.UsageError(str(error)) from None  # click shows it and asks again

    answer: T = click.prompt(question, default=default, value_proc=check_reply)
    return answer
