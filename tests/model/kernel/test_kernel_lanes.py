"""Parameter sets side by side have the bits of each one alone, with any number of threads."""

from __future__ import annotations

import numpy as np
import pytest

from tests.model.kernel_cases import CASES, KERNEL, draw, torque

T = np.arange(0.0, 2.0, 0.005)


@pytest.mark.parametrize("passive", [True, False])
@pytest.mark.parametrize("linear", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_bit_identical_to_scalar(case: str, linear: bool, passive: bool):
    parameters, amplitude = CASES[case]
    P = draw(parameters, 101, seed=7, passive=passive)  # not a multiple of the lanes
    x0 = np.random.default_rng(7).normal(size=(len(P), 3)) * [0.2, 0.1, 1e-3]
    u = torque(T, amplitude)
    many = KERNEL.simulate_many(T, u, P, x0, linear=linear)
    alone = np.array([KERNEL.simulate(T, u, p, x, linear=linear) for p, x in zip(P, x0, strict=True)])
    np.testing.assert_array_equal(many, alone)


@pytest.mark.parametrize("threads", [2, 3, 8])
def test_threads_change_no_bit(threads: int):
    parameters, amplitude = CASES["tendon"]
    P = draw(parameters, 37, seed=8)
    x0 = np.tile([0.1, 0.0, 0.0], (len(P), 1))
    u = torque(T, amplitude)
    one = KERNEL.simulate_many(T, u, P, x0)
    np.testing.assert_array_equal(KERNEL.simulate_many(T, u, P, x0, threads=threads), one)


def test_plain_and_tangent_runs_agree_to_rounding():
    parameters, amplitude = CASES["tendon"]
    u = torque(T, amplitude)
    for p in draw(parameters, 20, seed=9, passive=False):
        plain = KERNEL.simulate(T, u, p, [0.1, 0.0, 0.0])
        np.testing.assert_allclose(KERNEL.simulate_tangent(T, u, p, [0.1, 0.0, 0.0])[0], plain, rtol=0, atol=1e-12)
