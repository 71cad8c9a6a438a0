"""Campaign folders: campaign.toml and one compressed table per run, the same bytes from the same numbers."""

from __future__ import annotations

import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from haptid.support.files.files import write_bytes, write_text
from haptid.virtual_device.machine.compiled import Array

FORMATS = {"time": "%.6g", "torque": "%.8g", "position": "%.7g", "reference": "%.7g"}
"""Digits of a column, by the first word of its name: torque is rounded to these before it is simulated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunTable:
    """One run: its table, and its entry of campaign.toml.

    Parameters
    ----------
    file
        Name of the table.
    free_joints
        Numbers of the joints that move.
    columns
        Columns by name, shape (n,) each.
    use, reason, note
        Use of the run, why it is excluded, and a remark.
    posture
        Positions of the locked joints [rad]; home where empty.
    """

    file: str
    free_joints: tuple[int, ...]
    columns: Mapping[str, Array]
    use: str = "fit"
    reason: str = ""
    note: str = ""
    posture: tuple[float, ...] = ()
    """Positions of the locked joints [rad]; home where empty."""

    def entry(self, joints: int) -> dict[str, Any]:
        """Return the ``[[runs]]`` table of the run.

        Parameters
        ----------
        joints
            Number of joints of the device; with several of them the positions of the locked ones are told.

        Returns
        -------
        dict
            Entry of campaign.toml.
        """
        entry: dict[str, Any] = {"file": self.file, "free_joints": list(self.free_joints), "use": self.use}
        if joints > 1:
            entry["locked_positions_rad"] = list(self.posture or [0.0] * joints)
        return entry | {key: text for key, text in (("reason", self.reason), ("note", self.note)) if text}

    def encoded(self) -> bytes:
        """Write the table as compressed CSV.

        Returns
        -------
        bytes
            gzip without a date in it: the same columns give the same bytes.
        """
        formats = [FORMATS[name.split("_")[0]] for name in self.columns]
        rows = zip(*self.columns.values(), strict=True)
        lines = [",".join(f % value for f, value in zip(formats, row, strict=True)) for row in rows]
        return gzip.compress("\n".join([",".join(self.columns), *lines, ""]).encode(), 9, mtime=0)


def joint_columns(joint: int, t: Array, torque: Array, position: Array) -> dict[str, Array]:
    """Return the columns of one joint, positions rounded as the table holds them.

    Parameters
    ----------
    joint
        Number of the joint.
    t
        Times [s], shape (n,).
    torque
        Torques [N m], shape (n,).
    position
        Positions [rad], shape (n,).

    Returns
    -------
    dict of str to Array
        Column by name, as ``torque_4_Nm``.
    """
    return {"time_s": t, f"torque_{joint}_Nm": torque, f"position_{joint}_rad": np.round(position, 7)}


def write_campaign(folder: Path, header: Mapping[str, Any], runs: Sequence[RunTable], *, joints: int) -> Path:
    """Write the folder: the tables first, campaign.toml last, so that a campaign that can be read is whole.

    Parameters
    ----------
    folder
        Folder to write to.
    header
        Tables of campaign.toml without its runs.
    runs
        Runs in the order of campaign.toml.
    joints
        Number of joints of the device.

    Returns
    -------
    Path
        The campaign.toml.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    for run in runs:
        write_bytes(folder / run.file, run.encoded())
    content = {**header, "runs": [run.entry(joints) for run in runs]}
    return write_text(folder / "campaign.toml", tomli_w.dumps(content))
