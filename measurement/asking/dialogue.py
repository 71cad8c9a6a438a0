"""Talk with the user on a terminal until a campaign is understood as it is meant: tables in, `Answers` out.

Each question is asked once. Where the user does not agree with what was understood, or a reply cannot be right, the
user names what is to be changed, and only that is asked again, with the earlier reply as the proposal. The reply `BACK`
takes the reply before back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from haptid.measurement.asking.columns import Asked, Names, ask_all_columns, ask_lacking_columns, names_of
from haptid.measurement.asking.questions import (
    BACK,
    FACTS,
    Sensor,
    WentBack,
    ask_constant,
    ask_fact,
    ask_sensor,
    ask_step,
    ask_supply,
    ask_what_to_change,
    ask_whether_to_write,
)
from haptid.measurement.making.answers import Answers
from haptid.measurement.making.from_flags import answers_of, complete
from haptid.measurement.making.prepared import (
    PreparedTable,
    current_constants,
    describe,
    describe_drives,
    lack_supply,
    prepare_tables,
)
from haptid.measurement.naming.encoder_counts import counts_of_a_turn, tables_in_counts
from haptid.measurement.naming.mapping import Target, refuse_reference_alone
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError

COLUMNS, SENSOR = "columns", "noise"
"""What may be changed beside the options of `OPTIONS`."""
OPTIONS = {
    "title": "title",
    "device": "device",
    "origin": "measured",
    "validation": "validate",
    "ampere": "torque_constant",
    "supply": "supply",
}
"""Option by the word under which its reply may be changed."""


def ask_until_agreed(
    folder: Path,
    tables: Sequence[Table],
    flags: Mapping[str, Any],
    stated: Mapping[str, Target],
    layouts: Sequence[str],
) -> tuple[Answers, list[PreparedTable]]:
    """Ask for what no flag says, show what was understood, and ask for changes until the user agrees.

    Parameters
    ----------
    folder
        Folder of the tables.
    tables
        The user's tables.
    flags
        Options of ``haptid init`` by name; None, or empty, where absent.
    stated
        Column of the format by column of the user's tables, as flags state it.
    layouts
        Lines on the tables' layouts, shown with what was understood.

    Returns
    -------
    answers : Answers
        Flags and replies.
    prepared : list of PreparedTable
        The tables as they were understood.

    Raises
    ------
    InputError
        Where the tables are at fault, and not a reply.
    """
    for table in tables:
        names = names_of(table, stated, Names(step=flags["resolution"]))
        refuse_reference_alone(names, str(table.path), table.loosely)
    click.echo(f"Enter takes what stands in brackets; {BACK} goes to the question before.")
    # Where the sensor is stated, the command may be one of a script: nothing is asked at its end.
    talk = _Talk(folder, tables, flags, stated)
    while True:
        try:
            answers, prepared = talk.ask()
            click.echo("\n".join([*layouts, *describe(prepared), *describe_drives(prepared, answers)]))
            if flags["noise"] is not None:
                return answers, prepared
            answers = talk.ask_sensor(answers, prepared)
            if ask_whether_to_write():
                return answers, prepared
            talk.change()
        except WentBack:
            talk.take_back()
        except InputError as error:
            if not talk.may_be_wrong:
                raise
            click.echo(f"Error: {error}")
            talk.change()


class _Talk:
    """Replies so far, each of which may be asked for again.

    Parameters
    ----------
    folder, tables, flags, stated
        As `ask_until_agreed` takes them.
    """

    def __init__(
        self, folder: Path, tables: Sequence[Table], flags: Mapping[str, Any], stated: Mapping[str, Target]
    ) -> None:
        self.folder, self.tables, self.replies = folder, list(tables), dict(stated)
        # None asks for the runs to keep, an empty tuple is the reply that there are none.
        self.flags = {**flags, "validate": flags["validate"] or None}
        self.given = [name for name, value in self.flags.items() if value is not None]
        self.former: dict[str, Any] = {}
        self.understood: dict[str, Target] = {}
        self.sensor: Sensor | None = None
        self.former_sensor: Sensor | None = None
        self.before: list[tuple[str, dict[str, Target]]] = []
        """Each option that was asked for, in turn, with the columns that were known before; `COLUMNS` too."""
        self.past: list[Asked] = []
        """Questions on columns that have their replies."""
        self.taken_back: dict[str, Target] = {}
        """Replies on columns that are proposed again."""
        self.changing = ""
        """Option whose earlier reply is being changed; its question has no other before it."""
        self.asked_columns = False
        self.may_be_wrong = False
        """Whether an error may be the fault of a reply, and not of the tables or of flags."""

    def ask(self) -> tuple[Answers, list[PreparedTable]]:
        """Ask for what is not known yet, and return what it all makes of the tables."""
        self.may_be_wrong = False
        for option in FACTS if len(self.tables) > 1 else FACTS[:-1]:
            if self.flags[option] is None:
                reply = ask_fact(option, self.folder, self.tables, self.former, first=not self.before)
                self._take(option, reply)
        counted = tables_in_counts(self.tables, self.replies)
        if self.flags["resolution"] is None and counted:
            self._take("resolution", ask_step(counts_of_a_turn(counted), first=not self.before))
        replies = ask_lacking_columns(
            self.tables, self._answers(), self.past, self.taken_back, first=not self.before and not self.changing
        )
        self._remember_columns()
        self.asked_columns |= replies != self.replies
        self.may_be_wrong, self.replies = self.asked_columns, replies
        prepared = prepare_tables(self.tables, self._answers())
        self.understood = {column: target for one in prepared for column, target in one.targets.items()}
        self.may_be_wrong |= "device" not in self.given
        if self.flags["supply"] is None and lack_supply(prepared):
            self._take("supply", ask_supply(self.former.get("supply")))
        constants = current_constants(prepared)
        if self.flags["torque_constant"] is None and constants:
            self._take(
                "torque_constant", ask_constant(next(iter(constants.values())), self.former.get("torque_constant"))
            )
        answers = self._answers()
        return answers, complete(prepared, answers)

    def take_back(self) -> None:
        """Take the last reply back; the next `ask` asks for it once more."""
        if self.changing:
            # The change is given up: what was replied before holds.
            self.flags[self.changing], self.changing = self.former[self.changing], ""
            return
        self._remember_columns()
        if self.sensor is not None:
            self.former_sensor, self.sensor = self.sensor, None
        elif self.before:
            option, replies = self.before.pop()
            self.taken_back |= self.replies
            self.replies = replies
            if option != COLUMNS:
                self.former[option], self.flags[option] = self.flags[option], None
            elif self.past:
                self.past[-1] = replace(self.past[-1], is_taken_back=True)

    def _remember_columns(self) -> None:
        """Put the columns that have their replies among what was asked: behind the facts, before the drive."""
        first = [one for one in self.before if one[0] in (*FACTS, "resolution")]
        last = [one for one in self.before if one[0] not in (*FACTS, "resolution", COLUMNS)]
        self.before = [*first, *((COLUMNS, one.before) for one in self.past), *last]

    def _take(self, option: str, reply: Any) -> None:
        """Take the reply to a question."""
        self.flags[option] = reply
        if option == self.changing:
            self.changing = ""
        else:
            self.before.append((option, self.replies))

    def ask_sensor(self, answers: Answers, prepared: Sequence[PreparedTable]) -> Answers:
        """Ask for noise and encoder step, once, and return the answers with them."""
        if self.sensor is None:
            again, self.former_sensor = self.former_sensor, None
            self.sensor = ask_sensor(prepared, answers.resolution, again, at_step=again is not None)
        return replace(answers, noise=self.sensor.noise, resolution=self.sensor.step)

    def change(self) -> None:
        """Ask what is to be changed; the next `ask` asks for it. `BACK` leaves all as it is."""
        choices = [
            word for word, option in OPTIONS.items() if option not in self.given and self.flags[option] is not None
        ]
        try:
            choice = ask_what_to_change([*choices, COLUMNS, *([SENSOR] if self.sensor is not None else [])])
            if choice == COLUMNS:
                self.replies = ask_all_columns(self.tables, self.understood, self.replies)
                # What was replied before is no longer the way here.
                self.past = []
                self.before = [(option, self.replies) for option, _ in self.before if option != COLUMNS]
                self.asked_columns = True
            elif choice == SENSOR:
                self.sensor = None
            else:
                option = OPTIONS[choice]
                self.former[option], self.flags[option] = self.flags[option], None
                self.changing = option
        except WentBack:
            return

    def _answers(self) -> Answers:
        flags = {**self.flags, "validate": self.flags["validate"] or ()}
        return answers_of(self.folder, self.tables, flags, self.replies)
