"""Smooth torques over position: which effects of a model could follow any curve together."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.discrepancy.search.under_observer.smooth_curves import smooth_curves
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue

TRAVEL = 1.2
VALUES = {
    "k3": 0.3, "k2": 0.2, "epos": 0.1, "cogging_sin": 0.01, "cogging_cos": -0.02,
    "payload_cos": 0.1, "payload_sin": 0.2, "hysteresis_stiffness": 1.0, "hysteresis_travel": 0.1,
}  # fmt: skip


def _study() -> Any:
    """Return what stands for a study: two runs, which together make the travel."""
    reached = (np.linspace(-0.6, 0.2, 50), np.linspace(-0.1, 0.6, 50))
    return SimpleNamespace(fitted=[SimpleNamespace(y=y[:, None]) for y in reached])


def _effect(key: str) -> Effect:
    return catalogue()[key]


@pytest.mark.parametrize(("periods", "smooth"), [(0.4, True), (2.1, True), (3.4, False), (10.0, False)])
def test_wave_is_a_curve_below_three_periods_over_the_travel(periods: float, smooth: bool) -> None:
    values = VALUES | {"cogging_number": 2.0 * np.pi * periods / TRAVEL}
    found = smooth_curves(_study(), [_effect("cogging"), _effect("cubic_spring")], values)
    expected = ["cogging", "cubic_spring"] if smooth else ["cubic_spring"]
    assert [e.id for e in found] == expected


@pytest.mark.parametrize("key", ["cubic_spring", "asymmetric_spring", "payload_gravity"])
def test_springs_and_weights_are_curves(key: str) -> None:
    assert smooth_curves(_study(), [_effect(key)], VALUES) == (_effect(key),)


@pytest.mark.parametrize("key", ["cable_hysteresis", "asymmetric_coulomb", "torque_ripple", "encoder_ripple"])
def test_what_depends_on_more_than_position_is_no_curve(key: str) -> None:
    assert smooth_curves(_study(), [_effect(key)], VALUES) == ()
