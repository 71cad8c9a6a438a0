"""A lag is named where the torque arrives late, not where it takes the place of the joint's inertia."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.discrepancy.finding import soundness
from haptid.discrepancy.finding.soundness import judge_soundness
from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.discrepancy.torque.free_simulation import free_rms
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.discrepancy.torque_search.rigid_body import find_movers, is_far
from haptid.discrepancy.torque_search.scan import Promise
from haptid.discrepancy.torque_search.search import refit_candidate, search_torque
from haptid.identification.simulators.inverse_dynamics import torque_run
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.linear_algebra import rms
from haptid.support.listener import ignore_progress

INERTIA, VISCOUS = 0.02, 0.06
LAG = "amplifier_lag:settled"


def moved(seed: int, *, lag: float, lacks: float, coulomb: float) -> Run:
    """Return a run along sines, whose torque arrives late and whose friction changes with position."""
    t = np.arange(0.0, 12.0, 0.005)
    rng = np.random.default_rng(seed)
    q, v, a, jerk = (np.zeros(t.size) for _ in range(4))
    for frequency in (0.7, 1.9, 4.1):
        phase, size = rng.uniform(0, 2 * np.pi), 0.5 / frequency
        q += size * np.sin(frequency * t + phase)
        v += size * frequency * np.cos(frequency * t + phase)
        a -= size * frequency**2 * np.sin(frequency * t + phase)
        jerk -= size * frequency**3 * np.cos(frequency * t + phase)
    sign, slope = np.tanh(v / 0.02), 1.0 - np.tanh(v / 0.02) ** 2
    level = coulomb * (1.0 + lacks * np.sin(3.0 * q))
    needed = INERTIA * a + VISCOUS * v + level * sign
    rate = INERTIA * jerk + VISCOUS * a + level * slope * a / 0.02 + coulomb * lacks * 3.0 * np.cos(3.0 * q) * v * sign
    tau = needed + lag * rate + 1e-4 * rng.standard_normal(t.size)
    return Run(
        t=t, u=tau[:, None], y=q[:, None], noise=np.array([1e-6]), resolution=np.array([0.0]), free_joints=(4,),
        use="validate" if seed == 3 else "fit", file=f"r{seed}.csv", posture=np.zeros(1), hold="linear",
        prismatic=(False,),
    )  # fmt: skip


def study(*, lag: float, lacks: float, coulomb: float = 0.02) -> TorqueStudy:
    recorded = tuple(moved(seed, lag=lag, lacks=lacks, coulomb=coulomb) for seed in (1, 2, 3))
    known = {id: {"initial": 0.0, "fixed": True} for id in ("gravity_cos", "gravity_sin", "Ks", "epos")}
    guesses = {
        "Kp": {"initial": 1.0, "fixed": True}, "inertia": {"initial": 0.02, "lower": 2e-4, "upper": 2.0},
        "Fc": {"initial": 0.02, "lower": 2e-4, "upper": 2.0}, "Fs": {"initial": 0.02, "lower": 2e-4, "upper": 2.0},
        "sigma2": {"initial": 0.06, "lower": 6e-4, "upper": 6.0}, "sigma0": {"initial": 3.0},
    }  # fmt: skip
    base = joint_equations(4).with_parameters(known | guesses)
    runs = tuple(torque_run(run) for run in recorded)
    seen = tuple(np.full(run.t.size, run.use == "fit") for run in runs)
    return TorqueStudy(joint=4, runs=runs, seen=seen, base=base, prismatic=False, recorded=recorded)


@pytest.fixture(scope="module")
def without_lag() -> tuple[TorqueFit, TorqueFit]:
    """Fit a joint whose friction changes with position: the nominal model, and one with a lag instead of inertia."""
    base = fit_model(study(lag=0.0, lacks=2.0, coulomb=0.005))
    lag = catalogue()[LAG].at(base.study.scales(base.values))
    return base, fit_model(base.study, (lag,), base.values | {"settled_lag_time": 0.3})


def test_the_last_digits_of_the_start_do_not_decide_where_a_fit_ends(without_lag):
    """Friction that no torque tells was moved by rounding, and every fit ended in another minimum."""
    base, swapped = without_lag
    rng, left = np.random.default_rng(0), []
    for _ in range(3):
        start = {id: value * (1.0 + 1e-9 * rng.standard_normal()) for id, value in base.values.items()}
        fit = fit_model(base.study, swapped.effects, start | {"settled_lag_time": 0.3})
        left.append(rms(fit.fitted))
    assert left == pytest.approx([rms(swapped.fitted)] * 3, rel=1e-3)


def test_a_lag_in_the_place_of_the_inertia_fits_and_predicts_better_and_is_told(without_lag):
    base, swapped = without_lag
    assert rms(swapped.fitted) < 0.9 * rms(base.fitted)
    assert rms(swapped.unseen) < 0.9 * rms(base.unseen)
    assert swapped.values["settled_lag_time"] == pytest.approx(INERTIA / VISCOUS, rel=0.2)
    assert find_movers(base, swapped) == {LAG}
    assert judge_soundness(base, swapped, None, None).movers == {LAG}


def test_a_refit_with_a_lag_keeps_the_inertia_where_it_can(without_lag):
    base, swapped = without_lag
    promise = Promise(effect=swapped.effects[0], share=0.5, start={"settled_lag_time": 0.3}, columns=1)
    refitted = refit_candidate(base.study, base, promise)
    assert rms(refitted.fitted) > rms(swapped.fitted)
    assert refitted.values["inertia"] == pytest.approx(INERTIA, rel=0.1)


def test_a_lag_in_the_place_of_the_inertia_is_not_taken(without_lag, monkeypatch):
    base, swapped = without_lag
    monkeypatch.setattr("haptid.discrepancy.torque_search.search.refit_candidate", lambda *_, **__: swapped)
    found = search_torque(base.study, {LAG: catalogue()[LAG]}, starts=1, seed=0, tell=ignore_progress)
    (candidate,) = found.steps[0].candidates
    assert candidate.predicts_better
    assert candidate.bic > 0.0
    assert not candidate.acceptable
    assert not candidate.plausible
    assert found.final.effects == ()


@pytest.mark.parametrize("lag", [0.03, 0.2])
def test_a_torque_that_arrives_late_is_named(lag: float):
    """The joint's own time constant is a third of a second; the longer lag makes its inertia look twice as large."""
    hidden = study(lag=lag, lacks=0.0)
    found = search_torque(hidden, {LAG: catalogue()[LAG]}, starts=1, seed=0, tell=ignore_progress)
    assert [effect.key for effect in found.final.effects] == [LAG]
    assert found.final.values["settled_lag_time"] == pytest.approx(lag, rel=0.15)
    assert found.final.values["inertia"] == pytest.approx(INERTIA, rel=0.15)
    assert not find_movers(found.base, found.final)


@pytest.mark.parametrize(
    ("before", "after", "error", "far"),
    [(24.0, 0.73, 1.3, True), (24.0, 13.0, 1.3, False), (24.0, 50.0, 1.3, True), (24.0, 0.73, 12.0, False)],
)
def test_an_inertia_is_far_beyond_a_factor_and_its_errors(before: float, after: float, error: float, far: bool):
    assert is_far(before, after, error) is far


def test_a_free_simulation_of_unseen_runs_misses_more_with_a_wrong_inertia():
    good = fit_model(study(lag=0.0, lacks=0.0))
    lower = replace(good, x=good.problem.unknowns_at(good.theta * np.where(ids_of(good) == "inertia", 0.3, 1.0)))
    assert free_rms(good) < 0.05
    assert free_rms(lower) > 2.0 * free_rms(good)
    assert free_rms(replace(good, study=replace(good.study, recorded=()))) is None


def ids_of(model: TorqueFit) -> np.ndarray:
    return np.array([q.id for q in model.problem.simulator.equations.parameters])


@pytest.mark.parametrize(("with_lag", "doubted"), [(0.021, {LAG}), (0.0145, set())])
def test_effects_with_which_unseen_runs_are_simulated_clearly_worse_are_doubted(
    without_lag, monkeypatch, with_lag: float, doubted: set[str]
):
    base, _ = without_lag
    lag = catalogue()[LAG].at(base.study.scales(base.values))
    monkeypatch.setattr(soundness, "free_rms", lambda model: with_lag if model.effects else 0.01)
    short = fit_model(base.study, (lag,), base.values | {"settled_lag_time": 0.01})
    judged = judge_soundness(base, short, None, None)
    assert judged.worsening == judged.doubted == doubted
    assert judged.free == (0.01, with_lag)


def test_no_free_simulation_is_asked_where_the_runs_do_not_tell_the_inertia(without_lag, monkeypatch):
    base, swapped = without_lag
    monkeypatch.setattr(soundness, "tells_inertia", lambda _: False)
    assert judge_soundness(base, swapped, None, None).free is None
