"""Corners, where a parameter that no residual sees decides whether two others would part; steps along logarithms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from haptid.identification.optimise.corners import leave_corners
from haptid.identification.optimise.levenberg_marquardt import Descent, Steps, SumOfSquares, minimise
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from tests.identification import bench_joint
from tests.identification.bench_joint import TRUE

WITHOUT_STICTION = {**TRUE, "Fs": 1.08e-3, "Fc": 1.08e-3}
RELATIVE = 1e-5


@pytest.fixture(scope="module")
def cost() -> SumOfSquares:
    fitted = tuple(run for run in bench_joint.runs() if run.use == "fit")
    problem = Problem.of(bench_joint.simulator(), fitted, FitOptions())
    return SumOfSquares.of(problem)


def start(cost: SumOfSquares, **changed: float) -> Array:
    values = WITHOUT_STICTION | changed
    return cost.problem.unknowns_at(np.array([values.get(q.id, q.initial) for q in bench_joint.equations().parameters]))


def descend(cost: SumOfSquares, x: Array) -> Descent:
    return minimise(cost, x, tolerance=0.0, relative=RELATIVE, steps=Steps.short(cost.problem))


def leave(cost: SumOfSquares, reached: Descent, again: Callable[[Array], Descent]) -> Descent:
    return leave_corners(cost, reached, again, steps=Steps.short(cost.problem), relative=1e-3)


def test_a_descent_that_ends_without_stiction_is_led_to_the_noise(cost: SumOfSquares):
    """At a Stribeck speed above all speeds no stiction lowers the cost: the descent ends where Fs = Fc."""
    caught = descend(cost, start(cost, vs=5.0))
    ids = cost.problem.parametrisation.ids
    values = dict(zip(ids, cost.problem.theta(caught.x)[list(cost.problem.parametrisation.free)], strict=True))
    assert caught.converged
    assert values["Fs"] == pytest.approx(values["Fc"], rel=1e-6)
    assert caught.cost > 10.0 * cost.problem.weight
    led = leave(cost, caught, lambda x: descend(cost, x))
    assert led.cost < 1.05 * cost.problem.weight
    vs = cost.problem.theta(led.x)[[q.id for q in bench_joint.equations().parameters].index("vs")]
    assert vs == pytest.approx(TRUE["vs"], rel=0.05)
    assert led.calls > caught.calls


def test_a_minimum_with_stiction_is_left_as_it_is_without_a_simulation(cost: SumOfSquares):
    found = descend(cost, start(cost, vs=0.02))
    asked: list[Array] = []

    def again(x: Array) -> Descent:
        asked.append(x)
        return found

    assert leave(cost, found, again) == found
    assert not asked


def test_of_a_cost_that_is_not_finite_no_corner_is_looked_for(cost: SumOfSquares):
    nowhere = Descent.at(start(cost))
    assert leave(cost, nowhere, lambda _x: nowhere).calls == 0


def test_no_step_moves_a_parameter_by_more_than_the_longest_step(cost: SumOfSquares):
    visited = [start(cost, vs=5.0, sigma0=0.05)]

    class Watched:
        constraints = staticmethod(cost.constraints)
        at = staticmethod(cost.at)

        @staticmethod
        def move(x: Array, d: Array) -> Array:
            visited.append(cost.move(x, d))
            return visited[-1]

    minimise(Watched(), visited[0], tolerance=0.0, relative=RELATIVE, steps=Steps.short(cost.problem))
    log = np.flatnonzero(cost.problem.parametrisation.log)
    steps = np.abs(np.diff(np.array(visited)[:, log], axis=0))
    most = THRESHOLDS.longest_step_of_logarithm
    assert math.exp(most) == pytest.approx(math.sqrt(2.0), rel=0.01)
    # Steps that were tried and refused count from the point before; a step back and forth is two long.
    assert len(visited) > 5
    assert steps.max() < 2.0 * most + 1e-9
    assert np.abs(visited[1] - visited[0])[log].max() == pytest.approx(most)
