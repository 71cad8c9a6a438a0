"""The reference of device files is that of the schema, and everything in it is read."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
from click.testing import CliRunner

from docs.from_code import device_file
from haptid.model.device.device_table import parse_device
from haptid.model.device.reader import load_device
from haptid.model.plan import main as plan
from haptid.model.thresholds import THRESHOLDS

OBJECTS = device_file.objects(device_file.schema())
KEYS = [(kind, key) for kind, part in OBJECTS.items() for key in part["properties"]]
WITHOUT_EXAMPLE = {"joints", "links", "motors"}  # the whole file is theirs
FILES = {suffix: device_file.EXAMPLES / f"two_joints.{suffix}" for suffix in ("toml", "urdf")}


def complete() -> dict[str, Any]:
    return tomllib.loads(FILES["toml"].read_text(encoding="utf-8"))


def entry_of(data: dict[str, Any], kind: str) -> dict[str, Any]:
    """Return the table of the complete example in which a key of this kind belongs."""
    entry = data if kind == "top level" else data[kind]
    return entry[-1] if isinstance(entry, list) else entry


def test_the_page_is_that_of_the_schema():
    page = device_file.PAGE.read_text(encoding="utf-8")
    assert page == device_file.with_tables(page), "run python -m docs.generate"


@pytest.mark.parametrize(("kind", "key"), KEYS)
def test_every_key_is_described_and_its_example_is_read(kind: str, key: str):
    rule = OBJECTS[kind]["properties"][key]
    assert rule["description"]
    if key in WITHOUT_EXAMPLE:
        return
    data = complete()
    (example,) = rule["examples"]
    entry_of(data, kind)[key] = tomllib.loads(f"{key} = {device_file.as_toml(example)}")[key]
    assert len(parse_device(data, "example.toml").joints) == 2


@pytest.mark.parametrize(("kind", "key"), [(k, key) for k, key in KEYS if "default" in OBJECTS[k]["properties"][key]])
def test_a_default_is_what_holds_without_the_key(kind: str, key: str):
    stated, silent = complete(), complete()
    entry_of(stated, kind)[key] = OBJECTS[kind]["properties"][key]["default"]
    entry_of(silent, kind).pop(key, None)
    assert parse_device(stated, "example.toml") == parse_device(silent, "example.toml")


def test_the_page_states_the_margins_of_the_code():
    page = " ".join(device_file.PAGE.read_text(encoding="utf-8").split())
    assert f"by a factor of {THRESHOLDS.largest_factor_beyond_range:g}" in page
    assert f"`Fs` {THRESHOLDS.stiction_over_coulomb:g} times as large" in page


def test_the_example_is_planned(tmp_path):
    done = CliRunner().invoke(plan, [str(FILES["toml"]), "--out", str(tmp_path), "--quiet"])
    assert done.exit_code == 0, done.output
    assert "no torque keeps it" not in done.output


def test_the_urdf_example_is_the_same_device_without_motor_and_control_point():
    toml, urdf = load_device(FILES["toml"]), load_device(FILES["urdf"])
    assert [j.position_limits for j in urdf.joints] == [j.position_limits for j in toml.joints]
    assert [j.torque_limit for j in urdf.joints] == [j.torque_limit for j in toml.joints]
    for id in ("Kp", "sigma2", "Fc", "Fs"):
        first = [[j.parameters[id].initial for j in device.joints] for device in (urdf, toml)]
        assert first[0] == pytest.approx(first[1])
    for ours, theirs in zip(toml.links, urdf.links, strict=True):
        assert ours.moved_by == theirs.moved_by
        assert ours.axis == theirs.axis
        assert ours.origin == theirs.origin
        assert ours.inertial.initial == pytest.approx(theirs.inertial.initial)
    assert urdf.control_link == "head"
