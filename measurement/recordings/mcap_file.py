"""Read an MCAP file: the joint states of a ROS 2 recording, or JSON messages of their shape, in; one run a topic out.

A message has ``name``, ``position`` [rad], ``velocity`` [rad/s] and ``effort`` [N m] of all joints. Joints are numbered
in the order of the names. Its time is that of its header, or of the log where the header has none.
"""

from __future__ import annotations

import contextlib
import io
import json
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.recordings.one_run import Recording, recording_of
from haptid.measurement.tables.layout import refuse_bomb
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError
from haptid.support.installing.extras import need

MESSAGE = "JointState"
"""End of the name of the messages that are read."""
COLUMNS: Mapping[str, str] = {"position": "position_{}_rad", "velocity": "velocity_{}_rad_s", "effort": "torque_{}_Nm"}
NS_PER_S = 1_000_000_000


def read_mcap(path: Path) -> list[Recording]:
    """Read the joint states of a recording.

    Parameters
    ----------
    path
        File that ends in ``.mcap``.

    Returns
    -------
    list of Recording
        One a topic, in the order of the topics' names.

    Raises
    ------
    InputError
        Where the extra is not installed, the file is damaged or unpacks to an absurd size, it holds no joint states, or
        the joints change on the way.
    """
    need("mcap", str(path))
    try:
        said = io.StringIO()
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
        ):  # the library prints what it finds in a damaged schema
            topics = _messages(path)
    except InputError:
        raise
    except Exception as error:  # the library and its decoders raise anything on a damaged file
        got = f"a damaged file ({type(error).__name__})"
        todo = "copy it again, or repair it with mcap recover"
        raise InputError(str(path), expected="a recording in MCAP", got=got, todo=todo) from None
    if not any(topics.values()):
        raise InputError(str(path), expected=f"messages {MESSAGE}", got="none", todo="record the topic of joint states")
    made = []
    for topic, messages in sorted(topics.items()):
        part = topic.strip("/").replace("/", "_") if len(topics) > 1 else ""
        columns, joints = _columns(f"{path}, topic {topic}", messages)
        numbered = ", ".join(f"{number} {joint}" for number, joint in enumerate(joints))
        made.append(recording_of(path, columns, part=part, about=f"topic {topic}, joints {numbered}"))
    return made


def _messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return time [ns] and message of all joint states by topic."""
    from mcap.reader import make_reader  # noqa: PLC0415 (an extra)

    topics: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        refuse_bomb(path, sum(chunk.uncompressed_size for chunk in summary.chunk_indexes) if summary else 0)
        decoders: dict[int, Callable[[bytes], Any]] = {}
        wanted = _topics_of(summary)
        for schema, channel, message in reader.iter_messages(topics=wanted) if wanted != [] else ():
            if schema is None or not schema.name.endswith(MESSAGE):
                continue
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(path, channel.message_encoding, schema)
            decoded = decoders[channel.id](message.data)
            topics[channel.topic].append((_stamp_ns(decoded) or message.log_time, decoded))
    return topics


def _topics_of(summary: Any) -> list[str] | None:
    """Return the topics of joint states, so that pictures beside them are not unpacked; None where nothing says it."""
    if summary is None or not summary.channels:
        return None
    named = {id for id, schema in summary.schemas.items() if schema.name.endswith(MESSAGE)}
    return [channel.topic for channel in summary.channels.values() if channel.schema_id in named]


def _decoder(path: Path, encoding: str, schema: Any) -> Callable[[bytes], Any]:
    if encoding == "json":
        return json.loads
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415 (an extra)

    decoder: Callable[[bytes], Any] | None = DecoderFactory().decoder_for(encoding, schema)
    if decoder is None:
        raise InputError(str(path), expected="messages of ROS 2 or in JSON", got=f"the encoding {encoding!r}")
    return decoder


def _field(message: Any, name: str) -> Any:
    return message.get(name) if isinstance(message, dict) else getattr(message, name, None)


def _stamp_ns(message: Any) -> int:
    """Return the time of a message's header [ns], 0 where it has none."""
    stamp = _field(_field(message, "header"), "stamp")
    nanoseconds = _field(stamp, "nanosec")
    return int(_field(stamp, "sec") or 0) * NS_PER_S + int(nanoseconds or _field(stamp, "nsec") or 0)


def _columns(where: str, messages: list[tuple[int, Any]]) -> tuple[dict[str, Array], list[str]]:
    """Return the columns of a topic's messages, and the names of the joints."""
    first = messages[0]
    joints = [str(name) for name in _field(first[1], "name") or ()]
    # Whole nanoseconds since the first message: seconds since 1970 would lose the last three digits.
    columns: dict[str, Array] = {"time_s": np.array([(time - first[0]) / NS_PER_S for time, _ in messages])}
    for field, form in COLUMNS.items():
        if len(_field(first[1], field) or ()) == 0:
            continue
        rows = np.array(list(_rows(where, messages, field, joints)))
        columns |= {form.format(number): rows[:, number] for number in range(len(joints))}
    return columns, joints


def _rows(where: str, messages: list[tuple[int, Any]], field: str, joints: list[str]) -> Iterator[list[float]]:
    for number, (_, message) in enumerate(messages, start=1):
        names, values = [str(name) for name in _field(message, "name") or ()], _field(message, field)
        if names != joints or values is None or len(values) != len(joints):
            place = f"{where}, message {number}"
            got = f"{len(values or ())} values of {', '.join(names) or 'none'}"
            raise InputError(place, expected=f"a {field} of each of {', '.join(joints)}", got=got)
        yield [float(value) for value in values]
