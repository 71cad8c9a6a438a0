"""Signals for figures are those of the fit: at its parameters, its initial states and its inner step."""

from __future__ import annotations

import numpy as np

from haptid.identification.output.traces import traces_of
from haptid.identification.result.fit import Fit, RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import initial_state
from haptid.model.thresholds import THRESHOLDS
from tests.identification.bench_joint import TRUE, equations, make_run

FINE = THRESHOLDS.inner_step_s / 8
STIFF = {**TRUE, "sigma0": 5e3, "sigma1": 2.0}
"""Bristles that settle within a small part of the model's own inner step."""


def test_a_trace_has_the_inner_step_of_the_fit():
    """A run that a fit left at the noise was drawn with waves of several times the noise."""
    run, own = make_run(0.005, 1.13), equations()
    theta = np.array([STIFF.get(q.id, q.initial) for q in own.parameters])
    free = tuple(q.id for q in own.parameters if not q.fixed)
    x0 = initial_state(own, run)
    score = RunScore(file=run.file, use="fit", rmse=np.array([1e-4]), over_noise=1.0, nrmse=0.01, x0=x0)
    fit = Fit(
        equations=own, theta=theta, free=free, covariance=np.zeros((len(free),) * 2), information=np.eye(len(free)),
        cost=1.0, outcome=Outcome.CONVERGED, basins=(), starts=1, x0={}, sigma={}, correlation_time=1.0, simulations=1,
        wall_s=0.0, statuses={}, runs=(score,), inner_step=FINE,
    )  # fmt: skip
    step = Step(configuration=Configuration(free_joints=(4,), posture=(), runs=(run,)), fit=fit)
    (trace,) = traces_of(step, KernelSimulator.of)
    simulator = KernelSimulator.of(own)
    np.testing.assert_allclose(trace.simulated, simulator.with_step(FINE).simulate(theta, run, x0=x0).y, atol=1e-12)
    coarse = simulator.simulate(theta, run, x0=x0).y
    assert np.abs(coarse - trace.simulated).max() > 1e-5
