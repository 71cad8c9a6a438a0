"""Read and check device files: TOML against the JSON Schema, then what a schema cannot say."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from haptid.model.device import ranges
from haptid.model.device.device import Device, Link
from haptid.model.device.entries import check_moved, joint_of, link_of, motor_of, uncertainty_of, vector_of
from haptid.support.errors import InputError, one_line
from haptid.support.files.data import parse_toml
from haptid.support.files.files import is_file, reason_of
from haptid.support.files.json_schema import check_content
from haptid.support.files.place import KeyPath, Place, dotted, key_lines
from haptid.support.suggestion import did_you_mean

Table = Mapping[str, Any]


def load_device(name: str | Path, folder: Path | None = None) -> Device:
    """Return the device of a built-in name or of a TOML or URDF file.

    Parameters
    ----------
    name
        ``freedom6s`` (built in), or a path; a relative path is looked for in `folder` first.
    folder
        Folder of the file that names the device, as of a campaign.

    Raises
    ------
    InputError
        Names the file and the key at fault.
    """
    path = _find(str(name), folder)
    if path.suffix == ".urdf":
        from haptid.model.device.urdf import load_urdf  # noqa: PLC0415 (it makes a table for `parse_device`)

        return load_urdf(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), expected="a TOML file", got=reason_of(error)) from None
    data = parse_toml(text, str(path), finite=True)
    return parse_device(data, Place(file=str(path), lines=key_lines(text), words=_key))


def builtin_devices() -> tuple[str, ...]:
    """Return the names of the devices that come with the package."""
    files = (Path(entry.name) for entry in resources.files("haptid.model.device.built_in").iterdir())
    return tuple(sorted(file.stem for file in files if file.suffix == ".toml"))


def _find(name: str, folder: Path | None) -> Path:
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


def parse_device(table: Table, where: str | Place) -> Device:
    """Return the device that a parsed TOML table describes.

    Parameters
    ----------
    where
        The file; as a `Place` it names lines too, or what the table's keys are called in the file that was converted.

    Raises
    ------
    InputError
        Names the file and the key at fault.
    """
    place = where if isinstance(where, Place) else Place(file=where, words=_key)
    check_content(table, place, "a device", ("haptid.model.device", "device.schema.json"))
    table = _shown(table)
    joints = tuple(joint_of(entry, place.at("joints", j)) for j, entry in enumerate(table["joints"]))
    uncertainty = uncertainty_of(table.get("uncertainty", {}), place.at("uncertainty"))
    links: list[Link] = []
    for i, entry in enumerate(table["links"]):
        links.append(link_of(entry, place.at("links", i), [link.name for link in links], joints, uncertainty))
    motors = tuple(
        motor_of(entry, place.at("motors", i), len(joints), uncertainty)
        for i, entry in enumerate(table.get("motors", ()))
    )
    control, at = table.get("control_point", {"link": "", "position": (0.0, 0.0, 0.0)}), place.at("control_point")
    names = [link.name for link in links]
    if control["link"] and control["link"] not in names:
        todo = did_you_mean(control["link"], names)
        raise InputError(str(at.at("link")), expected="the name of a link", got=repr(control["link"]), todo=todo)
    check_moved(joints, links, motors, place)
    return Device(
        name=table["name"],
        title=table["title"],
        gravity=vector_of(table.get("gravity", (0.0, 0.0, -9.81)), ranges.GRAVITY, place.at("gravity")),
        joints=joints,
        links=tuple(links),
        motors=motors,
        control_link=control["link"],
        control_point=vector_of(control["position"], ranges.LENGTH, at.at("position")),
        assumptions=tuple(table.get("assumptions", ())),
    )


def _key(path: KeyPath) -> str:
    return dotted(path) or "top level"


def _shown(value: Any) -> Any:
    """Return the table with every text on one printable line: texts go into XML, HTML, C and pictures."""
    if isinstance(value, str):
        return one_line(value)
    if isinstance(value, Mapping):
        return {key: _shown(entry) for key, entry in value.items()}
    return [_shown(entry) for entry in value] if isinstance(value, list) else value
