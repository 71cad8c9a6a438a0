"""Converged needs unseen runs at the noise and rows enough for the parameters; a joint at rest is not fitted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.identification.result.outcome import Outcome, outcome_of, tell_status, with_cause
from haptid.identification.sequence.configurations import configurations_of
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.support.errors import InputError

TOML = """[campaign]
device = "single_joint"
measured = false

[[runs]]
file = "a.csv"
free_joints = [0]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [0]
use = "validate"
"""


def campaign(folder: Path, *, travel: float, step: float = 0.005, gap: float = 0.0) -> Path:
    """Write a campaign whose joint follows a sine of ``travel`` [rad], with noise of 1e-4 rad and a ``gap`` [s]."""
    random = np.random.default_rng(0)
    t = np.arange(400) * step
    t[200:] += gap
    for name in ("a.csv", "b.csv"):
        y = 0.5 * travel * np.sin(20 * t) + 1e-4 * random.standard_normal(t.size)
        pd.DataFrame({"time_s": t, "torque_0_Nm": np.cos(20 * t), "position_0_rad": y}).to_csv(
            folder / name, index=False
        )
    (folder / "campaign.toml").write_text(TOML, encoding="utf-8")
    return folder


def outcome(*, reached: int = 2, fitted: float = 1.0, unseen: float = 1.0, rows: int = 1000) -> Outcome:
    return outcome_of(reached, fitted, 1.05, unseen=unseen, rows=rows, parameters=12)


def test_only_what_carries_over_is_converged():
    assert outcome() is Outcome.CONVERGED
    assert outcome(unseen=1.2) is Outcome.CONVERGED
    assert outcome(unseen=4777.0) is Outcome.UNSEEN
    assert outcome(unseen=float("nan")) is Outcome.UNSEEN
    assert outcome(reached=1, unseen=4777.0) is Outcome.UNSEEN
    assert outcome(fitted=3.0, unseen=4777.0) is Outcome.ABOVE_NOISE


@pytest.mark.parametrize("unfit", [Outcome.ABOVE_NOISE, Outcome.LONELY, Outcome.PLAIN, Outcome.OBSERVED])
def test_only_identified_values_of_a_model_that_does_not_fit_are_uncertain(unfit):
    assert tell_status("identified", unfit.label) == "uncertain"
    assert tell_status("identified", Outcome.CONVERGED.label) == "identified"
    assert tell_status("at_bound", unfit.label) == "at_bound"


def test_few_rows_conclude_nothing():
    assert outcome(rows=8) is Outcome.TOO_FEW_ROWS
    assert outcome(rows=8, fitted=9.0) is Outcome.TOO_FEW_ROWS


def test_a_joint_that_stands_still_is_refused_before_any_fit(tmp_path: Path):
    with pytest.raises(InputError, match=r"a\.csv: expected a run in which joint 0 moves more than 10 times"):
        configurations_of(campaign_for_command(campaign(tmp_path, travel=0.0)), None)


def test_a_joint_that_moves_is_not(tmp_path: Path):
    (found,) = configurations_of(campaign_for_command(campaign(tmp_path, travel=0.1)), None)
    assert found.free_joints == (0,)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"gap": 1e6}, r"a\.csv, time_s after 0\.995 s: expected no gap above 10 s"),
        ({"step": 5.0}, "the time is in ms"),
    ],
)
def test_a_clock_that_would_take_hours_is_refused(settings: dict[str, float], words: str, tmp_path: Path):
    with pytest.raises(InputError, match=words):
        campaign_for_command(campaign(tmp_path, travel=0.1, **settings))


@pytest.mark.parametrize("above", [Outcome.ABOVE_NOISE, Outcome.LONELY])
def test_a_residual_as_large_as_the_motion_has_a_plainer_cause(above: Outcome):
    assert with_cause(above, over_motion=0.1, excited=True) is above
    assert with_cause(above, over_motion=0.9, excited=True) is Outcome.UNEXPLAINED
    assert with_cause(above, over_motion=0.9, excited=False) is Outcome.UNEXCITED
    assert with_cause(Outcome.CONVERGED, over_motion=0.9, excited=False) is Outcome.CONVERGED


def test_nothing_is_fitted_where_every_parameter_is_fixed():
    assert outcome_of(1, 1.0, 1.05, unseen=1.0, rows=1000, parameters=0) is Outcome.FIXED
