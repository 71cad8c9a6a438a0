"""What decays to nothing in a kernel becomes 0, not a subnormal number; the caller's arithmetic stays as it is."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from haptid.model.equations.equations import Equations, Output, State
from haptid.model.equations.quantity import Quantity
from haptid.model.kernel.compiled import LANES, CompiledKernel

T = np.linspace(0.0, 100.0, 2001)
"""Times [s]: e^(−1000) at the end, far below the least number."""
U = np.zeros((T.size, 0))


@pytest.fixture(scope="module")
def kernel() -> CompiledKernel:
    x, a = sp.Symbol("x", real=True), sp.Symbol("a", real=True)
    return CompiledKernel.of(
        Equations(
            name="decay",
            title="decay",
            joints=(),
            states=(State(id="x", unit="1", description="what decays"),),
            inputs=(),
            outputs=(Output(id="y", unit="1", description="the same", expression=x),),
            parameters=(Quantity(id="a", unit="1/s", description="rate", initial=10.0),),
            rhs=(-a * x,),
            rates=(a,),
        ),
        many=True,
    )


def test_all_ends_at_zero(kernel):
    y, dy = kernel.simulate_tangent(T, U, [10.0], [1.0])
    assert y[-1, 0] == kernel.simulate(T, U, [10.0], [1.0])[-1, 0] == 0.0
    assert not dy[-1].any()
    many = kernel.simulate_many(T, U, np.full((LANES, 1), 10.0), np.ones((LANES, 1)))
    assert not many[:, -1].any()
    x = np.array([1.0])
    for t in T[:-1]:
        x = kernel.advance(x, t, T[1], U[0], [10.0])
    assert x[0] == 0.0


def test_small_numbers_above_the_least_normal_one_stay(kernel):
    y = kernel.simulate(T, U, [7.0], [1.0])[:, 0]
    normal = np.exp(-7.0 * T) > 10 * np.finfo(float).tiny
    assert y[normal] == pytest.approx(np.exp(-7.0 * T[normal]), rel=1e-11)


def test_the_caller_keeps_its_subnormal_numbers(kernel):
    least = np.array([np.finfo(float).tiny])
    kernel.simulate_tangent(T, U, [10.0], [1.0])
    kernel.simulate(T, U, [10.0], [1.0])
    kernel.advance([1.0], 0.0, 1.0, U[0], [10.0])
    kernel.simulate_many(T, U, np.full((LANES, 1), 10.0), np.ones((LANES, 1)))
    assert (least / 2 > 0.0).all()
