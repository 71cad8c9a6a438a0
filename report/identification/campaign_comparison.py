"""The whole model of one embedded campaign beside that of the other: `Verification` and stored results in, `Table` out.

``campaigns.json`` beside this module holds what the whole models of both embedded campaigns leave on the same runs. It
is written by ``python -m benchmarks.whole_model``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from haptid.identification.verification.result import Verification
from haptid.report.common.page import Table

STORED = Path(__file__).parent / "campaigns.json"
NAMES = {"planned": "planned lock postures", "paper": "the paper's protocol: locked joints at home"}
"""Words for each embedded campaign."""


def worst_by_joint(runs: Sequence[Mapping[str, Any]], mode: str) -> list[float]:
    """Return the residual of each joint in the run that is worst for it.

    Parameters
    ----------
    runs
        Runs with ``mode`` and ``rmse_over_noise``, one number a joint.
    mode
        ``closed_loop`` or ``open_loop``.

    Returns
    -------
    list of float
        Largest RMS over noise [1] by joint; empty where no run was simulated so.
    """
    of_mode = [run["rmse_over_noise"] for run in runs if run["mode"] == mode]
    return [max(values) for values in zip(*of_mode, strict=True)]


def comparison_table(verification: Verification, name: str) -> Table:
    """Show the residuals of this whole model beside the stored ones of the other embedded campaign.

    Parameters
    ----------
    verification
        Check of the whole model of this run.
    name
        Name of the embedded campaign that was identified, ``planned`` or ``paper``.

    Returns
    -------
    Table
        One row a campaign, one column a joint: RMS over noise in closed loop, in the worst run of the joint.
    """
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    here = [
        {"mode": run.mode, "rmse_over_noise": [joint.rmse_over_noise for joint in run.joints]}
        for run in verification.runs
    ]
    rows, joints = [], range(len(verification.runs[0].joints))
    for campaign, words in NAMES.items():
        runs = here if campaign == name else stored["campaigns"][campaign]["runs"]
        source = "this page" if campaign == name else f"{stored['command']}, {stored['date']}"
        worst = worst_by_joint(runs, "closed_loop")
        rows.append((words, *(f"{value:.2f}" for value in worst), source))
    caption = "Both embedded campaigns: RMS / noise in closed loop, the worse unseen run of each joint"
    return Table(header=("campaign", *(f"joint {j}" for j in joints), "from"), rows=rows, caption=caption)
