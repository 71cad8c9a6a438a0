"""The delay between torque and motion: found where there is one, none where there is none, and told."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from haptid.identification.baseline.baseline import delay_of_torque, fit_baseline
from haptid.identification.baseline.compared import compare
from haptid.identification.baseline.delay import Delay, with_delayed_torque
from haptid.identification.baseline.prediction import predict_unseen
from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.output.plain_comparison import tell_delay
from haptid.identification.output.summary import tell_summary
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.result_json import step_json
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.inverse_dynamics import torque_run
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Array, Run
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.tables import text_of
from tests.identification.plain_joint import plain_run, torque_at

ROW = 2e-3
"""Interval of rows of the simulated joint [s]."""
TORQUE_NOISE = 0.02


def recorded_early(run: Run, seed: int, rows: float) -> Run:
    """Return a run of `plain_run` whose torque acts ``rows`` rows after it was recorded, with noise."""
    early = np.array([torque_at(t + rows * ROW, seed) for t in run.t])
    noise = TORQUE_NOISE * np.random.default_rng(1000 + seed).standard_normal(run.t.size)
    return run.but(u=(early + noise)[:, None])


def swinging(seed: int, *, bristle: float = 0.0, fast_delay: float = 0.0) -> Run:
    """Return a joint along sines of its own, with the torque that they need, and noise on both.

    ``bristle`` is the travel before dry friction slides [rad]; ``fast_delay`` shifts the torque of the fast sine alone
    [s].
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 12.0, ROW)
    rates, sizes = np.array([3.0, 7.1, 300.0]), np.array([0.8, 0.3, 3e-4])
    phases = rng.uniform(0.0, 2.0 * np.pi, 3)

    def motion(at: Array, order: int) -> Array:
        angles = rates[:, None] * at + phases[:, None] + 0.5 * np.pi * order
        return sizes[:, None] * rates[:, None] ** order * np.sin(angles)

    q, v, a = (motion(t, order).sum(axis=0) for order in range(3))
    later = t + fast_delay
    inertial = 0.05 * (a - motion(t, 2)[2] + motion(later, 2)[2]) + 0.03 * v
    turned = np.sign(v)
    if bristle:
        z = 0.0
        for k, step in enumerate(np.diff(q, prepend=q[0])):
            z = np.sign(step) + (z - np.sign(step)) * np.exp(-abs(step) / bristle)
            turned[k] = z
    torque = inertial + 0.8 * np.sin(q) + 0.12 * turned + TORQUE_NOISE * rng.standard_normal(t.size)
    return Run(
        file=f"swing_{seed}.csv", free_joints=(0,), t=t, u=torque[:, None],
        y=(q + 1e-4 * rng.standard_normal(t.size))[:, None], noise=[1e-4], resolution=[0.0], posture=np.zeros(0),
        use="fit", hold="linear",
    )  # fmt: skip


@pytest.fixture(scope="module")
def prompt() -> list[Run]:
    return [plain_run(5), plain_run(6), plain_run(7, use="validate")]


@pytest.fixture(scope="module")
def late(prompt: list[Run]) -> list[Run]:
    return [recorded_early(run, seed, 3.7) for run, seed in zip(prompt, (5, 6, 7), strict=True)]


@pytest.mark.parametrize("rows", [0.4, 1.0, 3.7, -2.3])
def test_a_delay_of_either_sign_is_found_within_two_standard_errors(prompt: list[Run], rows: float):
    runs = [recorded_early(run, seed, rows) for run, seed in zip(prompt, (5, 6, 7), strict=True)]
    delay = fit_baseline(runs, None, (), [1.0]).delay
    assert delay is not None
    assert delay.rows == pytest.approx(delay.value / ROW)
    assert abs(delay.value - rows * ROW) < 2.0 * delay.std
    assert delay.std < 0.2 * ROW
    assert delay.held_out_gain > 0.0


def test_a_joint_without_a_delay_gets_none():
    claims = [seed for seed in range(20) if delay_of_torque([swinging(seed)]) != 0.0]
    assert len(claims) <= 1


def test_a_torque_that_never_changes_has_no_delay(prompt: list[Run]):
    still = [run.but(u=np.full_like(run.u, 0.3)) for run in prompt]
    assert delay_of_torque(still) == 0.0


@pytest.mark.parametrize("bristle", [0.003, 0.03])
def test_friction_that_turns_late_is_no_delay(bristle: float):
    assert delay_of_torque([swinging(seed, bristle=bristle) for seed in (1, 2)]) == 0.0


@pytest.mark.parametrize("rows", [1, 2, -1])
def test_what_shifts_the_fast_part_alone_is_no_delay(rows: int):
    assert delay_of_torque([swinging(seed, fast_delay=rows * ROW) for seed in (1, 2)]) == 0.0


def controlled(seed: int) -> Run:
    """Return a geared joint that a PD controller with gravity compensation leads along slow sines, without a delay.

    Beside the plain model's torque it has a ripple of the gear and a Stribeck curve, which the controller answers.
    """
    rng = np.random.default_rng(seed)
    row, parts, rates = 1e-3, 8, 2.0 * np.pi * 0.1 * np.arange(1, 6)
    t = np.arange(0.0, 20.0, row)
    phases, sizes = rng.uniform(0.0, 2.0 * np.pi, 5), rng.normal(size=5) / np.arange(1, 6)
    asked = np.sin(rates * t[:, None] + phases) @ sizes
    asked *= 1.1 / np.ptp(asked)
    speed, step = np.gradient(asked, row).tolist(), 2.0 * np.pi / 4096 / 100
    q, v, before, filtered = float(asked[0]), 0.0, float(asked[0]), 0.0
    read, torque = [], []
    for reference, rate in zip(asked.tolist(), speed, strict=True):
        seen = math.floor(q / step) * step
        filtered += 0.3 * ((seen - before) / row - filtered)
        before = seen
        u = 2500.0 * (reference - seen) + 120.0 * (rate - filtered) + 31.0 * math.sin(seen)
        read.append(seen)
        torque.append(u)
        for _ in range(parts):
            level = 6.0 + 3.5 * math.exp(-abs(v) / 0.06)
            ripple = 1.6 * math.sin(200.0 * q + 0.7)
            # Dry friction is implicit, so that a joint at rest stays.
            driven = v + row / parts / 1.63 * (u - 32.0 * math.sin(q + 0.06) - ripple - 9.0 * v)
            held = row / parts / 1.63 * level
            v = driven - math.copysign(min(abs(driven), held), driven)
            q += row / parts * v
    noisy = np.array(torque) + 0.03 * np.std(torque) * rng.standard_normal(t.size)
    return Run(
        file=f"controlled_{seed}.csv", free_joints=(0,), t=t, u=noisy[:, None], y=np.array(read)[:, None],
        noise=[0.3 * step], resolution=[step], posture=np.zeros(0), use="fit", hold="zero",
    )  # fmt: skip


def test_what_a_controller_answers_late_is_no_delay():
    assert [delay_of_torque([controlled(seed), controlled(seed + 10)]) for seed in (0, 1, 2)] == [0.0, 0.0, 0.0]


def test_an_excluded_run_takes_no_part(late: list[Run]):
    spoilt = late[0].but(use="excluded", u=-late[0].u)
    assert delay_of_torque([*late, spoilt]) == delay_of_torque(late) != 0.0


@pytest.mark.parametrize("rows", [3, -3])
@pytest.mark.parametrize("hold", ["linear", "zero"])
def test_a_delay_of_whole_rows_moves_the_rows(prompt: list[Run], rows: int, hold: str):
    run = prompt[0].but(hold=hold)
    moved = with_delayed_torque(run, rows * ROW)
    expected = np.roll(run.u, rows, axis=0)
    assert np.allclose(moved.u[5:-5], expected[5:-5], atol=1e-9)
    assert with_delayed_torque(run, 0.0) is run


def test_a_held_torque_between_two_rows_is_their_mean(prompt: list[Run]):
    run = prompt[0].but(hold="zero")
    moved = with_delayed_torque(run, 0.25 * ROW)
    assert np.allclose(moved.u[1:-1], 0.75 * run.u[1:-1] + 0.25 * run.u[:-2], atol=1e-9)


def test_a_filtered_torque_moves_by_a_fraction_of_a_row(prompt: list[Run]):
    motion = filter_run(prompt[0])
    later = motion.with_delay(0.4 * ROW).with_delay(0.6 * ROW)
    assert np.allclose(later.torque[20:-20], motion.torque[19:-21], atol=3e-5)
    assert np.array_equal(later.q, motion.q)


def test_the_plain_model_is_held_against_the_delayed_torque(late: list[Run]):
    equations = guess(joint_equations(0), late, given={})
    theta = np.array([q.initial for q in equations.parameters])
    compared = compare(equations, theta, late, None, ())
    without = compare(equations, theta, late, None, (), with_delay=False)
    key = late[2].file, "validate"
    assert compared.delay_s == pytest.approx(3.7 * ROW, rel=0.1)
    assert without.delay_s == 0.0
    having, lacking = (one.figures[key]["baseline"] for one in (compared, without))
    assert having.torque_error[0] < 0.9 * lacking.torque_error[0]
    assert having.horizon_rmse["1"][0] < 0.8 * lacking.horizon_rmse["1"][0]
    # A fit of the position has no delay; one of the torque has.
    assert compared.figures[key]["model"].as_json() == without.figures[key]["model"].as_json()
    scored = compare(equations, theta, late, None, (), torque_scored=True)
    assert scored.models["model"].delay == compared.delay_s
    # The picture shows the torque at the time at which it was recorded.
    prediction = predict_unseen(compared)
    left = [np.std(prediction.torque - prediction.computed["baseline"]), np.std(prediction.torque)]
    assert left[0] / left[1] < 0.2


def test_a_fit_of_the_torque_has_the_delay(late: list[Run]):
    equations = guess(joint_equations(0), late, given={})
    options = FitOptions(method="gauss_newton", starts=1)
    delay = delay_of_torque(late)
    with_it, without = (
        next(score for score in fit_torque(equations, late, delay=T, options=options).runs if score.use == "validate")
        for T in (delay, 0.0)
    )
    assert with_it.rmse_rad < 0.9 * without.rmse_rad
    turned = torque_run(late[0], delay=delay)
    assert not np.array_equal(turned.y, torque_run(late[0]).y)
    assert np.array_equal(turned.noise, torque_run(late[0]).noise)


def test_a_delay_is_told(late: list[Run]):
    equations = guess(joint_equations(0), late, given={})
    simulator = KernelSimulator.of(equations)
    theta = np.array([q.initial for q in equations.parameters])
    compared = compare(simulator.equations, theta, late, None, ())
    fit = fit_torque(equations, late, delay=compared.delay_s, options=FitOptions(method="gauss_newton", starts=1))
    configuration = Configuration(free_joints=(0,), posture=(), runs=tuple(late))
    step = Step(configuration=configuration, fit=fit, torque_scored=True, compared=compared)
    stored = step_json(step)["baseline"]["delay"]
    assert stored["value"] == compared.delay_s
    assert stored["unit"] == "s"
    told = tell_delay(step)
    assert told.startswith("the torque acts 7.")
    assert "after it is recorded: fit and plain model have this delay" in told
    assert told in text_of(tell_summary([step], {}))
    early = Delay(value=-2e-3, std=1e-4, rows=-1.0, held_out_gain=0.1)
    other = replace(compared, baseline=replace(compared.baseline, delay=early))
    assert "acts 2 ms ± 100 µs (1 rows) before it is recorded: the plain model has this delay, the fit has none" in (
        tell_delay(replace(step, torque_scored=False, compared=other))
    )
    assert "No torque acts before it is there: " in tell_delay(replace(step, compared=other))
    none = replace(compared, baseline=replace(compared.baseline, delay=None))
    assert tell_delay(replace(step, compared=none)) is None
    assert step_json(replace(step, compared=none))["baseline"]["delay"] is None
