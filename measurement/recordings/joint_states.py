"""Joint states of ROS: decoded messages by topic in, one run a topic out.

A message has ``name``, ``position`` [rad], ``velocity`` [rad/s] and ``effort`` [N m] of its joints, in any order.
Messages of other joints on one topic, as of an arm and its gripper, are runs of their own. Its time is that of its
header, or of the log where the header has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from haptid.measurement.recordings.one_run import Recording, recording_of
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

MESSAGE = "JointState"
"""End of the name of the messages that are read."""
COLUMNS: Mapping[str, str] = {"position": "position_{}_rad", "velocity": "velocity_{}_rad_s", "effort": "torque_{}_Nm"}
NS_PER_S = 1_000_000_000
Part = tuple[str, tuple[str, ...], list[tuple[int, Any]]]
"""Topic, joints, and their messages with times [ns]."""


def recordings_of_topics(path: Path, topics: Mapping[str, list[tuple[int, Any]]]) -> list[Recording]:
    """Return the runs of a recording.

    Parameters
    ----------
    path
        File of the recording.
    topics
        Time [ns] and message of all joint states by topic.

    Returns
    -------
    list of Recording
        One for each set of joints of a topic that has positions and efforts, in the order of the topics' names. The
        first says what was left out.

    Raises
    ------
    InputError
        Where there are no messages, or too few of them, or none with positions and efforts.
    """
    if not any(topics.values()):
        raise InputError(str(path), expected=f"messages {MESSAGE}", got="none", todo="record the topic of joint states")
    parts = [(topic, *part) for topic, messages in sorted(topics.items()) for part in _parts(messages)]
    kept, left = list[Part](), list[str]()
    for topic, joints, messages in parts:
        if _holds("effort", messages) and _holds("position", messages):
            kept.append((topic, joints, messages))
        else:
            left.append(f"{topic} of {', '.join(joints) or 'no joint'}")
    if not kept:
        _refuse_parts(path, parts)
    made: list[Recording] = []
    for topic, joints, messages in kept:
        name = topic.strip("/").replace("/", "_") if len(topics) > 1 else ""
        several = sum(other == topic for other, *_ in kept) > 1
        part = "_".join(word for word in (name, joints[0] if several else "") if word)
        columns = _columns(f"{path}, topic {topic}", messages, joints)
        about = f"topic {topic}"
        about += f"; without positions and efforts and left out: {'; '.join(left)}" if left and not made else ""
        made.append(recording_of(path, columns, part=part, about=about, joints=joints))
    return made


def _holds(field: str, messages: list[tuple[int, Any]]) -> bool:
    """Whether messages hold numbers of a field."""
    values = (value for _, message in messages for value in _elements(message, field))
    return any(not isinstance(value, float) or value == value for value in values)  # noqa: PLR0124 (NaN is not)


def _refuse_parts(path: Path, parts: list[Part]) -> NoReturn:
    """Refuse a recording in which no joint has positions and efforts on one topic."""
    told = {
        field: [topic for topic, _, messages in parts if _holds(field, messages)] for field in ("position", "effort")
    }
    got = ", ".join(f"{field}s of {' and '.join(dict.fromkeys(topics)) or 'none'}" for field, topics in told.items())
    todo = (
        "write both to one table, at the times of the positions"
        if all(told.values())
        else "record the torque as effort; a free swing is a table of positions with a torque of zeros"
    )
    raise InputError(str(path), expected="positions and efforts of joints on one topic", got=got, todo=todo)


def _parts(messages: list[tuple[int, Any]]) -> Iterator[tuple[tuple[str, ...], list[tuple[int, Any]]]]:
    """Yield the messages of each set of joints, with the joints in the order of its first message."""
    found: dict[frozenset[str], tuple[tuple[str, ...], list[tuple[int, Any]]]] = {}
    for time, message in messages:
        joints = tuple(str(name) for name in _elements(message, "name"))
        found.setdefault(frozenset(joints), (joints, []))[1].append((time, message))
    yield from found.values()


def _field(message: Any, name: str) -> Any:
    return message.get(name) if isinstance(message, dict) else getattr(message, name, None)


def _elements(message: Any, name: str) -> Any:
    """Return the elements of a list or an array; none of anything else, which JSON may hold."""
    values = _field(message, name)
    return values if isinstance(values, list | tuple | np.ndarray) else ()


def stamp_ns(message: Any) -> int:
    """Return the time of a message's header.

    Parameters
    ----------
    message
        Message of a library, or a table of JSON.

    Returns
    -------
    int
        Time [ns], 0 where there is none.
    """
    stamp = _field(_field(message, "header"), "stamp")
    nanoseconds = _field(stamp, "nanosec")
    return int(_field(stamp, "sec") or 0) * NS_PER_S + int(nanoseconds or _field(stamp, "nsec") or 0)


def _columns(where: str, messages: list[tuple[int, Any]], joints: tuple[str, ...]) -> dict[str, Array]:
    """Return the columns of messages of the same joints, numbered in the order of ``joints``."""
    first = messages[0]
    # Whole nanoseconds since the first message: seconds since 1970 would lose the last three digits.
    columns: dict[str, Array] = {"time_s": np.array([(time - first[0]) / NS_PER_S for time, _ in messages])}
    for field, form in COLUMNS.items():
        if len(_elements(first[1], field)) == 0:
            continue
        rows = np.array(list(_rows(where, messages, field, joints)))
        columns |= {form.format(number): rows[:, number] for number in range(len(joints))}
    return columns


def _rows(where: str, messages: list[tuple[int, Any]], field: str, joints: tuple[str, ...]) -> Iterator[list[float]]:
    for number, (_, message) in enumerate(messages, start=1):
        names, values = [str(name) for name in _elements(message, "name")], _elements(message, field)
        place = f"{where}, message {number}"
        if len(values) != len(joints) or len(names) != len(joints):
            got = f"{len(values)} values of {', '.join(names) or 'none'}"
            raise InputError(place, expected=f"a {field} of each of {', '.join(joints)}", got=got)
        try:
            of = dict(zip(names, map(float, values), strict=True))
        except (TypeError, ValueError, OverflowError):  # JSON holds anything
            raise InputError(place, expected=f"numbers as {field}", got=repr(list(values))) from None
        yield [of[joint] for joint in joints]
