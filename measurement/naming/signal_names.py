"""Which column is likely which signal, by its name alone: names of columns in, columns of the campaign format out."""

from __future__ import annotations

import re
from collections.abc import Sequence

from haptid.measurement.format.columns import KNOWN
from haptid.measurement.naming.languages import DEGREES, plain_letters, words_of

_ALONE = r"(?<![a-z]){}(?![a-z])"
"""Pattern of letters that are a word of a name."""


def _elsewhere(quantity: str) -> str:
    """Return the pattern of a quantity's words in other languages."""
    return _ALONE.format(f"(?:{words_of(quantity)})")


DEGREE = "0.0174533"
"""Radians of a degree, as a remedy writes them."""
COUNT = "0.00153398"
"""Radians of one count where 4096 make a turn, as a remedy writes them."""
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
        (rf"time|stamp|elapsed|clock|zeit|{_ALONE.format('(?:t|date|datum)')}|{_elsewhere('time')}", "time_s*?"),
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
        (rf"volt|[\[(]\s*v\s*[\])]\s*$|{_elsewhere('voltage')}", "voltage_{}_V"),
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
COUNTS_ROWS = re.compile(_ALONE.format("(?:samples?|rows?|index|idx|frames?|n)"), re.IGNORECASE)
"""Words of a column that counts rows, where its numbers rise one by one."""
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


def likeliest_column(signal: str, columns: Sequence[str]) -> tuple[str, str]:
    """Return the column that is most likely meant by a signal.

    Parameters
    ----------
    signal
        ``time``, ``torque`` or ``position``.
    columns
        Names of columns, none of them of the campaign format.

    Returns
    -------
    column, goal : str
        Its name, and what it is mapped to with ``{}`` for the joint; both empty where none is likely meant.
    """
    likely = [(column, goal) for column in columns if (goal := likely_goal(signal, column))]
    # A measured torque goes before a demanded one.
    return min(likely, key=lambda pair: DEMANDED.search(pair[0]) is not None, default=("", ""))


def likely_goal(signal: str, column: str) -> str:
    """Return what a column is mapped to where its name is likely that of a signal.

    Parameters
    ----------
    signal
        ``time``, ``torque`` or ``position``.
    column
        Name of a column.

    Returns
    -------
    str
        As `LIKELY_COLUMNS` has it, with ``{}`` for the joint; empty where the name is none of that signal.
    """
    column = plain_letters(column)
    if signal == "position" and (DEMANDED.search(column) or NO_POSITION.search(column)):
        return ""
    if signal == "torque" and SURELY_DRIVES.search(column) is None and _names_position(column):
        return ""
    return next((goal for form, goal in LIKELY_COLUMNS[signal] if re.search(form, column, re.IGNORECASE)), "")


def likely_references(columns: Sequence[str]) -> list[tuple[str, str]]:
    """Return the columns that are likely demanded positions.

    Parameters
    ----------
    columns
        Names of the columns of a table.

    Returns
    -------
    list of (str, str)
        Name of each, and what it is mapped to with ``{}`` for the joint.
    """
    found = []
    for column in columns:
        if DEMANDED.search(column) and not NO_POSITION.search(column):
            measured = likely_goal("position", DEMANDED.sub("", column)) or _goal_of_state(column, columns)
            if measured:
                found.append((column, measured.replace("position", "reference")))
    return found


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
    return likeliest_column(signal, [column for column in columns if not KNOWN.fullmatch(column)]) != ("", "")


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
    _, goal = likeliest_column("position", [column for column in columns if not KNOWN.fullmatch(column)])
    return goal.startswith("position_{}_m")


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
    references = {column for column, _ in likely_references(columns)}
    return [
        column
        for column in columns
        if column not in references
        and not any(form.search(column) for form in (NO_POSITION, NO_SIGNAL))
        and not KNOWN.fullmatch(column)
        and not is_bare_demand(column)
        and not any(likely_goal(signal, column) for signal in ("time", "position"))
    ]


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


def _names_position(column: str) -> bool:
    """Whether a name is likely that of a position, or of one that is demanded."""
    return bool(likely_goal("position", column) or likely_goal("position", DEMANDED.sub("", column)))


def _goal_of_state(column: str, columns: Sequence[str]) -> str:
    """Return what the state beside an action is mapped to, as ``observation.state.hip`` beside ``action.hip``."""
    action = ACTION.match(column)
    if action is None:
        return ""
    states = [state + column[action.end() :] for state in STATES]
    return next((likely_goal("position", state) for state in states if state in columns), "")
