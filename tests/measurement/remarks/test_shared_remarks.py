"""A remark that runs share is one line, which names them or their number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.checks.preparation import ready_for_fits
from haptid.measurement.checks.summary import summarise, tell_table
from haptid.measurement.remarks.shared import tell_shared
from haptid.measurement.values.campaign import Campaign
from tests.measurement.remarks.test_suspicions import a_run


@pytest.mark.parametrize(
    ("files", "every", "told"),
    [
        (["a.csv"], 1, "a.csv"),
        (["a.csv", "b.csv"], 2, "a.csv, b.csv"),
        (["a.csv", "b.csv", "c.csv"], 3, "all 3 runs"),
        (["a.csv", "b.csv", "c.csv"], 4, "a.csv, b.csv, c.csv"),
        (["a.csv", "b.csv", "c.csv", "d.csv"], 12, "4 of 12 runs (a.csv, b.csv, …)"),
    ],
)
def test_runs_that_share_a_remark_stand_in_its_line(files, every, told):
    remarks = [(file, joint, "odd") for file in files for joint in ("0", "1")]
    assert tell_shared([*remarks, ("z.csv", "0", "other")], every) == [
        f"{told}, joint 0, 1: odd",
        "z.csv, joint 0: other",
    ]


def test_check_and_the_other_commands_say_it_once():
    """Five runs with the same stated noise, which their rows contradict, had five lines of the same words."""
    rng, t = np.random.default_rng(0), np.arange(0.0, 4.0, 0.002)
    y = 0.3 * np.sin(2 * t) + 1e-4 * rng.standard_normal(t.size)
    runs = tuple(a_run(t, np.cos(2 * t), y, file=f"{k}.csv", noise=1e-2) for k in range(4))
    others = tuple(
        a_run(t, np.cos(2 * t), y + 0.01 * k * np.sin(3 * t), file=f"other{k}.csv", noise=1e-4) for k in range(2)
    )
    campaign = Campaign(folder=Path("made"), title="", device="single_joint", measured=True, runs=runs + others)
    told = [line.strip() for line in tell_table(summarise(campaign)) if isinstance(line, str) and "is stated" in line]
    assert len(told) == 1
    assert told[0].startswith("4 of 6 runs (0.csv, 1.csv, …), joint 0: a noise of 0.01 is stated")
    assert [remark for remark in ready_for_fits(campaign).remarks if "is stated" in remark] == told
