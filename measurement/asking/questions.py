"""Questions to the user where no flag answers them: a wrong reply is asked again, and the others are kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np
import pandas as pd

from haptid.measurement.making.answers import find_device, propose_device, propose_validation, select_runs
from haptid.measurement.making.prepared import PreparedTable
from haptid.measurement.naming.encoder_counts import ToldCounts, counts_of_a_turn, tables_in_counts
from haptid.measurement.naming.mapping import Target
from haptid.measurement.signals.noise import estimate_noise, write_estimated_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError
from haptid.support.numbers import read_number

T = TypeVar("T")
NONE = "-"
"""Reply that takes nothing, where a bare Enter takes what is proposed."""
BACK = "back"
"""Reply that goes back to the question before."""
FACTS = ("title", "device", "measured", "validate")
"""Options that are asked for before the columns, in this order."""


class WentBack(Exception):  # noqa: N818 (a reply, not an error)
    """The user wants to answer the question before once more."""


def ask_fact(option: str, folder: Path, tables: Sequence[Table], former: Mapping[str, Any], *, first: bool) -> Any:
    """Ask for title, device, origin or validation runs.

    Parameters
    ----------
    option
        Of `FACTS`.
    folder
        Folder of the tables.
    tables
        The user's tables.
    former
        Earlier replies by the name of the option, which are proposed again.
    first
        Whether no question was asked before.

    Returns
    -------
    str, bool or tuple of str
        The reply; that to ``validate`` is an empty tuple where no run is to be kept.

    Raises
    ------
    WentBack
        Where the reply is `BACK`.
    """
    names = [table.file_name for table in tables]
    if option == "title":
        return ask("Title", former.get("title", folder.resolve().name), str, may_go_back=not first)
    if option == "device":
        question = "Device (built-in name, device TOML or URDF, or single_joint)"
        proposed = former.get("device", propose_device(folder))
        return ask(question, proposed, lambda reply: find_device(reply, folder), may_go_back=not first)
    if option == "measured":
        question = "Were the data measured on a real device?"
        return _ask_whether(question, former.get("measured", True), may_go_back=not first)
    question = f"Runs to keep from every fit, of {' '.join(names)} (names or val_*.csv, separated by spaces; - none)"
    proposed = " ".join(former.get("validate", propose_validation(names)))
    return ask(
        question, proposed, lambda reply: () if reply == NONE else select_runs(reply.split(), names),
        may_go_back=not first,
    )  # fmt: skip


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


def assume_step(
    tables: Sequence[Table], stated: Mapping[str, Target], flags: dict[str, Any]
) -> tuple[dict[str, Any], list[str]]:
    """Take the angle of an encoder count from the lines before a header, where no flag states it.

    Parameters
    ----------
    tables
        The user's tables.
    stated
        Column of the format by column of the user's tables, as the user states it.
    flags
        Options by name; None, or empty, where absent.

    Returns
    -------
    flags, assumed
        The options with the angle, and a sentence on it; none where no position is in counts, or the files do not say
        one number.
    """
    told = counts_of_a_turn(tables_in_counts(tables, stated))
    number = told[0].number if len(told) == 1 else None
    if flags["resolution"] is not None or number is None:
        return flags, []
    sentence = f"a count is 2*pi/{number} rad: {told[0].says} above its header{told[0].means} (--resolution)"
    return {**flags, "resolution": 2.0 * math.pi / number}, [sentence]


def ask_step(told: Sequence[ToldCounts], *, first: bool) -> float:
    """Ask for the angle of one encoder count, without which counts cannot be converted.

    Parameters
    ----------
    told
        What files say of the counts of a turn; what they say is proposed where it is one number.
    first
        Whether no question was asked before.

    Returns
    -------
    float
        Angle [rad], 0 or more.
    """
    proposed = f"2*pi/{told[0].number}" if len(told) == 1 and told[0].number is not None else None
    says = ["as 2*pi/4096", *(f"{one.says}{one.means}" for one in told)]
    if len(told) > 1:
        says.append("the reply holds for all tables; Ctrl-C leaves, and --map states an angle for each column")
    question = f"Angle of one encoder count [rad] ({'; '.join(says)})"
    return ask(
        question, proposed, lambda reply: _number_of(reply, "angle of a count", least=0.0), may_go_back=not first
    )


def ask_supply(former: float | None) -> float:
    """Ask for the supply, without which a duty says nothing of a voltage.

    Parameters
    ----------
    former
        Earlier reply, which is proposed again; None where there is none.

    Returns
    -------
    float
        Voltage of the motor's amplifier [V], above 0.
    """
    question = "Supply of the motor's amplifier [V]"
    proposed = None if former is None else f"{former:g}"
    return ask(question, proposed, lambda reply: _number_of(reply, "supply", above=0.0), may_go_back=True)


def ask_constant(key: str, former: float | None) -> float:
    """Ask for the torque of an ampere, without which a current says nothing of a torque.

    Parameters
    ----------
    key
        Key of the campaign that states it.
    former
        Earlier reply, which is proposed again; None where there is none.

    Returns
    -------
    float
        Torque [N m] or force [N] of an ampere, not 0.
    """
    what = "Force of an ampere [N/A]" if key.startswith("force") else "Torque of an ampere [N m/A]"
    question = f"{what} (1 where nobody knows it: masses and friction are then in amperes)"
    return ask(question, "" if former is None else f"{former:g}", _factor, may_go_back=True)


def _factor(reply: str) -> float:
    try:
        number = read_number(reply)
    except ValueError:
        number = 0.0
    if not 0.0 < abs(number) < float("inf"):
        raise InputError("torque of an ampere", expected="a number, not 0", got=repr(reply))
    return number


@dataclass(frozen=True, slots=True)
class Sensor:
    """Replies on the position's sensor.

    Parameters
    ----------
    noise, step
        Standard deviation and encoder step [rad] ([m]); None where they are to be estimated from the data.
    """

    noise: float | None
    step: float | None


def ask_sensor(
    prepared: Sequence[PreparedTable], resolution: float | None, former: Sensor | None, *, at_step: bool
) -> Sensor:
    """Ask for noise and encoder step of the position, with what the data tell as the replies to a bare Enter.

    Parameters
    ----------
    prepared
        Tables with their free joints.
    resolution
        Encoder step [rad] ([m]), where it is known already.
    former
        Earlier replies, which are proposed again.
    at_step
        Whether to begin with the step, as after `BACK` to what follows it.

    Returns
    -------
    Sensor

    Raises
    ------
    WentBack
        Where the reply on the noise is `BACK`.
    """
    noises, steps, travel = _estimate_sensor(prepared)
    # As haptid check writes it: where readings rest on the encoder's levels, the step hides the noise.
    written = [write_estimated_noise(*pair) for pair in sorted(zip(noises, steps, strict=True))]
    ends = [f"{end:.2g}" for end in (min(steps), max(steps))]
    noise, step = (None, None) if former is None else (former.noise, former.step)
    at_step = at_step and resolution is None
    while True:
        if not at_step:
            question = "Standard deviation of the position's noise [rad]"
            noise = _ask_estimated(question, "noise", (written[0], written[-1]), travel, noise)
        if resolution is not None:
            return Sensor(noise, resolution)
        try:
            return Sensor(noise, _ask_estimated("Step of the encoder [rad] (as 2*pi/4096)", "step", ends, travel, step))
        except WentBack:
            at_step = False


def ask_whether_to_write() -> bool:
    """Ask whether the campaign is to be written as it was understood.

    Returns
    -------
    bool

    Raises
    ------
    WentBack
        Where the reply is `BACK`.
    """
    return _ask_whether("Write the campaign as understood above?", proposed=True, may_go_back=True)


def ask_what_to_change(choices: Sequence[str]) -> str:
    """Ask which of the replies is to be given again.

    Parameters
    ----------
    choices
        Words that name the replies.

    Returns
    -------
    str
        One of the words.
    """

    def read(reply: str) -> str:
        fitting = [choice for choice in choices if reply and choice.startswith(reply.lower())]
        if len(fitting) != 1:
            raise click.UsageError(todo)
        return fitting[0]

    listed, todo = ", ".join(choices), f"answer {', '.join(choices[:-1])} or {choices[-1]}"
    return ask(f"What is to be changed? ({listed}; Ctrl-C leaves without writing)", None, read, may_go_back=True)


def _estimate_sensor(prepared: Sequence[PreparedTable]) -> tuple[list[float], list[float], float]:
    """Estimate noise and encoder step of every free joint in every table, in its unit, and its largest travel."""
    noises, steps, travel = [], [], 0.0
    for one in prepared:
        for joint in one.free:
            for name in (f"position_{joint}_rad", f"position_{joint}_m"):
                if name in one.frame:
                    y = pd.to_numeric(one.frame[name], errors="coerce").to_numpy(dtype=float)
                    steps.append(estimate_resolution(y))
                    noises.append(estimate_noise(one.t, y, steps[-1]))
                    travel = max(travel, float(np.nanmax(y) - np.nanmin(y)))
    return noises, steps, travel


def _ask_estimated(question: str, what: str, ends: Sequence[str], travel: float, former: float | None) -> float | None:
    """Ask for a number below the travel; the default shows the ends of the estimates, and stands for each run's own.

    Where a number was replied before, that is the default, and `NONE` stands for the estimates.
    """
    default = f"estimated: {' to '.join(dict.fromkeys(ends))}" if former is None else f"{former:.12g}"
    question += "" if former is None else f"; {NONE} estimates it"

    def read(reply: str) -> float | None:
        if (former is None and reply == default) or reply == NONE:
            return None
        number = _number_of(reply, what, above=0.0)
        if number >= travel:
            raise InputError(
                what, expected=f"less than the travel of {travel:.3g}", got=repr(reply), todo="in rad or m?"
            )
        return number

    return ask(question, default, read, may_go_back=True)


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


def _ask_whether(question: str, proposed: bool, *, may_go_back: bool) -> bool:
    """Ask for yes or no."""

    def read(reply: str) -> bool:
        if reply.lower() not in ("y", "yes", "n", "no"):
            raise click.UsageError("answer y or n")
        return reply.lower().startswith("y")

    return ask(f"{question} (y/n)", "y" if proposed else "n", read, may_go_back=may_go_back)


def ask(question: str, default: str | None, read: Callable[[str], T], *, may_go_back: bool = False) -> T:
    """Ask until ``read`` accepts the reply.

    Parameters
    ----------
    question
        What is asked.
    default
        Reply that a bare Enter gives; None where there has to be one.
    read
        Function from the reply to its value; an `InputError` of it is shown, and the question asked again.
    may_go_back
        Whether `BACK` is a reply.

    Returns
    -------
    T
        What ``read`` made of the reply.

    Raises
    ------
    WentBack
        Where the reply is `BACK`, and may be.
    """

    def check_reply(reply: str) -> T:
        if reply.strip().lower() == BACK:
            if may_go_back:
                raise WentBack
            raise click.UsageError("there is no question before this one")
        if default is None and not reply.strip():
            raise click.UsageError("nothing is proposed here: type a reply; Ctrl-C leaves")
        try:
            return read(reply.strip())
        except InputError as error:
            raise click.UsageError(str(error)) from None  # click shows it and asks again

    # Without a default click would ask again without a word.
    answer: T = click.prompt(question, default=default or "", value_proc=check_reply, show_default=bool(default))
    return answer
