"""Write a campaign: ``campaign.toml`` and one table per run, as `measurement.format.reading` reads them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import tomli_w

from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.support.errors import InputError
from haptid.support.files.files import write_bytes, write_text
from haptid.support.installing.extras import need


def run_frame(run: Run) -> pd.DataFrame:
    """Return the table of a run.

    Parameters
    ----------
    run
        Run of any use.

    Returns
    -------
    DataFrame
        ``time_s`` as it was recorded, torque, position and velocity of each free joint, then the extra columns.
    """
    columns: dict[str, Any] = {"time_s": run.t + run.start_time}
    for k, (joint, slides) in enumerate(zip(run.free_joints, run.prismatic, strict=True)):
        unit = "m" if slides else "rad"
        columns[f"force_{joint}_N" if slides else f"torque_{joint}_Nm"] = run.u[:, k]
        columns[f"position_{joint}_{unit}"] = run.y[:, k]
        if run.v is not None:
            columns[f"velocity_{joint}_{unit}_s"] = run.v[:, k]
    return pd.DataFrame({**columns, **run.extra})


def write_table(path: Path, frame: pd.DataFrame) -> None:
    """Write a table as CSV, gzipped CSV (``.gz``) or Parquet (``.parquet``); numbers keep their last bit.

    Parameters
    ----------
    path
        File to write; its suffix gives the format.
    frame
        Columns by their names in the campaign format.

    Raises
    ------
    InputError, WritingError
        Where the extra for Parquet is not installed, and as `write_bytes`.
    """
    stream = io.BytesIO()
    if path.suffix == ".parquet":
        need("parquet", str(path))
        frame.to_parquet(stream, index=False)
    else:
        # Without the date of writing, the same table gives the same bytes.
        packing = {"method": "gzip", "mtime": 0} if path.suffix == ".gz" else None
        frame.to_csv(stream, index=False, compression=packing, lineterminator="\n")
    write_bytes(path, stream.getvalue())


def write_campaign(campaign: Campaign, folder: Path) -> Path:
    """Write a campaign that `read_campaign` reads.

    Parameters
    ----------
    campaign
        Campaign with any runs.
    folder
        New or empty folder.

    Returns
    -------
    Path
        ``folder``.

    Raises
    ------
    InputError
        Where ``folder`` holds anything.

    Notes
    -----
    Noise and resolution of the sensor are written per joint, as the first run has them that frees the joint.
    """
    refuse_overwrite(folder)
    for run in campaign.runs:
        write_table(folder / run.file, run_frame(run))
    write_text(folder / "campaign.toml", tomli_w.dumps(description(campaign)))
    return folder


def refuse_overwrite(folder: Path) -> None:
    """Refuse a folder that is a file or holds anything, so that no result of the user is lost.

    Parameters
    ----------
    folder
        Folder to write to; it need not exist.

    Raises
    ------
    InputError
        With the remedy.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        todo = "name another folder with --out"
        raise InputError(str(folder), expected="a new or empty folder", got="one with content", todo=todo)


def description(campaign: Campaign) -> dict[str, Any]:
    """Return the content of ``campaign.toml``.

    Parameters
    ----------
    campaign
        Campaign with any runs.

    Returns
    -------
    dict
        Tables ``campaign``, ``joint`` (where something is stated) and ``runs``, and the extra ones, for `tomli_w`.
    """
    head = {"title": campaign.title, "device": campaign.device, "measured": campaign.measured, "hold": campaign.hold}
    loose = {key: value for key, value in campaign.extra.items() if not isinstance(value, dict)}
    tables = {key: value for key, value in campaign.extra.items() if isinstance(value, dict)}
    joints: dict[str, dict[str, Any]] = {}
    for joint, friction in campaign.friction.items():
        joints.setdefault(str(joint), {})["friction"] = friction
    for joint, parameters in campaign.parameter_overrides.items():
        joints.setdefault(str(joint), {})["parameters"] = parameters
    for run in reversed(campaign.runs):  # reversed, so that the first run that frees a joint decides
        for k, joint in enumerate(run.free_joints):
            sensor = _sensor(run, k)
            if sensor:
                joints.setdefault(str(joint), {})["sensor"] = sensor
    runs = [_entry(run, campaign.hold) for run in campaign.runs]
    return {"campaign": {**head, **loose}, **tables, **({"joint": joints} if joints else {}), "runs": runs}


def _sensor(run: Run, column: int) -> dict[str, float]:
    unit = "m" if run.prismatic[column] else "rad"
    named = {f"noise_{unit}": run.noise[column], f"resolution_{unit}": run.resolution[column]}
    return {name: float(value) for name, value in named.items() if np.isfinite(value)}


def _entry(run: Run, hold: str) -> dict[str, Any]:
    entry: dict[str, Any] = {"file": run.file, "free_joints": list(run.free_joints)}
    if run.posture.size:
        entry["locked_positions_rad"] = run.posture.tolist()
    entry["use"] = run.use
    optional = {"hold": run.hold if run.hold != hold else "", "reason": run.reason, "note": " ".join(run.notes)}
    return {**entry, **{key: value for key, value in optional.items() if value}}
