"""Read and check device files: TOML against the JSON Schema, then what a schema cannot say."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
from jsonschema.exceptions import best_match

from haptid.model.device.device import BASE, Device, Guess, Joint, Link, Motor, Vector
from haptid.model.device.link_guesses import Uncertainty, inertial
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.support.errors import InputError, one_line
from haptid.support.files.data import parse_toml
from haptid.support.files.files import is_file, reason_of
from haptid.support.suggestion import did_you_mean

Table = Mapping[str, Any]
Raw = float | Mapping[str, float]
OWN = ("Kp", "Ks", "epos")
"""Parameters of drive and spring that a joint may state; those of friction are its law's."""


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
        from haptid.model.device.urdf import load_urdf  # noqa: PLC0415 (yourdfpy is slow to import and rarely needed)

        return load_urdf(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), expected="a TOML file", got=reason_of(error)) from None
    return parse_device(parse_toml(text, str(path), finite=True), str(path))


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


def parse_device(table: Table, where: str) -> Device:
    """Return the device that a parsed TOML table describes; `where` names it in errors."""
    _check_schema(table, where)
    table = _shown(table)
    joints = tuple(_joint(entry, f"{where}: joints[{j}]") for j, entry in enumerate(table["joints"]))
    uncertainty = Uncertainty(**table.get("uncertainty", {}))
    links: list[Link] = []
    for i, entry in enumerate(table["links"]):
        links.append(_link(entry, f"{where}: links[{i}]", [link.name for link in links], joints, uncertainty))
    motors = tuple(
        _motor(entry, f"{where}: motors[{i}]", len(joints), uncertainty)
        for i, entry in enumerate(table.get("motors", ()))
    )
    control = table.get("control_point", {"link": "", "position": (0.0, 0.0, 0.0)})
    if control["link"] and control["link"] not in {link.name for link in links}:
        raise InputError(where=f"{where}: control_point.link", expected="the name of a link", got=repr(control["link"]))
    _check_moved(joints, links, where)
    return Device(
        name=table["name"],
        title=table["title"],
        gravity=_vector(table.get("gravity", (0.0, 0.0, -9.81))),
        joints=joints,
        links=tuple(links),
        motors=motors,
        control_link=control["link"],
        control_point=_vector(control["position"]),
        assumptions=tuple(table.get("assumptions", ())),
    )


def _shown(value: Any) -> Any:
    """Return the table with every text on one printable line: texts go into XML, HTML, C and pictures."""
    if isinstance(value, str):
        return one_line(value)
    if isinstance(value, Mapping):
        return {key: _shown(entry) for key, entry in value.items()}
    return [_shown(entry) for entry in value] if isinstance(value, list) else value


def _check_schema(table: Table, where: str) -> None:
    schema = json.loads((resources.files("haptid.model.device") / "device.schema.json").read_text(encoding="utf-8"))
    error = best_match(jsonschema.Draft202012Validator(schema).iter_errors(table))
    if error is None:
        return
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path).lstrip(".")
    if error.validator in ("required", "additionalProperties", "dependentRequired"):
        raise InputError(
            where=f"{where}: {key or 'top level'}",
            expected="the keys of device.schema.json",
            got=error.message,
        )
    raise InputError(where=f"{where}: {key}", expected=_expected(error), got=repr(error.instance))


def _expected(error: jsonschema.ValidationError) -> str:
    if error.validator in ("oneOf", "anyOf"):
        return "a number, { initial = …, lower = …, upper = …, std = … } or { fixed = … }"
    return f"{error.validator} {error.validator_value!r}"


def _guess(value: Raw, where: str) -> Guess:
    try:
        if not isinstance(value, Mapping):
            return Guess(initial=float(value))
        if "fixed" in value:
            return Guess(initial=float(value["fixed"]), fixed=True)
        return _full_guess(**value)
    except ValueError as error:
        raise InputError(where, expected="lower <= initial <= upper, std > 0", got=str(error)) from None


def _full_guess(
    *, initial: float, lower: float = -math.inf, upper: float = math.inf, std: float | None = None
) -> Guess:
    return Guess(initial=float(initial), lower=float(lower), upper=float(upper), std=std)


def _joint(entry: Table, where: str) -> Joint:
    lower, upper = entry.get("position_limits", (-math.pi, math.pi))
    if not lower < upper:
        raise InputError(where=f"{where}.position_limits", expected="lower < upper", got=f"[{lower}, {upper}]")
    law = law_named(entry.get("friction", DEFAULT), f"{where}.friction")
    parameters = {}
    for key, value in entry.get("parameters", {}).items():
        place, known = f"{where}.parameters.{key}", (*OWN, *law.ids)
        if key not in known:
            expected = f"a parameter of a joint with {law.id} friction"
            raise InputError(place, expected=expected, got=repr(key), todo=did_you_mean(key, known))
        parameters[key] = _guess(value, place)
    return Joint(
        name=entry["name"],
        transmission=entry.get("transmission", "direct"),
        prismatic=entry.get("prismatic", False),
        friction=law.id,
        parameters=parameters,
        position_limits=(float(lower), float(upper)),
        torque_limit=float(entry.get("torque_limit", math.inf)),
        max_frequency=float(entry.get("max_frequency", math.inf)),
    )


def _ratios(table: Table, where: str, n_joints: int) -> dict[int, Fraction]:
    ratios = {int(key): Fraction(str(value)) for key, value in table.items()}
    for joint in ratios:
        if joint >= n_joints:
            raise InputError(where=f"{where}.{joint}", expected=f"a joint number 0..{n_joints - 1}", got=str(joint))
    return ratios


def _link(entry: Table, where: str, above: list[str], joints: tuple[Joint, ...], uncertainty: Uncertainty) -> Link:
    if entry["name"] in (*above, BASE):
        raise InputError(where=f"{where}.name", expected="a name of its own", got=repr(entry["name"]))
    parent = entry.get("parent", BASE)
    if parent not in (*above, BASE):
        raise InputError(
            where=f"{where}.parent", expected=f"base or a link above ({', '.join(above)})", got=repr(parent)
        )
    motion = entry.get("motion", "revolute")
    moved_by = _ratios(entry.get("moved_by", {}), f"{where}.moved_by", len(joints))
    _check_motion(motion, moved_by, joints, where)
    return Link(
        name=entry["name"],
        title=entry.get("title", ""),
        parent=parent,
        motion=motion,
        origin=_vector(entry.get("origin", (0, 0, 0))),
        rpy=_vector(entry.get("rpy", (0, 0, 0))),
        axis=_axis(entry.get("axis", (0, 0, 1)), f"{where}.axis"),
        moved_by=moved_by,
        inertial=inertial(entry, where, uncertainty, _guess),
    )


def _check_motion(motion: str, moved_by: Mapping[int, Fraction], joints: tuple[Joint, ...], where: str) -> None:
    if (motion == "fixed") != (not moved_by):
        raise InputError(
            where=f"{where}.moved_by",
            expected="joints for a moving link, none for a fixed one",
            got=f"{dict(moved_by)}",
        )
    for joint, ratio in moved_by.items():
        if motion == "revolute" and (ratio.denominator != 1 or joints[joint].prismatic):
            raise InputError(
                where=f"{where}.moved_by.{joint}",
                expected="a whole number times a revolute joint",
                got=str(float(ratio)),
            )
        if motion == "prismatic" and not joints[joint].prismatic:
            raise InputError(
                where=f"{where}.moved_by.{joint}", expected="a joint with prismatic = true", got=f"joint {joint}"
            )


def _check_moved(joints: tuple[Joint, ...], links: list[Link], where: str) -> None:
    for j in range(len(joints)):
        if not any(link.moved_by.get(j) for link in links):
            raise InputError(where=f"{where}: joints[{j}]", expected="a link with this joint in moved_by", got="none")


def _motor(entry: Table, where: str, n_joints: int, uncertainty: Uncertainty) -> Motor:
    guess = uncertainty.rotor_guess(_guess(entry["inertia"], f"{where}.inertia"))
    return Motor(name=entry["name"], inertia=guess, ratios=_ratios(entry["ratios"], f"{where}.ratios", n_joints))


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _axis(values: Sequence[float], where: str) -> Vector:
    x, y, z = _vector(values)
    length = math.hypot(x, y, z)
    if not length > 1e-9:
        raise InputError(where, expected="a direction", got=f"[{x}, {y}, {z}]")
    return x / length, y / length, z / length
