"""Recordings of other programs as targets of fuzzing: MATLAB, BAM, LeRobot, MCAP and rosbags.

A reader whose package is not installed is left out.
"""

from __future__ import annotations

import importlib.util
import io
import json
import tempfile
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd
from scipy.io import savemat

from haptid.measurement.recordings import bam_log, lerobot, mat_file, mcap_file, rosbag
from haptid.support.processes.pool import Pool
from tests.fuzz.harness import Target

ROWS = 12
T = np.arange(ROWS) * 0.01
TORQUE, POSITION = np.cos(3.0 * T), np.sin(3.0 * T)
FEW = 200
"""Inputs of a test where a reader takes milliseconds; `tests.fuzz.run` gives it more."""


class StandingPool:
    """Stands for the process that `read_mat` starts for each file: one for all, and a new one after it has died."""

    pool: Pool | None = None

    def __init__(self, _workers: int) -> None:
        """Take the standing process."""

    def __enter__(self) -> StandingPool:
        """Return what takes calls."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the process for the next file."""

    @classmethod
    def end(cls) -> None:
        """End the standing process: at its own end a worker waits for it, and it would wait for more files."""
        if cls.pool is not None:
            cls.pool.shutdown()
            cls.pool = None

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Call a function in the standing process."""
        if StandingPool.pool is None:
            StandingPool.pool = Pool(1)
        called = StandingPool.pool.submit(function, *arguments)
        if isinstance(called.exception(), BrokenProcessPool):
            StandingPool.pool = None
        return called


def read_mat(content: bytes, folder: Path) -> None:
    """Read ``content`` as a MATLAB file."""
    path = folder / "a.mat"
    path.write_bytes(content)
    with patch.object(mat_file, "Pool", StandingPool):
        mat_file.read_mat(path)


def reader_of(read: Callable[[Path], object], suffix: str) -> Callable[[bytes, Path], None]:
    """Return a target's function for a reader of one file."""

    def read_content(content: bytes, folder: Path) -> None:
        path = folder / f"a{suffix}"
        path.write_bytes(content)
        read(path)

    return read_content


def _read_data_set(folder: Path, info: bytes, frames: bytes) -> None:
    (folder / "meta").mkdir()
    (folder / "data").mkdir()
    (folder / "meta" / "info.json").write_bytes(info)
    (folder / "data" / "episode_0.parquet").write_bytes(frames)
    lerobot.read_data_set(folder)


def _mat(**options: Any) -> bytes:
    stream = io.BytesIO()
    matrix = np.column_stack([POSITION, TORQUE])
    savemat(stream, {"t": T, "log": {"q": POSITION, "tau": TORQUE}, "m": matrix, "note": "arm"}, **options)
    return stream.getvalue()


def _mat73() -> bytes:
    import h5py  # noqa: PLC0415 (an extra)

    stream = io.BytesIO()
    with h5py.File(stream, "w", userblock_size=512) as file:
        file["t"] = T[None, :]
        file.create_dataset("log/q", data=POSITION[None, :], compression="gzip")
        file["log/m"] = np.stack([POSITION, TORQUE])
        file["log"].attrs["MATLAB_class"] = np.bytes_(b"struct")
        file["t"].attrs["MATLAB_class"] = np.bytes_(b"double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124, b" ") + b"\x00\x02IM"
    return head + stream.getvalue()[len(head) :]


def _bam() -> bytes:
    entries = [
        {"timestamp": t, "position": q, "speed": 0.0, "goal_position": q, "input_volts": 7.4, "temp": 30, "load": 65000,
         "torque_enable": True}
        for t, q in zip(T.tolist(), POSITION.tolist(), strict=True)
    ]  # fmt: skip
    return json.dumps(
        {"motor": "xl330", "kp": 400, "vin": 7.5, "mass": 0.1, "length": 0.1, "entries": entries}
    ).encode()


INFO = json.dumps({"features": {"observation.state": {"names": {"motors": ["elbow", "wrist"]}}}}).encode()


def _frames() -> bytes:
    stream = io.BytesIO()
    state = [np.array([q, 2 * q]) for q in POSITION]
    columns = {"timestamp": T, "episode_index": [0] * ROWS, "observation.state": state, "action": TORQUE}
    pd.DataFrame(columns).to_parquet(stream, index=False)
    return stream.getvalue()


def _state() -> dict[str, Any]:
    return {"name": ["waist", "elbow"], "velocity": []}


def _mcap_json() -> bytes:
    from mcap.writer import Writer  # noqa: PLC0415 (an extra)

    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    channel = writer.register_channel("/arm", "json", writer.register_schema("JointState", "jsonschema", b"{}"))
    for row, at in enumerate(T):
        data = json.dumps({**_state(), "position": [0.0, POSITION[row]], "effort": [0.0, TORQUE[row]]}).encode()
        writer.add_message(channel, log_time=round(1e9 * at), publish_time=round(1e9 * at), data=data)
    writer.finish()
    return stream.getvalue()


def _mcap_ros() -> bytes:
    from mcap_ros2.writer import Writer  # noqa: PLC0415 (an extra)

    stream = io.BytesIO()
    writer = Writer(stream)
    definition = "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    schema = writer.register_msgdef("sensor_msgs/msg/JointState", definition)
    for row, at in enumerate(T):
        message = {**_state(), "position": [0.0, POSITION[row]], "effort": [0.0, TORQUE[row]]}
        writer.write_message("/arm", schema, message, log_time=round(1e9 * at), publish_time=round(1e9 * at))
    writer.finish()
    return stream.getvalue()


def _bag(version: int, compression: str = "") -> bytes:
    from rosbags import rosbag1, rosbag2  # noqa: PLC0415 (an extra)
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    State, Header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    Time = store.types["builtin_interfaces/msg/Time"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.bag"
        writer: Any = rosbag1.Writer(path) if version == 1 else rosbag2.Writer(path, version=8)
        if compression:
            writer.set_compression(rosbag1.Writer.CompressionFormat[compression])
        serialize = store.serialize_ros1 if version == 1 else store.serialize_cdr
        with writer:
            connection = writer.add_connection("/arm", State.__msgtype__, typestore=store)
            for row, at in enumerate(T):
                first = {"seq": row} if version == 1 else {}
                header = Header(**first, stamp=Time(sec=1, nanosec=round(1e9 * at)), frame_id="")
                motion = {"position": np.array([0.0, POSITION[row]]), "velocity": np.zeros(0)}
                state = State(header=header, name=["a", "b"], **motion, effort=np.array([0.0, TORQUE[row]]))
                writer.write(connection, round(1e9 * at), serialize(state, State.__msgtype__))
        return (path if version == 1 else next(path.glob("*.db3"))).read_bytes()


def _targets() -> list[Target]:
    keys = (b"timestamp", b"position", b"entries", b"names", b"features", b"data")
    made = [
        Target(name="mat", examples=(_mat(), _mat(do_compression=True)), read=read_mat,
               tested=FEW),
        Target(name="bam_log", examples=(_bam(),), read=reader_of(bam_log.read_bam_log, ".json"), nasty=keys,
               tested=FEW),
    ]  # fmt: skip
    if importlib.util.find_spec("h5py"):
        made.append(Target(name="mat_hdf5", examples=(_mat73(),), read=read_mat, tested=FEW))
    if importlib.util.find_spec("pyarrow"):
        frames = _frames()
        made += [
            Target(name="lerobot_info", examples=(INFO,), read=lambda content, at: _read_data_set(at, content, frames),
                   nasty=keys, tested=FEW),
            Target(name="lerobot", examples=(frames,), read=lambda content, at: _read_data_set(at, INFO, content),
                   tested=FEW),
        ]  # fmt: skip
    if importlib.util.find_spec("mcap_ros2"):
        examples = (_mcap_json(), _mcap_ros())
        made.append(Target(name="mcap", examples=examples, read=reader_of(mcap_file.read_mcap, ".mcap"), tested=FEW))
    if importlib.util.find_spec("rosbags"):
        first, second = reader_of(rosbag.read_rosbag, ".bag"), reader_of(rosbag.read_rosbag, ".db3")
        made += [
            Target(name="rosbag1", examples=(_bag(1), _bag(1, "BZ2"), _bag(1, "LZ4")), read=first, tested=FEW),
            Target(name="rosbag2", examples=(_bag(2),), read=second, tested=FEW),
        ]
    return made


RECORDINGS = _targets()
