"""Read an MCAP file: joint states of a ROS 2 recording, or JSON messages of their shape, in; one run a topic out."""

from __future__ import annotations

import contextlib
import io
import json
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from haptid.measurement.recordings.joint_states import MESSAGE, recordings_of_topics, stamp_ns
from haptid.measurement.recordings.one_run import Recording
from haptid.measurement.tables.damage import damage_in_one_line
from haptid.measurement.tables.layout import refuse_bomb
from haptid.support.errors import InputError
from haptid.support.installing.extras import need


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
    said = io.StringIO()
    with (
        damage_in_one_line(path, "a recording in MCAP", "copy it again, or repair it with mcap recover"),
        contextlib.redirect_stdout(said),  # the library prints what it finds in a damaged schema
        contextlib.redirect_stderr(said),
    ):
        topics = _messages(path)
    return recordings_of_topics(path, topics)


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
            topics[channel.topic].append((stamp_ns(decoded) or message.log_time, decoded))
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
