"""A stage with dry friction under a controller: torque and position in one cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from haptid import Campaign
from haptid.identification.fit.joint_cost import move_by_position
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.values.run import Run
from tests.discrepancy.torque.sticking_stage import recorded_stage

OPTIONS = FitOptions(starts=1, method="gauss_newton")


@dataclass(frozen=True)
class Case:
    simulator: KernelSimulator
    runs: tuple[Run, ...]
    torque: Fit
    both: Fit

    def free_rms(self, fit: Fit, use: str) -> float:
        errors = [run.y - self.simulator.simulate(fit.theta, run).y for run in self.runs if run.use == use]
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def waves(seed: int) -> Callable[[float], float]:
    return lambda t: 0.1 * np.sin(3.0 * t + seed) + 0.05 * np.sin(7.3 * t + 2.0 * seed)


@pytest.fixture(scope="module")
def case() -> Case:
    frames = {
        name: recorded_stage(waves(seed), seed, 12.0, P=2e4, I=0.0, D=400.0)
        for name, seed in (("a", 1), ("b", 2), ("c", 3))
    }
    # Viscous friction is a tenth larger in one direction: what no parameter is, and a free simulation drifts by.
    for frame in frames.values():
        frame["force_0_N"] += 2.0 * frame["position_0_m"].diff().fillna(0.0).abs() / frame["time_s"].diff().fillna(1.0)
    campaign = prepare_campaign(Campaign.from_frames(frames, validate=["c"], measured=False).values)
    equations, runs = equations_for(campaign, None, (0,)), campaign.runs_of((0,))
    simulator = KernelSimulator.of(equations)
    torque = fit_torque(equations, runs, options=OPTIONS)
    both = fit_torque(equations, runs, position=simulator, options=OPTIONS)
    return Case(simulator, runs, torque, both)


def test_a_free_simulation_drifts_less_within_the_errors_of_the_torque(case: Case):
    assert case.free_rms(case.both, "fit") < 0.99 * case.free_rms(case.torque, "fit")
    assert case.free_rms(case.both, "validate") < 1.05 * case.free_rms(case.torque, "validate")
    std = np.sqrt(np.diag(case.torque.covariance))
    for id, error in zip(case.torque.free, std, strict=True):
        assert abs(case.both.values[id] - case.torque.values[id]) <= 2.0 * error + 1e-12
    assert any("held by one cost" in note for note in case.both.notes)
    # The torques are scored where the parameters are now.
    before, after = ({(r.file, r.use): r.rmse_rad for r in one.runs} for one in (case.torque, case.both))
    assert before.keys() == after.keys()
    assert all(after[key] != before[key] for key in before)
    assert all(after[key] < 1.1 * before[key] for key in before)


def test_a_simulation_that_left_the_motion_moves_nothing(case: Case):
    far = case.torque.theta.copy()
    far[[q.id for q in case.torque.equations.parameters].index("gravity_cos")] += 4.0
    assert move_by_position(case.torque.but(theta=far), case.simulator, case.runs, 0.0) is None
