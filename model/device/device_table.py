"""Parse the table of a device file: a parsed TOML table in, a checked `Device` out.

1. Check the table against the JSON Schema.
2. Convert its entries to joints, links and motors, with the checks that a schema cannot express.
3. Check that the control link exists and every joint moves a mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from haptid.model.device import ranges
from haptid.model.device.device import Device, Link
from haptid.model.device.entries import check_moved, joint_of, link_of, motor_of, uncertainty_of, vector_of
from haptid.support.errors import InputError, one_line
from haptid.support.files.json_schema import check_content
from haptid.support.files.place import KeyPath, Place, join_path
from haptid.support.suggestion import did_you_mean

Table = Mapping[str, Any]


def parse_device(table: Table, where: str | Place) -> Device:
    """Parse the table of a device.

    Parameters
    ----------
    table
        Parsed TOML table, or the same keys converted from another format.
    where
        The file, for messages; a `Place` also gives line numbers, or the names of the keys in the converted file.

    Returns
    -------
    Device
        The checked device.

    Raises
    ------
    InputError
        Where the table is wrong; the message names the file and the key at fault.
    """
    place = where if isinstance(where, Place) else Place(file=where, words=key_words)
    check_content(table, place, "a device", ("haptid.model.device", "device.schema.json"))
    table = _make_printable(table)
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


def key_words(path: KeyPath) -> str:
    """Return a key as errors name it.

    Parameters
    ----------
    path
        Keys from the top of the file to the value at fault.

    Returns
    -------
    str
        The path as text; "top level" where it is empty.
    """
    return join_path(path) or "top level"


def _make_printable(value: Any) -> Any:
    """Return the table with every text on one printable line: texts go into XML, HTML, C and pictures."""
    if isinstance(value, str):
        return one_line(value)
    if isinstance(value, Mapping):
        return {key: _make_printable(entry) for key, entry in value.items()}
    return [_make_printable(entry) for entry in value] if isinstance(value, list) else value
