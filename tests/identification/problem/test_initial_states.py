"""Runs that begin in motion: the initial state of a joint with friction, found from the first rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.identification.problem.initial_states import start_of
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.statistics.score import fit_initial_state
from haptid.measurement.values.run import Array, Run
from haptid.model.joint.locked_joint import joint_equations

SPEED, NOISE = 1.4, 5e-5
"""Initial velocity [rad/s] and sensor noise [rad]."""
EQUATIONS = joint_equations(0).with_parameters(
    {
        "inertia": {"initial": 0.02},
        "gravity_cos": {"initial": 0.0},
        "gravity_sin": {"initial": 0.0},
        "Ks": {"initial": 0.0},
        "sigma0": {"initial": 200.0},
        "sigma1": {"initial": 0.3},
        "sigma2": {"initial": 0.03},
        "Fs": {"initial": 0.08},
        "Fc": {"initial": 0.08},
    }
)
THETA = np.array([q.initial for q in EQUATIONS.parameters])


def coasting_run() -> Run:
    """Simulate a joint that is in motion at the first row and comes to rest by its friction."""
    t = np.arange(300) * 0.004
    run = Run(
        file="coasting.csv",
        free_joints=(0,),
        t=t,
        u=np.zeros((t.size, 1)),
        y=np.zeros((t.size, 1)),
        noise=np.array([NOISE]),
        resolution=np.zeros(1),
        posture=np.zeros(0),
        use="validate",
    )
    x0 = np.array([0.3, SPEED, 0.0])
    y = KernelSimulator.of(EQUATIONS).simulate(THETA, run, x0=x0).y
    return replace(run, y=y + NOISE * np.random.default_rng(1).standard_normal(y.shape))


@pytest.fixture(scope="module")
def run() -> Run:
    return coasting_run()


def test_a_joint_in_motion_may_begin_at_the_slope_of_its_first_rows(run: Run) -> None:
    start = start_of(EQUATIONS, run)
    assert start.at(start.guess)[1] == pytest.approx(SPEED, rel=0.05)


def test_a_refit_from_a_minimum_begins_at_its_initial_states(run: Run) -> None:
    simulator, state = KernelSimulator.of(EQUATIONS), (0.31, SPEED, 1e-4)
    begun = Problem.of(simulator, (run,), FitOptions(states={run.file: state}))
    (x0,) = begun.x0(begun.unknowns_at(THETA))
    assert x0[:2].tolist() == pytest.approx(state[:2])
    # Equations with another state, as an encoder zero, take the readings.
    other = Problem.of(simulator, (run,), FitOptions(states={run.file: (*state, 0.0)}))
    (x0,) = other.x0(other.unknowns_at(THETA))
    assert x0[:2].tolist() == pytest.approx([float(run.y[0, 0]), 0.0])


def test_a_joint_that_breaks_loose_from_rest_begins_at_rest(run: Run) -> None:
    # The jerk of the first rows looks like a velocity, and is none at t = 0.
    simulator = KernelSimulator.of(EQUATIONS)
    pushed = replace(run, u=np.where(run.t < 0.012, 0.0, 0.9)[:, None])
    y = simulator.simulate(THETA, pushed, x0=np.array([0.3, 0.0, 0.0])).y
    pushed = replace(pushed, y=y + NOISE * np.random.default_rng(2).standard_normal(y.shape))
    start = start_of(EQUATIONS, pushed)
    assert start.states == (0, 1)  # the velocity is free
    assert not start.guess.any()
    assert abs(fit_initial_state(simulator, THETA, pushed)[1]) < 0.005


def test_a_measured_velocity_is_in_the_base_and_a_joint_at_rest_begins_at_rest(run: Run) -> None:
    measured = start_of(EQUATIONS, replace(run, v=np.gradient(run.y, run.t, axis=0)))
    assert not measured.guess.any()
    assert measured.base[1] == pytest.approx(SPEED, rel=0.05)
    resting = replace(run, y=np.full_like(run.y, 0.3))
    assert start_of(EQUATIONS, resting).states == (0,)
    assert start_of(EQUATIONS, resting, free_velocity=True).guess.tolist() == [0.0, 0.0]


def test_the_initial_state_of_a_moving_joint_is_found_and_not_one_that_sticks(run: Run) -> None:
    simulator = KernelSimulator.of(EQUATIONS)
    found = fit_initial_state(simulator, THETA, run)
    left: Array = run.y - simulator.simulate(THETA, run, x0=found).y
    assert found[1] == pytest.approx(SPEED, rel=0.01)
    assert float(np.sqrt(np.mean(left**2))) < 1.3 * NOISE
