"""Say how to name the columns of signals that a table lacks: names of its columns in, the remedy of an error out."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from haptid.measurement.format.columns import JOINT, KNOWN
from haptid.measurement.naming.signal_names import (
    COUNT,
    COUNTS_ROWS,
    DEGREE,
    LIKELY_COLUMNS,
    READ_BY_COUNTS,
    is_bare_demand,
    is_prismatic_joint,
    likeliest_column,
    likely_goal,
    likely_references,
    silent_columns,
)
from haptid.measurement.naming.units import IN_BRACKETS, unit_in_brackets, unit_of_column
from haptid.measurement.tables.misnamed import likely_time_units
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

DAY = "86400"
"""Seconds of a day, as a remedy writes them."""
DATES_OF_SPREADSHEETS = (20_000.0, 80_000.0)
"""Days from 1900 to dates of 1954 and of 2119, as spreadsheets write dates as numbers."""
FACTOR = "FACTOR"
"""Stands for the factor of a unit that is not known."""
UNIT = re.compile(r"(?!(?i:joint|motor|axis|left|right|raw|meas|act|est|cmd|load|link)\b)\S{1,8}(?: \S{1,3})?")
"""What may be a unit in brackets: a short word, or two, and none that tells a place or a kind."""
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
        column, goal = likeliest_column(signal, unknown)
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
        _add_example(remedy, signal, unknown, joint, numbers_of)
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
    likeliest, goal = likeliest_column(signal, [name for name in columns if not KNOWN.fullmatch(name)])
    if column != likeliest or _unknown_unit(column, signal):
        return "", ""
    number = re.search(rf"(?<!\d){JOINT}(?!\d)", column)
    return _choose_unit(column, goal.format(int(number.group()) if number else 0), numbers_of)


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
    position = position or likeliest_column("position", columns)[0]
    references = [name for name in columns if name.startswith("reference_") and KNOWN.fullmatch(name)]
    references += [column for column, _ in likely_references(columns)]
    if position and numbers_of is not None:
        demands = [column for column in columns if is_bare_demand(column)]
        references += [column for column in demands if travel_alike(numbers_of(column), numbers_of(position))]
    return (position, references[0]) if position and references else ("", "")


def _add_example(
    remedy: _Remedy, signal: str, unknown: list[str], joint: int, numbers_of: Callable[[str], Array] | None
) -> None:
    """Add to a remedy how a signal is named of which no column is likely; the column that shows it is taken away."""
    counter = _find_counter(unknown, numbers_of) if signal == "time" else ""
    if counter:
        unknown.remove(counter)
        remedy.named.append(f"--map '{counter}=time_s*{FACTOR}'")
        remedy.notes[remedy.named[-1]] = f"{FACTOR}: seconds from row to row, as 1/250 at 250 Hz"
        return
    name = LIKELY_COLUMNS[signal][-1][1].format(joint).partition("*")[0]
    example = next(iter(silent_columns(unknown) if signal == "torque" else unknown), None)
    if example is None:
        remedy.added.append(f"{name} (zeros of a free swing)" if signal == "torque" else name)
        return
    unknown.remove(example)
    if signal == "torque" and (unit := UNIT_AT_END.search(example)):
        name = COMMANDS_BY_UNIT[unit.group(1) or unit.group(2)].format(joint)
    remedy.examples.append(f"--map '{example}={name}'")


def _find_counter(columns: Sequence[str], numbers_of: Callable[[str], Array] | None) -> str:
    """Return the column that counts rows; empty where none does."""
    if numbers_of is None:
        return ""
    named = [column for column in columns if COUNTS_ROWS.search(column)]
    return next((column for column in named if np.unique(np.diff(numbers_of(column))).tolist() == [1.0]), "")


def _with_reference(
    remedy: _Remedy, unknown: Sequence[str], joint: int, numbers_of: Callable[[str], Array] | None
) -> _Remedy:
    """Name the demanded position too, where a column is likely one; one note on the unit holds for both angles."""
    references = [
        (column, _choose_unit(column, goal.format(joint), numbers_of)[0]) for column, goal in likely_references(unknown)
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
    return found[1].strip() if likely_goal(signal, alone) in ("", likely_goal(signal, column)) else ""


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
    first, last = DATES_OF_SPREADSHEETS
    longest = THRESHOLDS.longest_row_interval_s / float(DAY)
    if intervals.size and first <= numbers.min() and numbers.max() <= last and np.median(intervals) <= longest:
        return f"{name}*{DAY}", "days, as spreadsheets count them"
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
