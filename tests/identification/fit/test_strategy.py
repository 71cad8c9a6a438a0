"""Which runs are simulated freely, which through an observer, which have their torque scored."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

from haptid.identification.fit import strategy
from haptid.identification.fit.strategy import choose, choose_for, first_guess, fit_simulated, free_simulation
from haptid.identification.problem.options import FitOptions
from haptid.identification.simulators.error_growth import growth
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.observer import Observed
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from tests.real_data import DATA

NOISE = 2e-4
TRUE = {
    "inertia": 0.02,
    "gravity_cos": 0.0,
    "gravity_sin": 0.6,
    "Ks": 0.0,
    "epos": 0.0,
    "sigma0": 5.0,
    "sigma1": 0.02,
    "sigma2": 0.004,
    "vs": 0.1,
    "Fs": 0.012,
    "Fc": 0.01,
}


def pendulum(**changes: float) -> Equations:
    """Return a pendulum whose spring is known to be absent, with first guesses at ``TRUE`` and ``changes``."""
    equations = joint_equations(0).with_parameters(
        {id: {"initial": value, "lower": value / 30, "upper": value * 30} for id, value in TRUE.items() if value > 0}
    )
    absent = {id: {"initial": 0.0, "fixed": True} for id in ("gravity_cos", "Ks", "epos")}
    return equations.with_parameters(absent | {id: {"initial": value} for id, value in changes.items()})


def run_of(t: Array, torque: Array, position: Array, file: str = "a.csv", use: str = "fit") -> Run:
    return Run(
        file=file,
        free_joints=(0,),
        t=t,
        u=torque[:, None],
        y=position[:, None],
        noise=[NOISE],
        resolution=[0.0],
        posture=np.zeros(1),
        use=use,
    )


def swung(amplitude: float, seed: int) -> Run:
    """Return a pendulum that a cosine torque swings, over the top from 0.2 N m on, measured with white noise."""
    simulator, t = KernelSimulator.of(pendulum()), np.arange(0.0, 10.0, 0.005)
    torque = amplitude * np.cos(4.6 * t)
    clean = run_of(t, torque, np.zeros_like(t))
    y = simulator.simulate(first_guess(simulator), clean).y
    return clean.but(y=y + NOISE * np.random.default_rng(seed).standard_normal(y.shape))


def test_growth_of_an_inverted_pendulum_is_the_hyperbolic_cosine() -> None:
    equations = pendulum(sigma0=5.0 / 30, sigma2=0.004 / 30)
    equations = equations.with_parameters({"gravity_sin": {"lower": -2.0, "initial": -0.6}})
    simulator, t = KernelSimulator.of(equations), np.arange(0.0, 1.0, 0.005)
    theta = first_guess(simulator)
    found = growth(simulator, theta, run_of(t, np.zeros_like(t), np.zeros_like(t)))
    # About the rest on top, the bristle is a spring sigma0 that starts relaxed, with damping sigma1 + sigma2.
    bristle, damping, inertia = 5.0 / 30, 0.02 + 0.004 / 30, 0.02
    A = np.array([[0.0, 1.0, 0.0], [0.6 / inertia, -damping / inertia, -bristle / inertia], [0.0, 1.0, 0.0]])
    assert found == pytest.approx(expm(A * t[-1])[0, 0], rel=0.01)


def test_small_swings_are_simulated_freely_and_wild_ones_through_an_observer() -> None:
    simulator = KernelSimulator.of(pendulum())
    theta = first_guess(simulator)
    assert choose(swung(0.05, 1), simulator, theta).kind == "open_loop"
    wild = choose(swung(0.5, 2), simulator, theta)
    assert wild.kind == "observer"
    assert wild.gain >= 5.0
    assert "grows" in wild.reason
    assert "a.csv" in wild.reason


def test_one_observer_for_all_runs_forgets_faster_than_the_fastest_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which run's error grew beyond the limit hung on the last digit of the estimates, and with it the gain."""
    simulator = KernelSimulator.of(pendulum())
    gains = {"slow.csv": 10.0, "fast.csv": 30.0}
    monkeypatch.setattr(strategy, "observer_gain", lambda run: gains[run.file])
    runs = [swung(0.5, 2).but(file=file) for file in gains]
    theta = first_guess(simulator)
    for growing in gains:
        monkeypatch.setattr(strategy, "growth", lambda _s, _t, run, growing=growing: 1e4 * (run.file == growing))
        chosen = choose_for(runs, simulator, theta)
        assert chosen.kind == "observer"
        assert growing in chosen.reason
        assert chosen.gain == 30.0


def test_observed_never_falls_below_its_gain() -> None:
    simulator, run = KernelSimulator.of(pendulum(inertia=0.03)), swung(0.05, 1)
    theta = first_guess(simulator)
    seen = Observed(simulator, 20.0)
    assert np.array_equal(seen.simulate(theta, run).y, simulator.simulate(theta, run, gain=20.0).y)
    assert np.array_equal(seen.simulate(theta, run, gain=60.0).y, simulator.simulate(theta, run, gain=60.0).y)
    assert seen.equations is simulator.equations


def test_wild_swing_is_fitted_through_the_observer_down_to_the_noise() -> None:
    run = swung(0.5, 3)
    simulator = KernelSimulator.of(pendulum(inertia=0.026, gravity_sin=0.5, sigma2=0.008, Fc=0.006))
    # Of two starts both may end at a bound in the free simulation that is tried first, by the last bit of the kernel.
    found = fit_simulated(simulator, (run,), options=FitOptions(method="gauss_newton", starts=4))
    assert found.values["inertia"] == pytest.approx(TRUE["inertia"], rel=0.01)
    assert found.values["gravity_sin"] == pytest.approx(TRUE["gravity_sin"], rel=0.01)
    assert found.runs[0].over_noise < 1.05
    assert any("observer of gain" in note for note in found.notes)
    assert any("a free simulation leaves" in note and note.endswith(" rad") for note in found.notes)


def test_a_torque_that_the_model_lacks_stays_visible_under_the_observer() -> None:
    run = swung(0.5, 3)
    ripple = run.but(u=run.u - 0.01 * np.cos(2.0 * run.y))
    simulator = KernelSimulator.of(pendulum(inertia=0.026, gravity_sin=0.5, sigma2=0.008, Fc=0.006))
    found = fit_simulated(simulator, (ripple,), options=FitOptions(method="gauss_newton", starts=2))
    assert found.values["inertia"] == pytest.approx(TRUE["inertia"], rel=0.05)
    assert found.values["gravity_sin"] == pytest.approx(TRUE["gravity_sin"], rel=0.05)
    assert found.runs[0].over_noise > 5
    assert found.outcome.name == "OBSERVED"


def test_fit_of_a_small_swing_is_free() -> None:
    simulator = KernelSimulator.of(pendulum(inertia=0.026))
    found = fit_simulated(simulator, (swung(0.05, 1),), options=FitOptions(method="gauss_newton", starts=1))
    assert found.notes == ()
    assert found.runs[0].over_noise < 1.1


def test_embedded_campaign_is_simulated_freely_but_for_the_controlled_runs() -> None:
    campaign = campaign_for_command(embedded_campaign("paper"))
    device = load_device("freedom6s")
    for joints in ((1,), (4,), (0, 1)):
        simulator = KernelSimulator.of(configuration_equations(device, joints))
        assert choose_for(campaign.runs_of(joints), simulator, first_guess(simulator)).kind == "open_loop"
    controlled = choose(campaign.runs_of((0, 1, 2, 3, 4, 5))[0])
    assert controlled.kind == "observer"
    assert "reference" in controlled.reason


@pytest.mark.real("dvrk_mtm_joint4")
def test_real_sweep_has_its_torque_scored() -> None:
    chosen = choose_for(read_campaign(DATA / "dvrk_mtm_joint4").runs)
    assert chosen.kind == "torque"
    assert "constant speed" in chosen.reason


@pytest.mark.real("dfki_double_pendulum_a0")
@pytest.mark.filterwarnings("ignore::haptid.measurement.values.warning.CampaignWarning")
def test_real_double_pendulum_needs_an_observer() -> None:
    campaign = read_campaign(DATA / "dfki_double_pendulum_a0")
    simulator = KernelSimulator.of(configuration_equations(load_device("double_pendulum"), (0, 1)))
    kinds = [choose(run, simulator, first_guess(simulator)).kind for run in campaign.runs]
    assert kinds == ["open_loop"] * 3 + ["observer"] * 3
    assert choose_for(campaign.runs, simulator, first_guess(simulator)).kind == "observer"


def test_a_free_simulation_of_a_stage_is_told_in_metres() -> None:
    simulator, run = KernelSimulator.of(pendulum()), swung(0.05, 1)
    found = SimpleNamespace(theta=first_guess(simulator), x0={})
    (turns,) = free_simulation(simulator, found, (run,))  # type: ignore[arg-type] # all that is read of a fit
    (slides,) = free_simulation(simulator, found, (run.but(prismatic=(True,)),))  # type: ignore[arg-type] # as above
    assert turns.endswith(" rad")
    assert slides.endswith(" m")
