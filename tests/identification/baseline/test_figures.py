"""Figures of a model on a run, and which of two models they prefer."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.baseline.figures import Figures


def figures(free: float, torque: float, second: float) -> Figures:
    """Return figures of one joint: free simulation [m], torque [N], simulations of 1 s [m]."""
    return Figures(
        free_rmse=np.array([free]), torque_rmse=np.array([torque]), torque_error=np.array([0.1]),
        horizon_rmse={"0.1": np.array([second / 10]), "1": np.array([second])},
    )  # fmt: skip


def test_a_free_simulation_at_the_noise_is_not_given_up_for_a_plain_model_of_the_torque() -> None:
    # Both miss 0.4 mm over 1 s, because friction sticks where the measured state says that it slips.
    exact = figures(free=6.8e-6, torque=0.28, second=4.05e-4)
    plain = figures(free=7.7e-4, torque=0.19, second=5.7e-4)
    assert exact.badness < plain.badness


@pytest.mark.parametrize("free", [np.nan, 0.5])
def test_a_free_simulation_that_drifts_or_runs_away_takes_nothing_from_that_over_a_second(free: float) -> None:
    near, far = figures(free=free, torque=0.2, second=1e-3), figures(free=free, torque=0.2, second=2e-3)
    assert near.badness < far.badness < np.inf


def test_a_model_that_cannot_be_simulated_over_a_second_is_the_worst_but_for_its_free_simulation() -> None:
    assert figures(free=np.nan, torque=0.2, second=np.nan).badness == np.inf
