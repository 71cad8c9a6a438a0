"""Intervals hold the true value as often as they say."""

import numpy as np
import pytest

from haptid.discrepancy.verdict.estimate import Estimate
from haptid.model.equations.quantity import Quantity


def test_the_interval_of_a_standard_deviation_of_few_cycles_holds_it() -> None:
    rng, held, evenly = np.random.default_rng(0), 0, 0
    for _ in range(2000):
        draws = rng.normal(0.0, 0.02, 6)
        found = Estimate.of_deviation(float(draws.std(ddof=1)), 5.0, "1")
        held += found.interval[0] <= 0.02 <= found.interval[1]
        evenly += abs(found.value - 0.02) <= 1.96 * found.std
    assert held / 2000 == pytest.approx(0.95, abs=0.015)
    assert evenly / 2000 < 0.9


def test_a_normal_error_lies_evenly_about_its_value() -> None:
    found = Estimate.normal(2.0, 0.1, "rad").as_json()
    assert found["interval"] == pytest.approx([1.8040036, 2.1959964], abs=1e-7)
    assert (found["value"], found["std"], found["unit"]) == (2.0, 0.1, "rad")


def test_the_interval_of_a_parameter_keeps_its_sign():
    wave = Quantity(id="n", unit="1/rad", description="", initial=6.0, lower=1.0, upper=40.0, scale="log")
    load = Quantity(id="mu", unit="1", description="", initial=0.1, lower=0.0, upper=1.0)
    torque = Quantity(id="a", unit="N m", description="", initial=0.1, lower=-1.0, upper=1.0)
    low, high = Estimate.of_parameter(wave, 6.0, 30.0).interval
    assert 0.0 < low < 6.0 < high
    assert low * high == pytest.approx(36.0)
    assert Estimate.of_parameter(wave, 6.0, 1e9).interval[0] > 0.0
    # A small error gives the interval of a normal one.
    assert Estimate.of_parameter(wave, 6.0, 0.01).interval == pytest.approx((5.9804, 6.0196), abs=1e-4)
    assert Estimate.of_parameter(load, 0.1, 0.2).interval == pytest.approx((0.0, 0.492), abs=1e-3)
    assert Estimate.of_parameter(torque, 0.1, 0.2).interval == pytest.approx((-0.292, 0.492), abs=1e-3)
