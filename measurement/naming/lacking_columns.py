"""Say how to name the columns of signals that a table lacks: names of its columns in, the remedy of an error out."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from haptid.measurement.format.columns import JOINT, KNOWN
from haptid.measurement.naming.degrees import DEGREES
from haptid.measurement.naming.languages import plain_letters, words_of
from haptid.measurement.naming.units import IN_BRACKETS, unit_in_brackets, unit_of_column
from haptid.measurement.tables.misnamed import likely_time_units
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

_ALONE = r"(?<![a-z]){}(?![a-z])"
"""Pattern of letters that are a word of a name."""


def _elsewhere(quantity: str) -> str:
    """Return the pattern of a quantity's words in other languages."""
    return _ALONE.format(f"(?:{words_of(quantity)})")


DEGREE = "0.0174533"
"""Radians of a degree, as a remedy writes them."""
COUNT = "0.00153398"
"""Radians of one count where 4096 make a turn, as a remedy writes them."""
FACTOR = "FACTOR"
"""Stands for the factor of a unit that is not known."""
UNIT = re.compile(r"(?!(?i:joint|motor|axis|left|right|raw|meas|act|est|cmd|load|link)\b)\S{1,8}(?: \S{1,3})?")
"""What may be a unit in brackets: a short word, or two, and none that tells a place or a kind."""
COUNTED = (
    r"^(?!.*(?:torque|tau|effort|force|moment|current|amp|volt|duty|pwm|temp|time|stamp|clock)).*"
    rf"{_ALONE.format('(?:counts?|cnts?|ticks?|raw|lsb|adc)')}"
)
"""Pattern of names of readings in counts that are none of another signal."""
LIKELY_COLUMNS: dict[str, tuple[tuple[str, str], ...]] = {
    "time": (
        (_ALONE.format("(?:ms|msec|millis[a-z]*)"), "time_s*0.001"),
        (_ALONE.format("(?:[uµμ]s|usec|micros[a-z]*)"), "time_s*1e-06"),
        (_ALONE.format("(?:ns|nsec|nanos[a-z]*)"), "time_s*1e-09"),
        (_ALONE.format("(?:s|sec|seconds?)"), "time_s"),
        (rf"time|stamp|elapsed|clock|{_ALONE.format('t')}|{_elsewhere('time')}", "time_s*?"),
    ),
    "torque": (
        (_ALONE.format("(?:mn[ ·*]?m|n[ ·*]?mm)"), "torque_{}_Nm*0.001"),
        (_ALONE.format(r"n[ ·*]?cm"), "torque_{}_Nm*0.01"),
        (_ALONE.format(r"kn[ ·*]?m"), "torque_{}_Nm*1000"),
        (r"lbf?[ ·*.-]?ft|ft[ ·*.-]?lb", "torque_{}_Nm*1.35582"),
        (r"lbf?[ ·*.-]?in|in[ ·*.-]?lb", "torque_{}_Nm*0.112985"),
        (r"ozf?[ ·*.-]?in|in[ ·*.-]?oz", "torque_{}_Nm*0.00706155"),
        (r"kgf?[ ·*.]?cm", "torque_{}_Nm*0.0980665"),
        (rf"force|{_elsewhere('force')}", "force_{}_N"),
        (rf"{_ALONE.format('ma')}", "current_{}_A*0.001"),
        (rf"current|amp|{_ALONE.format('(?:i|iq|a)')}|{_elsewhere('current')}", "current_{}_A"),
        (rf"volt|{_elsewhere('voltage')}", "voltage_{}_V"),
        (r"(?:duty|pwm).*(?:%|pct|percent)", "duty_{}*0.01"),
        (r"duty|pwm", "duty_{}*?"),
        (
            rf"torque|tau|trq|effort|moment|{_ALONE.format('(?:m|nm)')}|{_elsewhere('torque')}",
            "torque_{}_Nm",
        ),
    ),
    "position": (
        (_ALONE.format("mrad"), "position_{}_rad*0.001"),
        (_ALONE.format("rad(?:ians?)?"), "position_{}_rad"),  # a word: Winkelgrad is none
        (_ALONE.format("mm"), "position_{}_m*0.001"),
        (r"turns|rev", "position_{}_rad*6.28319"),
        (rf"deg|°|{DEGREES}", f"position_{{}}_rad*{DEGREE}"),
        (_ALONE.format("gon"), "position_{}_rad*0.015708"),
        (COUNTED, f"position_{{}}_rad*{COUNT}"),
        (
            rf"angle|theta|pos|enc|winkel|{_ALONE.format('pot(?:i|entiometer)?')}|{_ALONE.format('q')}"
            rf"|{_elsewhere('position')}"
            r"|^(?:observation[./_])?state(?![a-z])",  # as LeRobot calls the positions of a robot's joints
            "position_{}_rad*?",
        ),
    ),
}
"""By signal: patterns of names that it is likely under, and the column of the campaign format with the factor.

The first match decides. ``?`` stands where a name has no unit: the interval of the rows tells that of a time as a rule,
the largest number that of a duty, and nothing radians from degrees.
"""
READ_BY_COUNTS = re.compile(r"enc|pot(?![a-z])|poti", re.IGNORECASE)
"""Names of sensors that are read in counts where their numbers are whole."""
DEMANDED = re.compile(
    rf"demand|target|set_?point|command|cmd|desired|goal|reference|soll|{_ALONE.format('(?:des|ref|action)')}",
    re.IGNORECASE,
)
"""Names of what a controller follows, which is no measured position."""
NO_SIGNAL = re.compile(
    r"index|frame|episode|task|reward|done|success|temp|enabled?(?![a-z])|status|mode|flag", re.IGNORECASE
)
"""Names of counters, marks and what else drives no joint."""
NO_POSITION = re.compile(
    rf"error|following|deviation|vel|speed|geschw|drehzahl|rpm|/ ?s(?![a-z])|{_elsewhere('velocity')}", re.IGNORECASE
)
"""Names that hold a word of a position and are none."""
SURELY_DRIVES = re.compile(
    rf"torque|tau|trq|effort|moment|force|current|amp|volt|duty|pwm|{_ALONE.format('nm')}"
    rf"|{'|'.join(_elsewhere(quantity) for quantity in ('torque', 'force', 'current', 'voltage'))}",
    re.IGNORECASE,
)
"""Words of what drives a joint; letters such as ``m`` or ``i`` alone are none beside a position's word."""
ACTION = re.compile(r"actions?(?![a-z])", re.IGNORECASE)
"""Begin of the names of what a robot's joints are to follow, in data sets for learning; the rest names the joint."""
STATES = ("observation.state", "state")
"""Begins of the names of the positions beside an action."""
BITS_OF_DUTY = (8, 10, 12, 14, 16)
"""Bits that a timer's duty has, by which its largest number is one less than a power of two."""
COMMANDS_BY_UNIT = {"V": "voltage_{}_V", "A": "current_{}_A", "%": "duty_{}*0.01"}
"""What a column drives a joint by, where its name tells the unit alone."""
UNIT_AT_END = re.compile(r"[\[(]\s*(V|A|%)\s*[\])]\s*$|_(V|A)$")
LONGEST_REMEDY = 145
"""Most characters of a remedy with an example for each signal."""


def tell_how_to_name(
    lacking: Sequence[str],
    columns: Sequence[str],
    joints: Collection[int],
    numbers_of: Callable[[str], Array] | None,
) -> str:
    """Say how to name the columns of signals that are lacking: those of the table that are likely meant.

    Parameters
    ----------
    lacking
        Signals: ``time``, ``torque`` or ``position``, at least one.
    columns
        Names of the columns of the table.
    joints
        Joints that the table is known to have; the first of them, or 0, stands in the names.
    numbers_of
        As `mapping.free_joints` takes it.

    Returns
    -------
    str
        Remedy of an error.
    """
    joint = min(joints, default=0)
    unknown = [column for column in columns if not KNOWN.fullmatch(column)]
    remedy = _Remedy(lacking=lacking)
    for signal in lacking:
        column, goal = _likeliest_column(signal, unknown)
        if column:
            unknown.remove(column)
            if signal == "torque" and is_prismatic_joint(joint, columns):
                goal = re.sub(r"torque_{}_Nm(?:\*.*)?$", "force_{}_N", goal)
            sure, note = _choose_factor(signal, column, goal.format(joint), numbers_of)
            remedy.named.append(f"--map '{column}={sure}'")
            if note:
                remedy.notes[remedy.named[-1]] = note
            if signal == "position":
                remedy = replace(remedy, position=(column, sure))
            continue
        name = LIKELY_COLUMNS[signal][-1][1].format(joint).partition("*")[0]
        example = next(iter(silent_columns(unknown) if signal == "torque" else unknown), None)
        if example is not None:
            unknown.remove(example)
            if signal == "torque" and (unit := UNIT_AT_END.search(example)):
                name = COMMANDS_BY_UNIT[unit.group(1) or unit.group(2)].format(joint)
            remedy.examples.append(f"--map '{example}={name}'")
        else:
            remedy.added.append(f"{name} (zeros of a free swing)" if signal == "torque" else name)
    whole = remedy.told()
    wider = _with_reference(remedy, unknown, joint, numbers_of).told() if "position" in lacking else whole
    # A cut name helps nobody: where all do not fit, one shows how.
    return next((told for told in (wider, whole) if len(told) <= LONGEST_REMEDY), remedy.shortest())


def propose_target(
    signal: str, column: str, columns: Sequence[str], numbers_of: Callable[[str], Array] | None
) -> tuple[str, str]:
    """Propose what a column is, where it is the one that is most likely meant by a signal.

    Parameters
    ----------
    signal
        ``time``, ``torque`` or ``position``.
    column
        Name of the column.
    columns
        Names of all columns of the table.
    numbers_of
        As `mapping.free_joints` takes it.

    Returns
    -------
    goal, note : str
        Column of the campaign format with the factor, of the joint that the name tells, or joint 0, and what else its
        unit may be; both empty where another column is more likely, none is, or its unit is none that is known.
    """
    likeliest, goal = _likeliest_column(signal, [name for name in columns if not KNOWN.fullmatch(name)])
    if column != likeliest or _unknown_unit(column, signal):
        return "", ""
    number = re.search(rf"(?<!\d){JOINT}(?!\d)", column)
    return _choose_unit(column, goal.format(int(number.group()) if number else 0), numbers_of)


def is_prismatic_joint(joint: int, columns: Sequence[str]) -> bool:
    """Whether the position of a joint is a length, by its column or by the one that is likely meant.

    Parameters
    ----------
    joint
        Number of the joint.
    columns
        Names of the columns, those of the campaign format among them.

    Returns
    -------
    bool
    """
    if f"position_{joint}_rad" in columns or f"position_{joint}_m" in columns:
        return f"position_{joint}_rad" not in columns
    _, goal = _likeliest_column("position", [column for column in columns if not KNOWN.fullmatch(column)])
    return goal.startswith("position_{}_m")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Remedy:
    """What is to be done about signals that are lacking in a table.

    Parameters
    ----------
    lacking
        Signals, as ``torque``.
    named
        Options that name the columns which are likely meant.
    notes
        What else the units of these columns may be, by option.
    examples
        Options that show how a column is named, where none is likely meant.
    added
        Columns that the table needs, where it has none to name.
    position
        Column that is likely the position, and what it is mapped to; empty where none is, or none lacks.
    """

    lacking: Sequence[str]
    named: list[str] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)
    examples: list[str] = field(default_factory=list)
    added: list[str] = field(default_factory=list)
    position: tuple[str, str] = ("", "")

    def told(self) -> str:
        """Return the whole of it, as an error's remedy."""
        used = " ".join([*self.named, *(f"({note})" for note in self.notes.values())])
        ways = (
            ("use", used),
            ("name a column, as in", " ".join(self.examples)),
            ("add", " and ".join(self.added)),
        )
        return f"no {', no '.join(self.lacking)}: {', '.join(f'{how} {what}' for how, what in ways if what)}"

    def shortest(self) -> str:
        """Return one example, with what else its unit may be."""
        (first, *_) = [*self.named, *self.examples, *self.added]
        note = f" ({self.notes[first]})" if first in self.notes else ""
        return f"no {', no '.join(self.lacking)}: name them, as in {first}{note}"


def holds_likely(signal: str, columns: Sequence[str]) -> bool:
    """Whether a column is likely meant by a signal.

    Parameters
    ----------
    signal
        ``time``, ``torque`` or ``position``.
    columns
        Names of the columns, those of the campaign format among them.

    Returns
    -------
    bool
    """
    return _likeliest_column(signal, [column for column in columns if not KNOWN.fullmatch(column)]) != ("", "")


def silent_columns(columns: Sequence[str]) -> list[str]:
    """Return the columns that may be anything, what drives a joint too.

    Parameters
    ----------
    columns
        Names of the columns, those of the campaign format among them.

    Returns
    -------
    list of str
        Names that are neither of the format nor likely of a time, a position, a demand, a speed or a counter.
    """
    references = {column for column, _ in _likely_references(columns)}
    return [
        column
        for column in columns
        if column not in references
        and not any(form.search(column) for form in (NO_POSITION, NO_SIGNAL))
        and not KNOWN.fullmatch(column)
        and not is_bare_demand(column)
        and not any(_likely_goal(signal, column) for signal in ("time", "position"))
    ]


def find_followed(columns: Sequence[str], numbers_of: Callable[[str], Array] | None) -> tuple[str, str]:
    """Find a position and what it is to follow, by their names.

    Parameters
    ----------
    columns
        Names of the columns, those of the campaign format among them.
    numbers_of
        As `mapping.free_joints` takes it.

    Returns
    -------
    position, reference : str
        Names of the columns; both empty where one of them is not there.
    """
    position = next((name for name in columns if name.startswith("position_") and KNOWN.fullmatch(name)), "")
    position = position or _likeliest_column("position", columns)[0]
    references = [name for name in columns if name.startswith("reference_") and KNOWN.fullmatch(name)]
    references += [column for column, _ in _likely_references(columns)]
    if position and numbers_of is not None:
        demands = [column for column in columns if is_bare_demand(column)]
        references += [column for column in demands if travel_alike(numbers_of(column), numbers_of(position))]
    return (position, references[0]) if position and references else ("", "")


def _likeliest_column(signal: str, columns: Sequence[str]) -> tuple[str, str]:
    """Return the column that is most likely meant by a signal, and what it is mapped to; empty where none is."""
    likely = [(column, goal) for column in columns if (goal := _likely_goal(signal, column))]
    # A measured torque goes before a demanded one.
    return min(likely, key=lambda pair: DEMANDED.search(pair[0]) is not None, default=("", ""))


def _with_reference(
    remedy: _Remedy, unknown: Sequence[str], joint: int, numbers_of: Callable[[str], Array] | None
) -> _Remedy:
    """Name the demanded position too, where a column is likely one; one note on the unit holds for both angles."""
    references = [
        (column, _choose_unit(column, goal.format(joint), numbers_of)[0])
        for column, goal in _likely_references(unknown)
    ]
    measured, goal = remedy.position
    if numbers_of is not None and measured:
        bare = [column for column in unknown if is_bare_demand(column)]
        references += [
            (column, goal.replace("position", "reference"))
            for column in bare
            if travel_alike(numbers_of(column), numbers_of(measured))
        ]
    if not references:
        return remedy
    column, goal = references[0]
    named = [*remedy.named, f"--map '{column}={goal}'"]
    notes = {option: re.sub(rf"position_{JOINT}_rad(?=\*)", "", note) for option, note in remedy.notes.items()}
    return replace(remedy, named=named, notes=notes)


def is_bare_demand(column: str) -> bool:
    """Say whether a name is that of something demanded, without a word on what, as ``setpoint`` or ``target_1``.

    Parameters
    ----------
    column
        Name of a column.

    Returns
    -------
    bool
    """
    return DEMANDED.search(column) is not None and re.search("[A-Za-z]", DEMANDED.sub("", column)) is None


def travel_alike(demanded: Array, measured: Array) -> bool:
    """Say whether a demanded signal may be that position in the same unit which another one follows.

    Parameters
    ----------
    demanded, measured
        Signals in one unit, if they are positions, shape (n_t,) each.

    Returns
    -------
    bool
        False where one does not move, their travels differ much, or one is off by more than the larger travel.
    """
    one, other = demanded[np.isfinite(demanded)], measured[np.isfinite(measured)]
    if not one.size or not other.size or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return False
    ratio = float(np.ptp(one) / np.ptp(other))
    is_near = abs(float(np.median(one) - np.median(other))) <= max(np.ptp(one), np.ptp(other))
    return bool(is_near and 1.0 / THRESHOLDS.largest_ratio_of_travels <= ratio <= THRESHOLDS.largest_ratio_of_travels)


def _unknown_unit(column: str, signal: str) -> str:
    """Return what stands for a unit in brackets behind a name and is none that is known; empty where nothing is."""
    found = IN_BRACKETS.search(column)
    if found is None or UNIT.fullmatch(found[1].strip()) is None or unit_in_brackets(column) is not None:
        return ""
    # Where the name alone leads to another unit, the brackets were read.
    alone = column[: found.start()]
    return found[1].strip() if _likely_goal(signal, alone) in ("", _likely_goal(signal, column)) else ""


def _choose_factor(signal: str, column: str, goal: str, numbers_of: Callable[[str], Array] | None) -> tuple[str, str]:
    """Return what a column is mapped to, with a factor or a word for one, and a note on its unit."""
    sure, note = _choose_unit(column, goal, numbers_of)
    unit, name = _unknown_unit(column, signal), sure.partition("*")[0]
    return (f"{name}*{FACTOR}", f"{FACTOR}: {unit_of_column(name)} of one {unit!r}") if unit else (sure, note)


def _choose_unit(column: str, goal: str, numbers_of: Callable[[str], Array] | None) -> tuple[str, str]:
    """Return what a column is mapped to, with a factor, and a note on the other unit that is as likely."""
    name, _, factor = goal.partition("*")
    numbers = np.empty(0) if numbers_of is None else numbers_of(column)
    numbers = numbers[np.isfinite(numbers)]
    is_whole = numbers.size > 0 and bool(np.all(numbers == np.round(numbers)))
    if factor == "?" and name.startswith("duty"):
        return _choose_full_duty(name, float(np.max(np.abs(numbers), initial=0.0)), is_whole=is_whole)
    if factor == "?" and is_whole and READ_BY_COUNTS.search(column):
        goal, factor = f"{name}*{COUNT}", COUNT
    if factor == COUNT:
        return goal, "if 4096 counts a turn"
    if factor != "?":
        return goal, ""
    if name != "time_s":
        return name, f"radians; degrees: {name}*{DEGREE}"
    intervals = np.abs(np.diff(numbers))
    (unit, seconds), *others = likely_time_units(float(np.median(intervals)) if intervals.size else float("nan"))
    note = f"{unit}; {others[0][0]}: {name}*{others[0][1]}" if others else ""
    return name if float(seconds) == 1.0 else f"{name}*{seconds}", note


def _choose_full_duty(name: str, largest: float, *, is_whole: bool) -> tuple[str, str]:
    """Return the factor of a duty by its largest number, and a note on what that takes for full."""
    if largest <= 1.0:
        return name, "a share of the supply"
    full = next((2**bits - 1 for bits in BITS_OF_DUTY if largest < 2**bits), None) if is_whole else None
    if full is None:
        return f"{name}*0.01", "per cent of the supply"
    return f"{name}*{1.0 / full:.4g}", f"{full} is full; per cent: *0.01" if largest <= 100 else f"{full} is full"


def _likely_goal(signal: str, column: str) -> str:
    """Return what a column is mapped to where its name is likely that of a signal; empty where it is not."""
    column = plain_letters(column)
    if signal == "position" and (DEMANDED.search(column) or NO_POSITION.search(column)):
        return ""
    if signal == "torque" and SURELY_DRIVES.search(column) is None and _names_position(column):
        return ""
    return next((goal for form, goal in LIKELY_COLUMNS[signal] if re.search(form, column, re.IGNORECASE)), "")


def _names_position(column: str) -> bool:
    """Whether a name is likely that of a position, or of one that is demanded."""
    return bool(_likely_goal("position", column) or _likely_goal("position", DEMANDED.sub("", column)))


def _likely_references(columns: Sequence[str]) -> list[tuple[str, str]]:
    """Return the columns that are likely demanded positions, and what each is mapped to."""
    found = []
    for column in columns:
        if DEMANDED.search(column) and not NO_POSITION.search(column):
            measured = _likely_goal("position", DEMANDED.sub("", column)) or _goal_of_state(column, columns)
            if measured:
                found.append((column, measured.replace("position", "reference")))
    return found


def _goal_of_state(column: str, columns: Sequence[str]) -> str:
    """Return what the state beside an action is mapped to, as ``observation.state.hip`` beside ``action.hip``."""
    action = ACTION.match(column)
    if action is None:
        return ""
    states = [state + column[action.end() :] for state in STATES]
    return next((_likely_goal("position", state) for state in states if state in columns), "")
