"""Device files, TOML and URDF, as targets of fuzzing: read, planned as far as is cheap, or refused."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.planning.torque_design import locked_quantities
from tests.fuzz.harness import Target
from tests.model.device.test_urdf_check import GOOD

_BUILT_IN = resources.files("haptid.model.device.built_in")


def read_toml(content: bytes, folder: Path) -> None:
    """Read ``content`` as a device's TOML file and derive the equation of its last joint, locked at home."""
    (folder / "device.toml").write_bytes(content)
    first_steps(load_device(folder / "device.toml"))


def read_urdf(content: bytes, folder: Path) -> None:
    """Read ``content`` as a URDF file and derive the equation of its last joint, locked at home."""
    (folder / "device.urdf").write_bytes(content)
    first_steps(load_device(folder / "device.urdf"))


def first_steps(device: Device) -> None:
    """Do what every command does first with a device: the equation of a joint, and first guesses for a plan."""
    last = len(device.joints) - 1
    locked_quantities(device, last)
    configuration_equations(device, (last,))


NASTY_TOML = (
    b"inertia = { I11 = inf }", b"[[links]]", b'parent = "base"', b"moved_by = { 0 = 1e300 }", b"1e300", b"-1e300",
    b"1e20", b"{ fixed = 0.0 }", b"{ initial = -1 }", b"[-inf, inf]", b"{ 0 = 6 }", b"prismatic = true",
)  # fmt: skip
NASTY_URDF = (
    b'effort="nan"', b'xyz="1e308 1e308 1e308"', b"<mimic joint='one'/>", b"<!ENTITY a 'b'>", b'"0"', b'"-1"',
    b'"1e300"', b'"1e-300"', b'"prismatic"', b'"fixed"', b"<limit/>", b"<inertia/>", b"<mass value='0'/>",
)  # fmt: skip

DEVICES = (
    Target(
        name="device",
        examples=tuple((_BUILT_IN / f"{name}.toml").read_bytes() for name in ("arm6", "freedom6s", "double_pendulum")),
        read=read_toml,
        nasty=NASTY_TOML,
    ),
    Target(
        name="urdf",
        examples=(GOOD.encode(), (_BUILT_IN / "arm6.urdf").read_bytes()),
        read=read_urdf,
        nasty=NASTY_URDF,
    ),
)
