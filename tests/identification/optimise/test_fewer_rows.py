"""Rows of long recordings are merged on the way to a minimum, and the minimum has all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.identification.fit.minima import find_minima
from haptid.identification.fit.multistart import fit
from haptid.identification.optimise.fewer_rows import merge_problem, with_fewer_rows
from haptid.identification.optimise.homotopy import descend, is_far, polish
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Here
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations

NOISE = 1e-4
TRUE = {
    "inertia": 2e-3, "Ks": 0.05, "epos": 0.1, "sigma0": 5.0, "sigma1": 0.02, "sigma2": 0.01, "vs": 0.1, "Fs": 0.02,
    "Fc": 0.015,
}  # fmt: skip
OPTIONS = FitOptions(method="gauss_newton", starts=2, workers=1, gains=(20.0, 2.0, 0.0))


def model(**initial: float) -> Equations:
    known = {id: {"fixed": True, "initial": 0.0} for id in ("gravity_cos", "gravity_sin")}
    guesses = {id: {"initial": value} for id, value in (TRUE | initial).items()}
    return joint_equations(0).with_parameters(known | guesses)


def recorded(rows: int = 14_000, spacing: float = 1e-3, ripple: float = 0.0, seed: int = 0) -> tuple[Run, ...]:
    """Two runs at 1 kHz; a ripple of the torque that no parameter of the joint makes."""
    t = spacing * np.arange(rows)
    runs = []
    for k, omega in enumerate((2.0, 3.3)):
        u = 0.1 * np.cos(omega * t)
        acting = u + ripple * np.cos(1.7 * t + 1.0)
        made = Run(
            file=f"run{k}.csv", free_joints=(0,), posture=(), t=t, u=acting[:, None], y=np.zeros((rows, 1)),
            noise=[NOISE], resolution=[0.0], use="fit", averaged_rows=1,
        )  # fmt: skip
        theta = np.array([q.initial for q in model().parameters])
        y = KernelSimulator.of(model()).simulate(theta, made).y
        noise = np.random.default_rng(seed + k).normal(0.0, NOISE, y.shape)
        runs.append(made.but(u=u[:, None], y=y + noise))
    return tuple(runs)


def problem(runs: tuple[Run, ...]) -> Problem:
    return Problem.of(KernelSimulator.of(model(inertia=3e-3, Fc=0.01)), runs, OPTIONS)


def test_rows_are_merged_where_the_residual_does_not_show_it():
    p = problem(recorded())
    x = p.unknowns_at(p.parametrisation.initial)
    few = with_fewer_rows(p, x, 0.0)
    assert sum(run.t.size for run in few.runs) == 28_000 // (28_000 // THRESHOLDS.most_rows_of_homotopy)
    assert few.size == p.size
    np.testing.assert_allclose(few.x0(x), p.x0(x))
    exact = np.concatenate([r[::2] for r in p.blocks(x, 0.0, jacobian=False).rows])
    lost = np.concatenate(few.blocks(x, 0.0, jacobian=False).rows) - exact
    assert np.linalg.norm(lost) < THRESHOLDS.largest_inner_step_error_over_residual * np.linalg.norm(exact)


def test_few_rows_and_torques_between_merged_rows_stay_as_they_are():
    short = problem(recorded(rows=4_000))
    assert with_fewer_rows(short, short.unknowns_at(short.parametrisation.initial), 20.0) is short
    averaged = problem(tuple(run.but(averaged_rows=2) for run in recorded()))
    assert with_fewer_rows(averaged, averaged.unknowns_at(averaged.parametrisation.initial), 20.0) is averaged
    # Near the noise the reading shows what a torque of many turns a row does between the rows that are kept.
    t = recorded()[0].t
    fast = tuple(run.but(u=run.u + 2.0 * np.sign(np.sin(2 * np.pi * 250.0 * t + 0.3))[:, None]) for run in recorded())
    p = problem(fast)
    theta = np.array([q.initial for q in model().parameters])
    y = [p.simulator.simulate(theta, run).y for run in fast]
    p = problem(tuple(run.but(y=made) for run, made in zip(fast, y, strict=True)))
    assert with_fewer_rows(p, p.unknowns_at(theta), 0.0) is p


def test_at_the_noise_the_minimum_is_that_of_all_rows(monkeypatch: pytest.MonkeyPatch):
    alone = OPTIONS.but(starts=1)
    found = fit(KernelSimulator.of(model()), recorded(), options=alone)
    monkeypatch.setattr("haptid.identification.optimise.homotopy.with_fewer_rows", lambda problem, *_: problem)
    whole = fit(KernelSimulator.of(model()), recorded(), options=alone)
    assert found.cost == pytest.approx(whole.cost, rel=1e-5)
    at = [found.index(id) for id in ("inertia", "Ks", "sigma2")]
    assert np.all(np.abs(found.theta - whole.theta)[at] < 0.05 * whole.std[at])


def test_far_above_the_noise_the_best_start_ends_in_a_minimum_of_all_rows():
    p = Problem.of(KernelSimulator.of(model()), recorded(ripple=0.01), OPTIONS)
    best = find_minima(p, Here()).best
    assert is_far(p, best)
    again = polish(p, best)
    assert again.cost > best.cost * (1.0 - 1e-3)
    assert np.sum(p.blocks(best.x, 0.0, jacobian=False).residual ** 2) == pytest.approx(best.cost)


def test_far_above_the_noise_a_start_ends_on_fewer_rows_with_the_cost_of_all():
    p = problem(recorded(ripple=0.03))
    ended = descend(p, p.unknowns_at(p.parametrisation.initial))
    assert is_far(p, ended)
    residual = p.blocks(ended.x, 0.0, jacobian=False).residual
    assert ended.cost == pytest.approx(float(residual @ residual))
    few = merge_problem(p, 2)
    assert few.weight == pytest.approx(p.weight / 2, rel=1e-3)
    assert not is_far(p, replace(ended, cost=np.inf))
