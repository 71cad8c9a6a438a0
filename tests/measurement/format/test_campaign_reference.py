"""The reference of campaign.toml holds every key of the schema, and its examples are read."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from docs.from_code import campaign_file
from docs.from_code.device_file import EXAMPLES
from haptid.measurement.format.columns import KNOWN
from haptid.measurement.format.reading import read_campaign

LISTED = campaign_file.list_keys()
ROWS = [(kind, row[0], row[4]) for kind in campaign_file.KEYS for row in LISTED[kind]]


def test_the_page_is_that_of_the_schema():
    page = campaign_file.PAGE.read_text(encoding="utf-8")
    assert page == campaign_file.with_tables(page), "run python -m docs.generate"


@pytest.mark.parametrize("kind", campaign_file.KEYS)
def test_every_key_is_listed(kind: str):
    assert {row[0] for row in LISTED[kind]} == set(campaign_file.KEYS[kind])


@pytest.mark.parametrize(("kind", "key", "example"), ROWS)
def test_an_example_is_what_the_key_accepts(kind: str, key: str, example: str):
    value = tomllib.loads(f"value = {example}")["value"]
    assert campaign_file.KEYS[kind][key].accepts(value)


@pytest.mark.parametrize(("kind", "key", "default"), [(kind, row[0], row[3]) for kind, row in
                         ((k, r) for k in campaign_file.KEYS for r in LISTED[k])])  # fmt: skip
def test_what_is_required_is_said_to_be(kind: str, key: str, default: str):
    assert (default == "required") == campaign_file.KEYS[kind][key].required


@pytest.mark.parametrize("column", [row[0] for row in LISTED["COLUMNS"]])
def test_a_column_is_known(column: str):
    assert KNOWN.fullmatch(column.replace("<j>", "2"))


def write_table(path: Path, joints: list[int]) -> None:
    t = np.arange(0.0, 2.0, 0.01)
    columns = {"time_s": t}
    for j in joints:
        columns |= {f"torque_{j}_Nm": 0.1 * np.cos(3 * t), f"position_{j}_rad": 0.2 * np.sin(3 * t + j)}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")


def test_the_example_is_read(tmp_path: Path):
    for name in ("campaign.toml", "two_joints.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)
    for run in tomllib.loads((EXAMPLES / "campaign.toml").read_text(encoding="utf-8"))["runs"]:
        write_table(tmp_path / run["file"], run["free_joints"])
    campaign = read_campaign(tmp_path)
    assert [run.use for run in campaign.runs] == ["fit", "fit", "validate", "excluded", "validate"]
    assert campaign.runs[1].resolution[0] == 3e-5
