"""Output injection: without gain the plain model, with gain a trajectory that the measurement pulls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from haptid.model.equations.output_injection import with_observer
from tests.model.kernel_cases import CASES, JOINT, KERNEL, OBSERVED, draw, torque, vector

T = np.arange(0.0, 4.0, 0.005)


def inputs(u: np.ndarray, y: np.ndarray, gain: float) -> np.ndarray:
    return np.column_stack((u, y, np.full(T.size, gain)))


def test_no_gain_gives_the_plain_model_bit_for_bit():
    parameters, amplitude = CASES["tendon"]
    u, measured = torque(T, amplitude), np.sin(T)
    for p in draw(parameters, 50, seed=11, passive=False):
        plain = KERNEL.simulate(T, u, p, [0.1, 0.0, 0.0])
        np.testing.assert_array_equal(OBSERVED.simulate(T, inputs(u, measured, 0.0), p, [0.1, 0.0, 0.0]), plain)


def test_gain_pulls_a_wrong_model_to_the_measurement():
    parameters, amplitude = CASES["tendon"]
    u = torque(T, amplitude)
    p = vector(parameters)
    wrong = vector(parameters | {"Ks": 2 * parameters["Ks"], "sigma0": 2 * parameters["sigma0"]})
    measured = KERNEL.simulate(T, u, p, [0.1, 0.0, 0.0])[:, 0]
    misses = [
        np.abs(OBSERVED.simulate(T, inputs(u, measured, L), wrong, [0.1, 0.0, 0.0])[:, 0] - measured).max()
        for L in (0.0, 2.0, 6.0, 20.0, 60.0)
    ]
    assert np.all(np.diff(misses) < 0), misses
    assert misses[-1] < 0.1 * misses[0]


def test_equations_with_a_mass_matrix_are_refused():
    implicit = replace(JOINT, mass_matrix=((sp.Symbol("inertia", real=True),),))
    with pytest.raises(ValueError, match="explicit"):
        with_observer(implicit)
