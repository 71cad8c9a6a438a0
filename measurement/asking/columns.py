"""Ask what the columns of tables are, until the tables hold all that a fit needs: `Table`s in, `Target`s out.

1. Columns whose names say what they are, and a time whose rows' interval tells its unit, are not asked for.
2. The others are asked for one by one; what is likely meant is proposed where its unit is known.
3. What lacks after that is told, and the columns that were left open are asked for again.

The reply `BACK` asks for the column before once more, with the replies as they were before it; at the first column it
leads to the question before the columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import click

from haptid.measurement.asking.questions import BACK, NONE, WentBack, ask
from haptid.measurement.format.columns import KNOWN, NUMBERED
from haptid.measurement.making.answers import Answers, device_of
from haptid.measurement.making.times import is_bare_time
from haptid.measurement.naming.joint_names import joint_named_in, numbers_by_name, understand_table
from haptid.measurement.naming.lacking_columns import propose_target
from haptid.measurement.naming.map_option import parse_map
from haptid.measurement.naming.mapping import COLUMNS_NEEDED, Target, free_joints, lacking_signals
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError

WORDS = {
    "time": "a time",
    "torque": "what drives the joint (a torque, current, voltage or duty)",
    "position": "a position",
}
"""Signals that a table may lack, as a user is told of them."""
EXAMPLES = {
    "time": "time_ms",
    "torque": "torque_0_Nm, current_0_A",
    "position": "position_0_rad, position_0_deg",
}
"""Replies that name a column, by the signal that lacks."""
Replies = dict[str, Target]
"""What is known of columns, by their names in the user's tables."""
DRIVEN = ("torque", "position")
"""Signals of which a joint needs both."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WayBack:
    """Where `BACK` leads from a question on a column.

    Parameters
    ----------
    is_open
        Whether any question was asked before.
    column
        Column that the question before asks for; empty where it is on something else.
    """

    is_open: bool
    column: str = ""

    @property
    def words(self) -> str:
        """The column to which `BACK` goes, for the end of a question; empty where it is none."""
        return f"; {BACK} asks for {self.column} again" if self.column else ""


AskOne = Callable[[Replies, WayBack], Replies]
"""Question on one column: replies so far, and where `BACK` leads, in; new replies out."""


def ask_lacking_columns(
    tables: Sequence[Table], answers: Answers, past: list[Asked], former: dict[str, Target], *, first: bool
) -> dict[str, Target]:
    """Ask for the columns whose names do not say what they are, as long as time, position or what drives lacks.

    Parameters
    ----------
    tables
        The user's tables.
    answers
        What flags, or earlier replies, say of columns, free joints, the size of an encoder count, and the device, whose
        joints' names are understood.
    past
        Questions on columns that have their replies, to which those of this call are added. The last of them is asked
        once more where it is not among ``answers``, as after `BACK` to a later question.
    former
        Replies that were taken back, which are proposed again; added to.
    first
        Whether no question was asked before those on columns.

    Returns
    -------
    dict
        Column of the format by column of the user's tables, what was stated included.

    Raises
    ------
    InputError
        Where something lacks, and no column is left that could be it.
    WentBack
        Where the reply to the first column is `BACK`, and questions were asked before.
    """
    device = device_of(answers)
    names = Names(step=answers.resolution, joints={} if device is None else numbers_by_name(device))
    replies = {**_plain_times(tables, answers.stated, names), **answers.stated}
    asked_before = bool(past)
    if past and past[-1].is_taken_back:
        last = past.pop()
        replies = _ask_in_turn([(last.column, last.question)], last.before, past, former, first=first)
    while (fault := _find_fault(tables, replace(answers, stated=replies), names)) is not None:
        table, error, lacking = fault
        known = _understand(table, replies, names)
        unknown = [column for column in table.columns if column not in known and not KNOWN.fullmatch(column)]
        # Where nothing lacks, or every column has its reply, and the table still does not do, a reply is wrong.
        replied = [column for column in table.columns if column in unknown or column in replies]
        columns = unknown if lacking and unknown else replied
        if not columns:
            raise error
        click.echo(_tell_fault(table, error, lacking, again=bool(past) or asked_before))
        questions = [(column, partial(_ask_column, column, table, lacking, names, former)) for column in columns]
        replies = _ask_in_turn(questions, replies, past, former, first=first)
    return replies


@dataclass(frozen=True, slots=True, kw_only=True)
class Names:
    """What names of columns are read with.

    Parameters
    ----------
    step
        Size of an encoder count [rad] or [m]; None where it is not stated.
    joints
        Number of each of the device's joints by its name; empty for a single joint.
    """

    step: float | None
    joints: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """A question on a column that has its reply.

    Parameters
    ----------
    column
        The column.
    question
        The question.
    before
        Replies before it.
    is_taken_back
        Whether its reply was taken back, so that it is to be asked once more.
    """

    column: str
    question: AskOne
    before: Replies
    is_taken_back: bool = False


def _ask_in_turn(
    questions: Sequence[tuple[str, AskOne]],
    replies: Replies,
    past: list[Asked],
    former: dict[str, Target],
    *,
    first: bool,
) -> Replies:
    """Ask one question after the other, and those of ``past`` again as often as the user goes back; extend ``past``."""
    waiting = list(questions)
    while waiting:
        column, question = waiting[0]
        try:
            back = WayBack(is_open=True, column=past[-1].column) if past else WayBack(is_open=not first)
            made = question(replies, back)
        except WentBack:
            if not past:
                raise
            last = past.pop()
            waiting.insert(0, (last.column, last.question))
            former |= replies
            replies = last.before
            continue
        past.append(Asked(column=column, question=question, before=replies))
        replies = made
        del waiting[0]
    return replies


def ask_all_columns(
    tables: Sequence[Table], understood: Mapping[str, Target], stated: Mapping[str, Target]
) -> dict[str, Target]:
    """Ask for every column again, with what was understood of it as the reply to a bare Enter.

    Parameters
    ----------
    tables
        The user's tables.
    understood
        Column of the format by column of the user's tables, as it was understood last.
    stated
        The part of it that flags and earlier replies say.

    Returns
    -------
    dict
        Column of the format by column of the user's tables.

    Raises
    ------
    WentBack
        Where the reply to the first column is `BACK`.
    """
    columns = dict.fromkeys(column for table in tables for column in table.columns)
    questions = [(column, partial(_ask_again, column, understood.get(column))) for column in columns]
    return _ask_in_turn(questions, dict(stated), [], {}, first=False)


def _ask_again(column: str, understood: Target | None, replies: Replies, back: WayBack) -> Replies:
    """Return the replies with that to a column of which something is understood already, or nothing."""
    default = "" if understood is None else _write(understood)

    def read(reply: str) -> Target | None:
        if reply == default:
            return understood
        return Target(name=column) if reply == NONE else _read_target(reply)

    ways = f"{_describe_ways(column, default)}{back.words}"
    given = ask(f"{column} is ({ways})", default, read, may_go_back=back.is_open)
    others = {known: target for known, target in replies.items() if known != column}
    return others if given is None else {**others, column: given}


def _describe_ways(column: str, default: str) -> str:
    if default:
        return f"{NONE} leaves it unused"
    return "a name of the format" if KNOWN.fullmatch(column) else f"{', '.join(EXAMPLES[one] for one in DRIVEN)}, …"


def _ask_column(
    column: str,
    table: Table,
    lacking: Sequence[str],
    names: Names,
    former: Mapping[str, Target],
    replies: Replies,
    back: WayBack,
) -> Replies:
    """Return the replies with that to one column; a column that stays open has none."""
    others = {known: target for known, target in replies.items() if known != column}
    taken = {target.name for target in _understand(table, others, names).values()} | {
        name for name in table.columns if KNOWN.fullmatch(name)
    }
    earlier = replies.get(column, former.get(column))
    goal, note = ("", "") if earlier is not None else _propose(column, table, lacking, taken, names.joints)
    default = _write(earlier) if earlier is not None else "" if note else goal
    examples = ", ".join([*(EXAMPLES[signal] for signal in lacking or DRIVEN), "…"])
    number, _ = joint_named_in(column, names.joints)
    ways = f"{goal}; {note}" if note else examples if number is None else NUMBERED.sub(f"_{number}", examples)
    if default:
        ways += f"; {NONE} leaves it unused"
    ways += back.words

    def read(reply: str) -> Target | None:
        if reply in ("", NONE):
            return None
        target = _read_target(reply)
        if target.name in taken:
            raise InputError(column, expected="a name that no other column has", got=target.name)
        return target

    target = ask(f"{column} is ({ways})", default, read, may_go_back=back.is_open)
    return others if target is None else {**others, column: target}


def _propose(
    column: str, table: Table, lacking: Sequence[str], taken: set[str], joints: Mapping[str, int]
) -> tuple[str, str]:
    """Return what a column is likely, and a note on the other unit that is as likely; empty where nothing is."""
    number, _ = joint_named_in(column, joints)
    for signal in lacking:
        # Of several joints each column is likely its own's: those of other joints do not vie with it.
        rivals = table.columns if number is None else [
            other for other in table.columns if joint_named_in(other, joints)[0] in (None, number)
        ]  # fmt: skip
        goal, note = propose_target(signal, column, rivals, table.loosely)
        if number is not None:
            goal, note = (NUMBERED.sub(f"_{number}", text) for text in (goal, note))
        if goal and goal.partition("*")[0] not in taken:
            return goal, note
    return "", ""


def _read_target(reply: str) -> Target:
    try:
        (target,) = parse_map((f"column={reply}",)).values()
    except InputError:
        expected = "a name of the format, as torque_0_Nm or position_0_deg"
        raise InputError("column", expected=expected, got=repr(reply)) from None
    return target


def _write(target: Target) -> str:
    return target.name if target.factor == 1.0 else f"{target.name}*{target.factor:.12g}"


def _plain_times(tables: Sequence[Table], stated: Mapping[str, Target], names: Names) -> dict[str, Target]:
    """Return the times without a unit of tables that have one such column each, where the rows' interval tells it."""
    found: dict[str, Target] = {}
    for table in tables:
        known = names_of(table, stated, names)
        times = [column for column in table.columns if is_bare_time(column)]
        if "time_s" in known or len(times) != 1:
            continue
        goal, note = propose_target("time", times[0], table.columns, table.loosely)
        if goal and not note:
            found[times[0]] = _read_target(goal)
    return found


def _understand(table: Table, replies: Mapping[str, Target], names: Names) -> dict[str, Target]:
    """Return what is known of the columns of a table: what is stated alone, where two names say the same."""
    try:
        return understand_table(table, replies, names.step, names.joints)
    except InputError:
        return dict(replies)


def names_of(table: Table, replies: Mapping[str, Target], names: Names) -> list[str]:
    """Name the columns of a table as the campaign format has them.

    Parameters
    ----------
    table
        The user's table.
    replies
        What flags or replies say of columns.
    names
        What names of columns are read with.

    Returns
    -------
    list of str
        Names of the format, where they are stated or understood; else the user's.
    """
    known = _understand(table, replies, names)
    return [known[column].name if column in known else column for column in table.columns]


def _find_fault(tables: Sequence[Table], answers: Answers, names: Names) -> tuple[Table, InputError, list[str]] | None:
    """Return the first table that no fit could use, its error, and the signals that it lacks."""
    for table in tables:
        known = names_of(table, answers.stated, names)
        try:
            understand_table(table, answers.stated, names.step, names.joints)
            free_joints(known, str(table.path), answers.free, numbers_of=table.loosely)
        except InputError as error:
            return table, error, lacking_signals(known)
    return None


def _tell_fault(table: Table, error: InputError, lacking: Sequence[str], *, again: bool) -> str:
    if error.expected != COLUMNS_NEEDED:
        return str(error)
    if not lacking:
        return f"{table.path.name}: {error.todo.removesuffix(' by --map')}"
    told = f"{table.path.name} {'still ' if again else ''}lacks {' and '.join(WORDS[signal] for signal in lacking)}."
    if again:
        return f"{told} Ctrl-C leaves without writing."
    return f"{told} It has the columns {', '.join(table.columns)}. Enter alone leaves a column unused."
