"""The nominal model of a joint whose bristles settle within a fraction of the usual inner step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.discrepancy.detect.inner_step import at_needed_step
from haptid.discrepancy.search.nominal_model import fit_nominal_model
from haptid.discrepancy.study.simulators import Factory
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.listener import ignore_progress

TRUE = {
    "inertia": 3.2, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.0, "epos": 0.0, "sigma0": 4e5,
    "sigma1": 300.0, "sigma2": 18.0, "vs": 0.02, "Fs": 5.5, "Fc": 4.0,
}  # fmt: skip
NOISE = 1.5e-6
FREE = ("inertia", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")


@pytest.fixture(scope="module")
def base() -> Equations:
    """Equations whose range of the stiffness in presliding ends below the true one."""
    equations = joint_equations(0)
    held = {id: {"initial": TRUE[id], "fixed": True} for id in TRUE if id not in FREE}
    free: dict[str, dict[str, object]] = {
        id: {"initial": 0.7 * TRUE[id], "lower": 0.01 * TRUE[id], "upper": 100.0 * TRUE[id]} for id in FREE
    }
    free["sigma0"] |= {"initial": 2e5, "upper": 3e5}
    return equations.with_parameters({**held, **free})


@pytest.fixture(scope="module")
def study(base: Equations) -> Study:
    """A sweep that reverses often, integrated at a step that shows nothing."""
    t = np.arange(0.0, 5.0, 0.005)
    u = (20.0 * np.cos(9.0 * t + 1.5 * t**2))[:, None]
    run = Run(
        file="sweep", free_joints=(0,), t=t, u=u, y=np.zeros((t.size, 1)), noise=np.array([NOISE]),
        resolution=np.zeros(1), posture=np.zeros(1), use="fit",
    )  # fmt: skip
    theta = np.array([TRUE[q.id] for q in base.parameters])
    exact = KernelSimulator.of(base).with_step(4e-6).simulate(theta, run).y
    seen = exact + NOISE * np.random.default_rng(3).standard_normal(exact.shape)
    return Study(joint=0, fitted=(run.but(y=seen),), unseen=(), base=base, catalogue={}, noise_given=True, own=FREE)


def test_a_joint_of_stiff_bristles_leaves_noise_alone_though_its_range_ended_below_them(study: Study) -> None:
    at, found = fit_nominal_model(study, seed=0, starts=2, tell=ignore_progress)
    assert at.factory.step < THRESHOLDS.study.coarse_step_s / 8
    assert at.factory.share < 1.0
    assert found.solution.chi2 < 1.1 * study.rows
    assert found.solution.values["sigma0"] == pytest.approx(TRUE["sigma0"], rel=0.02)


def test_a_range_that_is_stated_or_a_devices_stays(study: Study) -> None:
    at, found = fit_nominal_model(replace(study, own=()), seed=0, starts=2, tell=ignore_progress)
    assert at.base.parameter("sigma0").upper == study.base.parameter("sigma0").upper
    assert found.solution.chi2 > 1.5 * study.rows


@pytest.mark.parametrize("halvings", [0, 3, 4, 5])
def test_slopes_follow_the_readings_from_a_step_on(study: Study, halvings: int) -> None:
    step = THRESHOLDS.study.coarse_step_s / 2**halvings
    share = min(1.0, 8.0 / 2**halvings)
    assert at_needed_step(study, step).factory == Factory(step, share)
    made = Factory(step, share)(study.base)
    assert made.fine.step == step
    assert made.coarse.step == share * THRESHOLDS.study.coarse_step_s
    assert made.sketch == share * THRESHOLDS.study.signature_step_s
