"""Device files, TOML and URDF, as targets of fuzzing."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from haptid.model.device.reader import load_device
from tests.fuzz.harness import Target
from tests.model.test_urdf_check import GOOD

_BUILT_IN = resources.files("haptid.model.device.built_in")


def read_toml(content: bytes, folder: Path) -> None:
    """Read ``content`` as a device's TOML file."""
    (folder / "device.toml").write_bytes(content)
    load_device(folder / "device.toml")


def read_urdf(content: bytes, folder: Path) -> None:
    """Read ``content`` as a URDF file."""
    (folder / "device.urdf").write_bytes(content)
    load_device(folder / "device.urdf")


DEVICES = (
    Target(
        name="device",
        examples=((_BUILT_IN / "arm6.toml").read_bytes(), (_BUILT_IN / "freedom6s.toml").read_bytes()),
        read=read_toml,
        nasty=(b"inertia = { I11 = inf }", b"[[links]]", b'parent = "base"', b"moved_by = { 0 = 1e300 }"),
    ),
    Target(
        name="urdf",
        examples=(GOOD.encode(),),
        read=read_urdf,
        nasty=(b'effort="nan"', b'xyz="1e308 1e308 1e308"', b"<mimic joint='one'/>", b"<!ENTITY a 'b'>"),
    ),
)
