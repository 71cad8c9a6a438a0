"""Understand the names of real tables: ``Angle (deg)`` or ``torque_1_mNm`` in, the campaign format's column out.

A name is understood where all its words are known, with a quantity and a unit among them: a wrong guess would be worse
than a question. A name without number is that of the only joint.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from haptid.measurement.format.columns import JOINT, KNOWN
from haptid.measurement.naming.languages import QUANTITIES_ELSEWHERE, plain_letters
from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.units import COUNTS, UNITS, respell, unit_of
from haptid.support.errors import InputError

IN_COUNTS = ("position", "reference")
"""Quantities that may be in encoder counts."""
QUANTITIES: dict[str, str] = {
    "time": "time", "t": "time", "timestamp": "time", "stamp": "time", "elapsed": "time",
    "position": "position", "pos": "position", "angle": "position", "q": "position", "theta": "position",
    "encoder": "position", "enc": "position",
    "velocity": "velocity", "vel": "velocity", "speed": "velocity", "omega": "velocity", "qd": "velocity",
    "dq": "velocity",
    "torque": "torque", "tau": "torque", "moment": "torque",
    "force": "force", "effort": "effort",
    "current": "current", "i": "current", "iq": "current",
    "voltage": "voltage", "duty": "duty", "pwm": "duty",
    "temperature": "temperature", "temp": "temperature",
    "supply": "supply", "dclink": "supply", "bus": "supply", "vbus": "supply",
    "vbat": "supply", "vbatt": "supply", "battery": "supply", "batt": "supply",
    "reference": "reference", "setpoint": "reference", "goal": "reference", "desired": "reference",
    "target": "reference", "demand": "reference", "demanded": "reference", "des": "reference", "ref": "reference",
    "sollwert": "reference",
    **QUANTITIES_ELSEWHERE,
}  # fmt: skip
"""Quantity of the campaign format by the user's word."""

FORMS: dict[tuple[str, str], str] = {
    ("time", "s"): "time_s",
    ("position", "rad"): "position_{}_rad",
    ("position", "m"): "position_{}_m",
    ("reference", "rad"): "reference_{}_rad",
    ("reference", "m"): "reference_{}_m",
    ("velocity", "rad_s"): "velocity_{}_rad_s",
    ("velocity", "m_s"): "velocity_{}_m_s",
    ("reference velocity", "rad_s"): "reference_velocity_{}_rad_s",
    ("reference velocity", "m_s"): "reference_velocity_{}_m_s",
    ("torque", "Nm"): "torque_{}_Nm",
    ("force", "N"): "force_{}_N",
    ("effort", "Nm"): "torque_{}_Nm",
    ("effort", "N"): "force_{}_N",
    ("current", "A"): "current_{}_A",
    ("voltage", "V"): "voltage_{}_V",
    ("duty", ""): "duty_{}",
    ("temperature", "C"): "temperature_{}_C",
    ("supply", "V"): "supply_V",
}
"""Name in the campaign format, with a place for the joint's number, by quantity and unit."""
COMMANDS = frozenset({"command", "commanded", "cmd"})
"""Words that make a reference of a position; a torque that is commanded is the torque."""
MEASURED = frozenset({"measured", "meas", "actual", "act", "feedback", "present", "istwert"})
"""Words that say that a column was measured."""
FILLERS = frozenset({
    "joint", "motor", "axis", "value", "wert", "achse", "gelenk", "moteur", "axe", "motore", "asse", "eje",
}) | MEASURED | COMMANDS  # fmt: skip
"""Words that change nothing of what a column holds."""
MEASURED_IN: dict[str, str] = {"rad": "position", "rad_s": "velocity", "Nm": "torque", "A": "current"}
"""Quantity that a unit tells where a name says no more than that it was measured, as ``Istwert [°]``."""
OTHER_THINGS = frozenset({
    "error", "err", "delta", "difference", "limit", "max", "min", "maximum", "minimum", "offset", "zero",
    "noise", "std", "rms", "mean", "average", "estimated", "predicted", "model", "simulated", "external",
    "disturbance", "following", "deviation", "abweichung",
    "friction", "gravity", "feedforward", "ff", "rated", "nominal", "home", "initial", "start",
    "end",
})  # fmt: skip
"""Words that make another thing of a column: a position error is no position."""
JOINT_STATES = re.compile(
    rf"(?:.*(?:joint_?states?|field)[/.]|(?=\w+\[))(position|velocity|effort)(?:\[({JOINT})\]|[/._]?({JOINT}))",
    re.IGNORECASE,
)
"""Elements of ROS's joint states as loggers name them, ``joint_states/position[0]``; groups: array, element."""
FORMS_OF_STATES: dict[str, str] = {
    "position": "position_{}_rad", "velocity": "velocity_{}_rad_s", "effort": "torque_{}_Nm"
}  # fmt: skip
"""Name in the campaign format of an element of ROS's joint states, which that message defines to be in SI units."""
ONLY_JOINT = 0
"""Number that the only joint of a table without numbers gets."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Words:
    """What the words of a column's name say.

    Parameters
    ----------
    quantity
        Quantity of the campaign format.
    unit
        The user's unit.
    joint
        Number of the joint; None where the name has none.
    """

    quantity: str
    unit: str
    joint: int | None


def understand_column(name: str, step: float, *, strangers: bool = False) -> Target | None:
    """Return the column of the campaign format that a name stands for.

    Parameters
    ----------
    name
        Name in the user's table.
    step
        Size of one encoder count [rad] or [m].
    strangers
        Whether words may be unknown, as in ``Carriage position (mm)``, unless they make another thing of the column.

    Returns
    -------
    Target or None
        Name and factor; None where a word is unknown, or quantity or unit is missing.
    """
    words = _words_of(name, strangers=strangers)
    if words is None:
        return None
    unit, factor = UNITS[words.unit]
    if unit == COUNTS and words.quantity in IN_COUNTS:
        unit, factor = "rad", step
    form = FORMS.get((words.quantity, unit))
    if form is None:
        return None
    joint = ONLY_JOINT if words.joint is None else words.joint
    return Target(name=form.format(joint), factor=factor)


def in_counts(name: str) -> bool:
    """Whether a name is that of a position in encoder counts.

    Parameters
    ----------
    name
        Name of a column.

    Returns
    -------
    bool
        False where the name cannot be read.
    """
    words = _words_of(name)
    return words is not None and words.quantity in IN_COUNTS and UNITS[words.unit][0] == COUNTS


def understand_columns(columns: Sequence[str], stated: Mapping[str, Target], step: float | None) -> dict[str, Target]:
    """Return what the columns of a table stand for.

    Parameters
    ----------
    columns
        Names in the user's table.
    stated
        What the user says of columns; it overrules their names.
    step
        Size of one encoder count [rad] or [m]; None where it is not stated.

    Returns
    -------
    dict
        Column of the format by the user's column, the stated ones included. Columns that have a name of the format
        already, or whose place another one has under that name, are left out.

    Raises
    ------
    InputError
        Where two names stand for the same column, or a position in counts has no step.
    """
    targets = dict(stated)
    taken = taken_names(columns, stated)
    by_name: dict[str, str] = {}
    guessed = _joint_states(columns) | _only_ones(columns, 1.0 if step is None else step)
    for column in columns:
        if column in stated or KNOWN.fullmatch(column):
            continue
        target = understand_column(column, 1.0 if step is None else step) or guessed.get(column)
        if target is None or target.name in taken:
            continue
        if step is None and in_counts(column):
            where, todo = "column " + repr(column), "state it by --resolution: 2π/4096 = 0.00153398 for 4096 a turn"
            raise InputError(where, expected="the angle of one count [rad]", got="none", todo=todo)
        if target.name in by_name:
            got = f"{by_name[target.name]!r} and {column!r}"
            todo = f"choose one by --map, as in --map '{column}={target.name}*{target.factor:.6g}'"
            raise InputError("columns", expected=f"one that stands for {target.name}", got=got, todo=todo)
        by_name[target.name] = column
        targets[column] = target
    return targets


def taken_names(columns: Sequence[str], stated: Mapping[str, Target]) -> set[str]:
    """Return the names of the campaign format that columns have already, or that the user states.

    Parameters
    ----------
    columns
        Names in the user's table.
    stated
        What the user says of columns.

    Returns
    -------
    set of str
    """
    return {target.name for target in stated.values()} | {name for name in columns if KNOWN.fullmatch(name)}


def known_names(columns: Sequence[str], stated: Mapping[str, Target]) -> set[str]:
    """Return the names of the campaign format that columns have or certainly stand for.

    Parameters
    ----------
    columns
        Names in the user's table.
    stated
        What the user says of columns.

    Returns
    -------
    set of str
    """
    names = set[str]()
    for column in columns:
        target = stated.get(column) or understand_column(column, 1.0)
        names.add(column if target is None else target.name)
    return names


def _only_ones(columns: Sequence[str], step: float) -> dict[str, Target]:
    """Return what columns with unknown words stand for, each where no other column could stand for the same.

    A carriage position is the position where the table has no other; of a shoulder and an elbow only the user knows
    the numbers.
    """
    read = {column: understand_column(column, step) for column in columns}
    understood = {target.name for target in read.values() if target is not None}
    guessed = {column: understand_column(column, step, strangers=True) for column in columns if read[column] is None}
    names = [target.name for target in guessed.values() if target is not None]
    # A demanded torque is no input where the current was measured.
    understood |= {name.replace("current", "torque").replace("_A", "_Nm") for name in understood if "current" in name}
    return {
        column: target
        for column, target in guessed.items()
        if target is not None and target.name not in understood and names.count(target.name) == 1
    }


def _joint_states(columns: Sequence[str]) -> dict[str, Target]:
    """Return what the elements of ROS's joint states stand for, where the table has positions and efforts of one."""
    found = {column: match for column in columns if (match := JOINT_STATES.fullmatch(column))}
    if not {"position", "effort"} <= {match[1].lower() for match in found.values()}:
        return {}
    return {
        column: Target(name=FORMS_OF_STATES[match[1].lower()].format(int(match[2] or match[3])))
        for column, match in found.items()
    }


def _words_of(name: str, *, strangers: bool = False) -> Words | None:
    """Take a name apart; None where a part is missing, or a word is unknown and no stranger may be among them."""
    text = respell(re.sub(r"(?<=[a-z])(?=\d)|(?<=\d)(?=[A-Za-z])", " ", plain_letters(name)))  # q1, torque0Nm
    found: dict[str, list[str]] = {"quantity": [], "unit": [], "joint": [], "filler": [], "unknown": []}
    for word in re.findall(r"[A-Za-z]+/s|[A-Za-z]+|\d+|%", text):
        kind, spelling = _kind_of(word, follows=bool(found["quantity"]))
        found[kind].append(spelling)
    fillers = {word.lower() for word in found["filler"]}
    quantity = _one_quantity(found["quantity"], demanded=bool(fillers & COMMANDS), strangers=strangers)
    if not found["quantity"] and fillers & MEASURED and len(found["unit"]) == 1:
        quantity = MEASURED_IN.get(UNITS[found["unit"][0]][0])
    # A number that is no joint's is no word that may be unknown.
    unknown = [word for word in found["unknown"] if not strangers or word.lower() in OTHER_THINGS or not word.isalpha()]
    if unknown or quantity is None or len(found["unit"]) != 1 or len(found["joint"]) > 1:
        return None
    joint = int(found["joint"][0]) if found["joint"] else None
    return Words(quantity=quantity, unit=found["unit"][0], joint=joint)


def _kind_of(word: str, *, follows: bool) -> tuple[str, str]:
    """Return what a word is, and how this module spells it.

    A unit follows its quantity: a word that may be either is a quantity where none came before.
    """
    quantity, unit = QUANTITIES.get(word.lower()), unit_of(word)
    if re.fullmatch(JOINT, word):
        return "joint", word
    if quantity is not None and (unit is None or not follows):
        return "quantity", quantity
    if unit is not None:
        return "unit", unit
    return ("filler" if word.lower() in FILLERS else "unknown"), word


def _one_quantity(found: list[str], *, demanded: bool, strangers: bool) -> str | None:
    """Return the quantity of a name; an encoder position is one, an angle setpoint a reference.

    A commanded torque is the torque; the target of one is where the table has no other, which ``strangers`` says.
    """
    kinds = set(found)
    if kinds == {"voltage", "supply"}:
        return "supply"
    aimed = demanded or "reference" in kinds
    kinds = kinds - {"reference"} if len(kinds) > 1 else kinds
    if len(kinds) != 1:
        return None
    (kind,) = kinds
    if not aimed or kind == "reference":
        return kind
    if kind in ("position", "velocity"):
        return {"position": "reference", "velocity": "reference velocity"}[kind]
    return kind if strangers or "reference" not in found else None
