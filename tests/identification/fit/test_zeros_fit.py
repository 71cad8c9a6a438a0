"""Encoders that are zeroed where the joint rests: a pendulum whose reading has another zero in every run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.fmu_build.building.cached import identification_fmu
from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.fit.fit_runs import Fitted, JointTest, fit_runs
from haptid.identification.fit.zeros_fit import correct_readings, encoder_zeros, fit_with_zeros, in_positions
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.result_json import fit_from_json, step_json
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.encoder_zero import is_felt, with_encoder_zeros, zero_states
from haptid.model.joint.locked_joint import joint_equations
from tests.identification.fit.test_own_bounds import TRUE, runs, swung

ZEROS = (0.06, -0.05, 0.02, -0.08)
"""Readings of the hanging pendulum in the runs [rad]: friction holds it within ±0.15 rad."""
OPTIONS = FitOptions(method="gauss_newton", starts=2)


def shifted() -> tuple[Run, ...]:
    return tuple(replace(run, y=run.y + zero) for run, zero in zip(runs(), ZEROS, strict=True))


def first_guess(of: tuple[Run, ...]) -> Equations:
    return guess(joint_equations(0), [run for run in of if run.use == "fit"], given={})


def fit_position(equations: Equations, options: FitOptions, of: tuple[Run, ...]) -> Fit:
    test = JointTest(equations=equations, build=KernelSimulator.of, runs=of)
    return fit_runs(test, options=options).fit


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    test = JointTest(equations=first_guess(shifted()), build=KernelSimulator.of, runs=shifted())
    return fit_runs(test, options=OPTIONS)


@pytest.mark.long
def test_every_run_gets_its_zero_and_the_parameters_are_right(fitted: Fitted) -> None:
    fit = fitted.fit
    assert max(score.over_noise for score in fit.runs) < 1.2
    zeros = encoder_zeros(fit)
    # The prior of the zeros has the mean 0, so that the weight's direction takes their common part.
    common = np.arctan2(fit.values["gravity_cos"], fit.values["gravity_sin"])
    for run, zero in zip(shifted(), ZEROS, strict=True):
        assert float(zeros[run.file][0]) - common == pytest.approx(zero, abs=5e-3)
    for id in ("inertia", "Fc", "sigma2"):
        assert abs(fit.values[id] - TRUE[id]) < 3.0 * fit.std[fit.index(id)], id
    weight = np.hypot(fit.values["gravity_cos"], fit.values["gravity_sin"])
    assert weight == pytest.approx(TRUE["gravity_sin"], rel=0.01)


def test_without_zeros_of_their_own_the_same_runs_stay_far_above_the_noise(fitted: Fitted) -> None:
    found = fit_position(fitted.fit.equations, OPTIONS, runs())
    # Their common part is the weight's direction, of which the prior of the zeros tells next to nothing.
    zeros = [float(zero[0]) for zero in encoder_zeros(found).values()]
    assert not zeros or np.ptp(zeros) < 1e-3
    (fit,) = [one for one in (fitted.fit,) if zero_states(one.equations)]
    held = fit.equations.with_parameters({})
    flat = replace(held, states=tuple(replace(state, start_std=0.0) for state in held.states))
    left = [np.sqrt(np.mean((run.y - KernelSimulator.of(flat).simulate(fit.theta, run).y) ** 2)) for run in shifted()]
    assert min(left) > 10.0 * runs()[0].sensor_std[0]


def test_another_missing_effect_is_not_taken_for_a_zero() -> None:
    ripple = (
        swung([0.35, 0.25, 0.2], [1.1, 3.7, 6.1], seed=1, ripple=0.03),
        swung([0.5], [2.3], seed=2, ripple=0.03),
        swung([0.3], [1.7], use="validate", seed=3, ripple=0.03),
    )
    found = fit_position(first_guess(ripple), OPTIONS, ripple)
    assert encoder_zeros(found) == {}


def test_a_zero_far_outside_its_prior_is_a_constant_torque_of_the_run(fitted: Fitted) -> None:
    plain, zeroed = below_and_above(fitted.fit)
    (k,) = zero_states(zeroed.equations)
    first, *others = zeroed.x0.items()
    far = first[1].copy()
    far[k] = 8.0 * zeroed.equations.states[k].start_std
    assert fit_with_zeros(lambda *_: zeroed, lambda *_: zeroed, plain, shifted(), OPTIONS) is not None
    beyond = zeroed.but(x0=dict([(first[0], far), *others]))
    assert fit_with_zeros(lambda *_: beyond, lambda *_: beyond, plain, shifted(), OPTIONS) is None


def test_zeros_that_predict_the_unseen_run_worse_are_left(fitted: Fitted) -> None:
    plain, zeroed = below_and_above(fitted.fit)
    worse = [replace(score, over_noise=400.0) if score.use == "validate" else score for score in zeroed.runs]
    bad = zeroed.but(runs=tuple(worse))
    assert fit_with_zeros(lambda *_: bad, lambda *_: zeroed, plain, shifted(), OPTIONS) is None


def below_and_above(zeroed: Fit) -> tuple[Fit, Fit]:
    """Return the same fit as one without zeros, forty times the noise, and as it is."""
    basins = tuple(replace(basin, over_noise=40.0) for basin in zeroed.basins)
    scores = tuple(replace(score, over_noise=40.0) for score in zeroed.runs)
    return in_positions(zeroed).but(basins=basins, runs=scores), zeroed


def test_one_run_or_a_joint_without_weight_and_spring_has_no_zero(fitted: Fitted) -> None:
    def never(equations: Equations, options: FitOptions) -> Fit:
        pytest.fail(f"{equations.name} was fitted with {options.starts} starts")

    assert fit_with_zeros(never, never, fitted.fit, shifted()[:1], OPTIONS) is None
    gone = {"fixed": True, "initial": 0.0, "lower": 0.0, "upper": 0.0}
    free = joint_equations(0).with_parameters(dict.fromkeys(("gravity_cos", "gravity_sin", "Ks"), gone))
    assert not is_felt(free, 0)
    assert fit_with_zeros(never, never, fitted.fit.but(equations=free), shifted(), OPTIONS) is None


def test_a_zero_shifts_the_position_at_which_forces_act_and_nothing_else() -> None:
    base, zero = joint_equations(0), 0.07
    zeroed = with_encoder_zeros(base, [0.1])
    theta = np.array([q.initial for q in base.parameters])
    run = runs()[0]
    positions = replace(run, y=run.y - zero)
    (k,) = zero_states(zeroed)
    simulator = KernelSimulator.of(zeroed)
    x0 = np.array([state.start for state in zeroed.states])
    x0[0], x0[k] = run.y[0, 0], zero
    with_zero = simulator.simulate(theta, run, x0=x0, sensitivities=True)
    without = KernelSimulator.of(base).simulate(theta, positions)
    assert np.abs(with_zero.y - zero - without.y).max() < 1e-9
    step = 1e-6
    ahead, behind = (simulator.simulate(theta, run, x0=x0 + sign * step * np.eye(x0.size)[k]).y for sign in (1, -1))
    assert with_zero.dy_dx0 is not None
    assert np.abs(with_zero.dy_dx0[..., k] - (ahead - behind) / (2 * step)).max() < 1e-4


def test_the_fmu_takes_the_zero_as_the_kernel_does() -> None:
    zeroed = with_encoder_zeros(joint_equations(0), [0.1])
    theta, run = np.array([q.initial for q in zeroed.parameters]), runs()[1]
    x0 = np.array([state.start for state in zeroed.states])
    x0[list(zero_states(zeroed))] = -0.04
    fmu = FmuSimulator.of(identification_fmu(zeroed, kind="native"), zeroed)
    assert (
        np.abs(fmu.simulate(theta, run, x0=x0).y - KernelSimulator.of(zeroed).simulate(theta, run, x0=x0).y).max()
        < 1e-12
    )


def test_a_fit_in_positions_simulates_the_corrected_runs_as_before(fitted: Fitted) -> None:
    fit, positions = fitted.fit, in_positions(fitted.fit)
    assert positions.equations.digest == joint_equations(0).digest
    before, after = KernelSimulator.of(fit.equations), KernelSimulator.of(positions.equations)
    zeros = encoder_zeros(fit)
    for run, corrected in zip(shifted(), correct_readings(shifted(), zeros), strict=True):
        if run.use == "fit":
            reading = before.simulate(fit.theta, run, x0=fit.x0[run.file]).y
            position = after.simulate(fit.theta, corrected, x0=positions.x0[run.file]).y
            assert np.abs(reading - zeros[run.file] - position).max() < 1e-9


def test_the_zeros_survive_the_file_of_results(fitted: Fitted) -> None:
    configuration = Configuration(free_joints=(0,), posture=(), runs=shifted())
    entry = step_json(Step(configuration=configuration, fit=fitted.fit, compared=fitted.compared))
    assert "differ from run to run" in entry["why"]
    again = fit_from_json(entry, joint_equations(0))
    assert [s.id for s in again.equations.states] == [s.id for s in fitted.fit.equations.states]
    zeros = encoder_zeros(again)
    assert {file: zero.tolist() for file, zero in zeros.items()} == entry["encoder_zeros"]["runs"]
    positions = correct_readings(shifted(), zeros)
    assert all(np.ptp(run.y - one.y) < 1e-15 for run, one in zip(shifted(), positions, strict=True))
