"""Figures of a model on a run, and which of two models they prefer."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.figures import Figures


def figures(free: float, torque: float, second: float) -> Figures:
    """Return figures of one joint: free simulation [m], torque [N], simulations of 1 s [m]."""
    return Figures(
        free_rmse=np.array([free]), torque_rmse=np.array([torque]), torque_error=np.array([0.1]),
        away_rmse=np.array([torque]), horizon_rmse={"0.1": np.array([second / 10]), "1": np.array([second])},
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


@pytest.mark.parametrize(
    ("torque_scored", "second_of_plain", "plain_is_better"),
    [(False, 7.0e-3, False), (False, 6.0e-3, True), (True, 7.0e-3, True)],
)
def test_a_torque_along_noisy_motion_does_not_give_up_a_fit_that_simulates_better(
    torque_scored: bool, second_of_plain: float, plain_is_better: bool
) -> None:
    # A stage with stiff bristles: a micrometre of noise bends them by half a newton.
    both = {
        "model": figures(free=7.6e-3, torque=1.36, second=6.6e-3),
        "baseline": figures(free=10.4e-3, torque=0.45, second=second_of_plain),
    }
    compared = Compared(
        baseline=None, figures={("unseen.csv", "validate"): both}, models={}, floor=np.array([np.nan]), runs=(),
        width=0.01, width_of_states=0.01, torque_scored=torque_scored,
    )  # fmt: skip
    assert compared.plain_is_better is plain_is_better
