"""An unseen run whose initial state leaves much open is no alarm; one that the model does not explain is."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.statistics.score import score
from haptid.identification.statistics.unseen import rms_beyond_left_open
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations

NOISE = 3e-4
TRUE = {
    "inertia": 5e-3, "gravity_sin": 0.3, "sigma0": 20.0, "sigma1": 0.1, "sigma2": 6e-3, "vs": 0.2, "Fs": 0.02,
    "Fc": 0.02,
}  # fmt: skip
OPTIONS = FitOptions(method="gauss_newton", starts=1, workers=1)


def pendulum() -> Equations:
    fixed = {id: {"fixed": True, "initial": 0.0} for id in ("gravity_cos", "Ks", "epos")}
    held = {id: {"fixed": True, "initial": TRUE[id]} for id in ("sigma0", "sigma1", "vs", "Fs")}
    guesses = {id: {"initial": value} for id, value in TRUE.items() if id not in held}
    return joint_equations(0).with_parameters(fixed | held | guesses)


def swung(size: float, omega: float, use: str, seed: int, ripple: float = 0.0) -> Run:
    """A pendulum that a cosine swings, and a ripple that is not in the recorded torque."""
    t = np.arange(0.0, 12.0, 0.01)
    u = size * np.cos(omega * t)
    made = Run(
        file=f"{use}{seed}.csv", free_joints=(0,), posture=(), t=t, u=(u + ripple * np.sin(3.0 * t))[:, None],
        y=np.zeros((t.size, 1)), noise=[NOISE], resolution=[0.0], use=use,
    )  # fmt: skip
    simulator = KernelSimulator.of(pendulum())
    y = simulator.simulate(np.array([q.initial for q in pendulum().parameters]), made).y
    return made.but(u=u[:, None], y=y + np.random.default_rng(seed).normal(0.0, NOISE, y.shape))


FITTED = (swung(0.25, 3.0, "fit", 1), swung(0.2, 4.5, "fit", 2))


def test_an_error_of_the_initial_state_is_explained_and_a_missing_torque_is_not():
    simulator = KernelSimulator.of(pendulum())
    found = fit(simulator, FITTED, options=OPTIONS)
    unseen = swung(0.22, 3.7, "validate", 3)
    near = score(simulator, found, unseen).x0
    off = near.copy()
    off[0] += 2e-3
    far = score(simulator, found, unseen, x0=off)
    assert far.over_noise > 1.5
    assert rms_beyond_left_open(simulator, found, unseen, far) == pytest.approx(1.0, abs=0.1)
    lacking = swung(0.22, 3.7, "validate", 3, ripple=0.01)
    missed = score(simulator, found, lacking)
    assert rms_beyond_left_open(simulator, found, lacking, missed) > 0.5 * missed.over_noise > 5.0


@pytest.mark.parametrize(("ripple", "outcome"), [(0.0, Outcome.SINGLE_START), (0.01, Outcome.UNSEEN)])
def test_only_a_run_beyond_what_was_left_open_is_an_alarm(
    monkeypatch: pytest.MonkeyPatch, ripple: float, outcome: Outcome
):
    """A swing whose first rows told its initial state to 13 µrad was 3.2 times the noise, of a model that was right."""
    module = "haptid.identification.fit.multistart"

    def score_off(simulator: object, found: object, run: Run, **_: object) -> object:
        off = score(simulator, found, run).x0.copy()
        off[0] += 2e-3
        return score(simulator, found, run, x0=off)

    monkeypatch.setattr(f"{module}.score", score_off)
    found = fit(KernelSimulator.of(pendulum()), [*FITTED, swung(0.22, 3.7, "validate", 3, ripple)], options=OPTIONS)
    assert found.outcome is outcome
    told = [warning for warning in found.warnings if "validate3.csv" in warning]
    assert len(told) == (outcome is Outcome.SINGLE_START)
    if told:
        assert "explain but for 1" in told[0] or "explain but for 0.9" in told[0]
