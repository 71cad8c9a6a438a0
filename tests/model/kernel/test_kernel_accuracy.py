"""The stepper against SciPy's Radau on an equation written by hand, and its order."""

from __future__ import annotations

import numpy as np
import pytest

from tests.model.kernel_cases import CASES, KERNEL, TENDON, by_hand, draw, radau, torque, vector

ROWS = np.arange(0.0, 2.01, 0.1)
START = [0.1, 0.0, 0.0]


@pytest.mark.parametrize("hold", ["zero", "linear"])
@pytest.mark.parametrize("case", CASES)
def test_agrees_with_radau_far_below_the_sensor(case: str, hold: str):
    parameters, amplitude = CASES[case]
    u = torque(ROWS, amplitude)
    reference = radau(parameters, ROWS, u[:, 0], START, hold=hold)
    y = KERNEL.simulate(ROWS, u, vector(parameters), START, linear=hold == "linear")[:, 0]
    assert np.sqrt(np.mean((y - reference) ** 2)) < 2e-7  # rad; a thousandth of a good encoder's noise
    fine = KERNEL.simulate(ROWS, u, vector(parameters), START, linear=hold == "linear", step=6.25e-5)[:, 0]
    np.testing.assert_allclose(fine, reference, rtol=0, atol=2e-9)


@pytest.mark.parametrize("case", CASES)
def test_stays_accurate_over_the_box(case: str):
    parameters, amplitude = CASES[case]
    P = draw(parameters, 200, seed=3)
    t = np.arange(0.0, 8.0, 0.005)
    x0 = np.tile(START, (len(P), 1))
    coarse = KERNEL.simulate_many(t, torque(t, amplitude), P, x0)
    fine = KERNEL.simulate_many(t, torque(t, amplitude), P, x0, step=2.5e-5)
    errors = np.sqrt(np.mean((coarse - fine) ** 2, axis=(1, 2)))
    assert np.median(errors) < 1e-8
    assert errors.max() < 2e-5


def test_order_four_where_the_equation_is_smooth():
    start = [0.1, 2.0, 0.0]  # fast enough that the speed keeps its sign
    t = np.array([0.0, 0.05])
    p, u = vector(TENDON), np.full((2, 1), 4e-3)

    def end(step: float) -> float:
        return float(KERNEL.simulate(t, u, p, start, step=step)[-1, 0])

    exact = end(0.05 / 6400)
    errors = np.abs([end(0.05 / n) - exact for n in (50, 100, 200, 400)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 3.6), orders


@pytest.mark.parametrize("seed", range(20))
def test_generated_derivatives_are_those_written_by_hand(seed: int):
    rng = np.random.default_rng(seed)
    p = draw(TENDON, 1, seed)[0]
    x, tau = rng.normal(size=3) * [0.5, 1.0, 1e-2], rng.normal() * 1e-2
    names = {q.id: value for q, value in zip(KERNEL.equations.parameters, p, strict=True)}
    np.testing.assert_allclose(KERNEL.derivatives(0.0, x, [tau], p), by_hand(names, lambda _: tau)(0.0, x), rtol=1e-12)


def test_uneven_rows_give_the_same_trajectory_as_even_ones():
    p, u = vector(TENDON), 3e-3
    even = np.arange(0.0, 1.0, 0.005)
    kept = np.sort(np.random.default_rng(0).choice(even.size, 60, replace=False))
    kept[0] = 0
    full = KERNEL.simulate(even, np.full((even.size, 1), u), p, START)
    some = KERNEL.simulate(even[kept], np.full((kept.size, 1), u), p, START)
    np.testing.assert_allclose(some, full[kept], rtol=0, atol=1e-9)
