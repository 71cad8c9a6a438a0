"""A further run of a blind case, as its workflow asked for it, added to a copy of its campaign."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import tomli_w

from haptid.support.errors import InputError
from haptid.support.files.files import read_json, write_bytes, write_text
from haptid.virtual_device.recording.campaign import joint_runs
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor

LONGEST = 60.0
"""Longest run that can be asked for [s]."""


def read_label(out: Path, case: str) -> dict[str, Any]:
    """Read what is hidden in one case of a study.

    Parameters
    ----------
    out
        Folder of the study.
    case
        Name of the case.

    Returns
    -------
    dict
        Label of the case, as `studies.hidden.run.make_cases` writes it.

    Raises
    ------
    InputError
        Where the study or the case is not there.
    """
    path = out / "labels.json"
    labels = read_json(path, "the labels of a blind study", ("studies.hidden", "labels.schema.json"))["labels"]
    for label in labels:
        if label["case"] == case:
            return dict(label)
    raise InputError("--extra", expected="a case of the study", got=repr(case))


def cosine_of(request: Mapping[str, Any]) -> Cosine:
    """Return the run that was asked for.

    Parameters
    ----------
    request
        ``amplitude``, ``offset`` [N m], ``frequency`` [rad/s], ``duration`` [s]; perhaps ``end_frequency`` [rad/s],
        None where the frequency is not swept, and ``spacing`` of the rows [s].

    Returns
    -------
    Cosine

    Raises
    ------
    InputError
        Where a frequency is not above 0, or the duration is not between 0 and `LONGEST`.
    """
    end = request.get("end_frequency")
    slowest = request["frequency"] if end is None else min(request["frequency"], end)
    if not (slowest > 0.0 and 0.0 < request["duration"] <= LONGEST):
        expected = f"a frequency above 0 rad/s and up to {LONGEST:g} s"
        raise InputError("the run asked for", expected=expected, got=f"{dict(request)}")
    amplitude, offset = request["amplitude"], request["offset"]
    return Cosine(
        amplitude=amplitude,
        offset=offset,
        frequency=request["frequency"],
        end_frequency=end,
        duration=request["duration"],
        spacing=request.get("spacing", 0.01),
    )


def add_run(out: Path, case: str, request: Mapping[str, Any], folder: Path) -> Path:
    """Copy the campaign of a case and add a run that was asked for, to be fitted.

    Parameters
    ----------
    out
        Folder of the study.
    case
        Name of the case.
    request
        Run as for `cosine_of`; it is made ``repeats`` times, once where that is absent.
    folder
        Folder of the new campaign.

    Returns
    -------
    Path
        The new campaign.toml.

    Raises
    ------
    InputError
        Where the study or the case is not there, or the run is impossible.
    NumericalError
        Where the motion of the joint stops being finite.
    """
    label = read_label(out, case)
    sensor = Sensor(noise=label["noise"], coloured=label["coloured"], correlation_time=label["correlation_time"])
    seed = 1_000_003 + int(case.rpartition("_")[2])
    asked = [cosine_of(request)] * request.get("repeats", 1)
    made = joint_runs(label["joint"], label["base"], asked, effects=label.get("hidden", {}), sensor=sensor, seed=seed)
    shutil.copytree(out / "cases" / case, folder, dirs_exist_ok=True)
    content = tomllib.loads((out / "cases" / case / "campaign.toml").read_text(encoding="utf-8"))
    for run in (replace(table, file=f"asked_{table.file}") for table in made):
        write_bytes(folder / run.file, run.encoded())
        content["runs"].append(run.entry(6 if label["device"] == "freedom6s" else 1))
    return write_text(folder / "campaign.toml", tomli_w.dumps(content))
