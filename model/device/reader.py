"""Find and read device files: a name or path in, a checked `Device` out.

The suffix chooses the reader, TOML or URDF; built-in devices are found by name.
"""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from haptid.model.device.device import Device
from haptid.model.device.device_table import key_words, parse_device
from haptid.model.device.urdf import load_urdf
from haptid.support.errors import InputError
from haptid.support.files.data import parse_toml
from haptid.support.files.files import is_file, reason_of
from haptid.support.files.place import Place, key_lines


def load_device(name: str | Path, folder: Path | None = None) -> Device:
    """Load a built-in device, or a device from a TOML or URDF file.

    Parameters
    ----------
    name
        ``freedom6s`` (built in), or a path; a relative path is looked for in `folder` first.
    folder
        Folder of the file that names the device, as of a campaign.

    Returns
    -------
    Device
        The checked device.

    Raises
    ------
    InputError
        Where the file is missing or wrong; the message names the file and the key at fault.
    """
    path = _find(str(name), folder)
    if path.suffix == ".urdf":
        return load_urdf(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), expected="a TOML file", got=reason_of(error)) from None
    data = parse_toml(text, str(path), finite=True)
    return parse_device(data, Place(file=str(path), lines=key_lines(text), words=key_words))


def builtin_devices() -> tuple[str, ...]:
    """List the devices that come with the package.

    Returns
    -------
    tuple of str
        Names in alphabetical order.
    """
    files = (Path(entry.name) for entry in resources.files("haptid.model.device.built_in").iterdir())
    return tuple(sorted(file.stem for file in files if file.suffix == ".toml"))


def _find(name: str, folder: Path | None) -> Path:
    # a user's file goes before a built-in device of the same name
    candidates = [*([folder / name] if folder else []), Path(name)]
    for path in candidates:
        if is_file(path):
            return path
    builtin = Path(str(resources.files("haptid.model.device.built_in"))) / (
        name if Path(name).suffix else f"{name}.toml"
    )
    if Path(name).name == name and builtin.is_file():
        return builtin
    known = ", ".join(builtin_devices())
    raise InputError(
        where=f"device {name!r}", expected=f"one of {known}, or the path of a .toml or .urdf file", got="no such file"
    )
