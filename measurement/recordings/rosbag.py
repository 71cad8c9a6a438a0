"""Read a rosbag: the joint states of a ROS 1 bag, or of a ROS 2 bag in SQLite, in; one run a topic out."""

from __future__ import annotations

import bz2
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from haptid.measurement.recordings.joint_states import MESSAGE, recordings_of_topics, stamp_ns
from haptid.measurement.recordings.one_run import Recording
from haptid.measurement.tables.damage import damage_in_one_line
from haptid.measurement.tables.layout import refuse_bomb
from haptid.support.installing.extras import need

PIECE_BYTES = 1 << 20
TODO = (
    "copy it again; rosbag reindex or ros2 bag reindex repairs it, and ros2 bag convert unpacks one that is compressed"
)


def read_rosbag(path: Path) -> list[Recording]:
    """Read the joint states of a bag.

    Parameters
    ----------
    path
        File that ends in ``.bag`` (ROS 1) or ``.db3`` (ROS 2); of the latter ``metadata.yaml`` is not needed.

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
    need("rosbags", str(path))
    with damage_in_one_line(path, "a bag of ROS", TODO):
        topics = _messages(path)
    return recordings_of_topics(path, topics)


def _messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return time [ns] and message of all joint states by topic."""
    from rosbags.highlevel import AnyReader  # noqa: PLC0415 (an extra)
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    topics: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    # Older bags of ROS 2 do not define their messages; a joint state is the same in all its versions.
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for chunk in () if reader.is2 else _unpacked_bytes(path, reader.readers[0]):
            refuse_bomb(path, chunk)
        wanted = [one for one in reader.connections if one.msgtype.endswith(MESSAGE)]
        for connection, time, raw in reader.messages(wanted) if wanted else ():
            message = reader.deserialize(raw, connection.msgtype)
            topics[connection.topic].append((stamp_ns(message) or time, message))
    return topics


def _unpacked_bytes(path: Path, reader: Any) -> Iterator[int]:
    """Yield how many bytes the chunks of a ROS 1 bag unpack to, while they are unpacked piece by piece."""
    from lz4.frame import LZ4FrameDecompressor  # noqa: PLC0415 (comes with that extra)
    from lz4.frame import decompress as unpack_lz4  # noqa: PLC0415

    packers = {bz2.decompress: bz2.BZ2Decompressor, unpack_lz4: LZ4FrameDecompressor}
    unpacked = 0
    with path.open("rb") as stream:
        for chunk in reader.chunks.values():
            if chunk.decompressor not in packers:
                continue
            stream.seek(chunk.datapos)
            unpacker, packed = packers[chunk.decompressor](), stream.read(chunk.datasize)
            while not unpacker.eof:
                piece = unpacker.decompress(packed, max_length=PIECE_BYTES)
                unpacked += len(piece)
                yield unpacked
                if unpacker.needs_input and not piece:  # it ends too soon: said by whoever reads the file whole
                    break
                packed = b""
