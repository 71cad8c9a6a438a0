"""The compiled joint against SciPy's Radau with the equations written again, and its disturbances one by one."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.effects import FORMULAS, Shape, parse_effects, resolve
from haptid.virtual_device.machine.joint import JOINT, integrate
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.simulate import scales_of, simulate_joint

BASE_JOINT = {
    "inertia": 6e-3, "gravity_cos": 4e-3, "gravity_sin": 9e-3, "Ks": 0.11, "epos": 0.03,
    "sigma0": 1.1, "sigma1": 0.02, "sigma2": 0.011, "vs": 0.05, "Fs": 2e-3, "Fc": 1.5e-3,
}  # fmt: skip
TENDON_JOINT = {
    "inertia": 1.2e-4, "gravity_cos": -2e-3, "gravity_sin": 1e-3, "Ks": 0.02, "epos": -0.05,
    "sigma0": 0.6, "sigma1": 0.003, "sigma2": 0.0015, "vs": 0.06, "Fs": 1.4e-3, "Fc": 1.1e-3,
}  # fmt: skip
DRIVES = {"base": (BASE_JOINT, 0.02), "tendon": (TENDON_JOINT, 0.008)}
Torque = Callable[[float], float]


def friction(p: dict[str, float], v: float, z: float) -> tuple[float, float]:
    level = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v / p["vs"]) ** 2))
    rate = v - p["sigma0"] * abs(v) / level * z
    return p["sigma0"] * z + p["sigma1"] * rate + p["sigma2"] * v, rate


def held(p: dict[str, float], q: float) -> float:
    return p["gravity_cos"] * np.cos(q) + p["gravity_sin"] * np.sin(q) + p["Ks"] * (q - p["epos"])


def by_radau(rhs: Callable[[float, np.ndarray], list[float]], start: list[float], t: np.ndarray) -> np.ndarray:
    """Integrate between rows, as the torque may jump at each."""
    states = [np.array(start)]
    for a, b in pairwise(t):
        middle = 0.5 * (a + b)  # decides on which side of a jump the interval lies
        solved = solve_ivp(
            lambda s, x, m=middle: rhs(s, np.append(x, m)), (a, b), states[-1], "Radau", rtol=1e-10, atol=1e-13
        )
        states.append(solved.y[:, -1])
    return np.array(states)


@pytest.mark.parametrize("hold", ["zero", "linear"])
@pytest.mark.parametrize("kind", ["base", "tendon"])
def test_joint_agrees_with_radau(kind: str, hold: str) -> None:
    p, amplitude = DRIVES[kind]
    t = np.cumsum(np.concatenate([[0.0], np.tile([0.005, 0.008, 0.003], 100)]))
    u = amplitude * np.cos(3.0 * t)

    def rhs(s: float, x: np.ndarray) -> list[float]:
        q, v, z, inside = x
        torque = u[np.searchsorted(t, inside) - 1] if hold == "zero" else np.interp(s, t, u)
        force, rate = friction(p, v, z)
        return [v, (torque - held(p, q) - force) / p["inertia"], rate]

    start = JOINT.rest_position(p)
    expected = by_radau(rhs, [start, 0.0, 0.0], t)
    q, v, _ = integrate(p, t, u, hold=hold, start=(start, 0.0))
    assert np.abs(q - start).max() > 0.05
    np.testing.assert_allclose(q, expected[:, 0], atol=2e-9)
    np.testing.assert_allclose(v, expected[:, 1], atol=2e-7)


def test_tendon_lag_delay_and_hysteresis_agree_with_radau() -> None:
    p = BASE_JOINT | {"inertia": 4e-3}
    rotor, stiffness, damping, lag, delay, slip, travel = 2e-3, 0.8, 4e-3, 0.02, 0.0125, 0.02, 0.05
    extra = {
        "rotor_inertia": rotor, "tendon_stiffness": stiffness, "tendon_damping": damping, "amplifier_lag": lag,
        "delay": delay, "hysteresis_stiffness": slip, "hysteresis_travel": travel,
    }  # fmt: skip
    t = np.arange(301) * 0.0025
    u = 0.02 * np.cos(3.0 * t)

    def rhs(_: float, x: np.ndarray) -> list[float]:
        q, v, z, w, s, r, rv, inside = x
        row = np.searchsorted(t, inside - delay) - 1
        torque = u[row] if row >= 0 else 0.0
        force, rate = friction(p, v, z)
        pull = stiffness * (r - q) + damping * (rv - v)
        a = (pull - held(p, q) - force - slip * s) / p["inertia"]
        return [v, a, rate, (torque - w) / lag, v - abs(v) * s / travel, rv, (w - pull) / rotor]

    start = JOINT.rest_position(p)
    expected = by_radau(rhs, [start, 0, 0, 0, 0, start, 0], t)
    q, _, _ = integrate(p | extra, t, u, start=(start, 0.0))
    np.testing.assert_allclose(q, expected[:, 0], atol=2e-9)


@pytest.mark.parametrize("name", sorted(FORMULAS))
def test_a_disturbance_of_size_zero_does_nothing_and_of_size_one_shows(name: str) -> None:
    p, amplitude = DRIVES["base"]
    run = Cosine(amplitude=amplitude, frequency=1.5, duration=9.0)
    arguments = {"t": run.times(), "torque": run.torque(), "period": run.period}
    clean = simulate_joint(p, **arguments)
    np.testing.assert_array_equal(simulate_joint(p, **arguments, effects={name: 0.0}), clean)
    moved = np.sqrt(np.mean((simulate_joint(p, **arguments, effects={name: 1.0}) - clean) ** 2))
    assert 1e-4 < moved < 0.6 * np.std(clean)


@pytest.mark.parametrize("name", sorted(set(FORMULAS) - {"amplitude_scatter"}))
def test_every_disturbance_sets_known_parameters_away_from_neutral(name: str) -> None:
    values = resolve({name: 1.0}, scales_of(BASE_JOINT, 0.02, 1.5), Shape(variant=1))
    assert set(values) <= set(JOINT.neutral())
    assert any(values[key] != JOINT.neutral()[key] for key in values)


def test_encoder_play_and_stops_do_what_they_say() -> None:
    run = Cosine(amplitude=0.02, frequency=1.5, duration=9.0)
    start = (JOINT.rest_position(BASE_JOINT), 0.0)
    q, _, y = integrate(BASE_JOINT | {"encoder_play": 0.01}, run.times(), run.torque(), start=start)
    assert np.abs(q - y).max() == pytest.approx(0.005, rel=1e-9)
    free = integrate(BASE_JOINT, run.times(), run.torque(), start=start)[0]
    np.testing.assert_array_equal(q, free)
    stop = {"stop_stiffness": 50.0, "stop_upper": start[0] + 0.05, "stop_lower": -9.0, "stop_damping": 0.05}
    stopped = integrate(BASE_JOINT | stop, run.times(), run.torque(), start=start)[0]
    assert free.max() > start[0] + 0.1 > start[0] + 0.06 > stopped.max()


def test_a_seed_repeats_and_another_differs() -> None:
    run = Cosine(amplitude=0.008, frequency=1.5, duration=4.0)
    arguments = {"effects": {"amplitude_scatter": 1.0}, "sensor": Sensor(coloured=1e-4), "period": run.period}
    first, again, other = (
        simulate_joint(TENDON_JOINT, run.times(), run.torque(), seed=seed, **arguments) for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first, again)
    assert np.any(first != other)


def test_readings_have_the_noise_and_the_steps_that_the_sensor_claims() -> None:
    t = np.arange(200_000) * 0.005
    read = Sensor(noise=2e-4, resolution=0.0).read(t, np.zeros(t.size), np.random.default_rng(0))
    assert np.std(read) == pytest.approx(2e-4, rel=0.01)
    stepped = Sensor(noise=2e-4, resolution=1.5e-4).read(t, np.zeros(t.size), np.random.default_rng(0))
    np.testing.assert_allclose(stepped / 1.5e-4, np.round(stepped / 1.5e-4), atol=1e-9)
    assert np.std(stepped) == pytest.approx(np.hypot(2e-4, 1.5e-4 / np.sqrt(12)), rel=0.01)
    coloured = Sensor(noise=0.0, resolution=0.0, coloured=2e-4).read(t, np.zeros(t.size), np.random.default_rng(0))
    assert np.std(coloured) == pytest.approx(2e-4, rel=0.05)
    assert np.corrcoef(coloured[1:], coloured[:-1])[0, 1] == pytest.approx(np.exp(-0.05), abs=0.01)


def test_scatter_on_the_measured_amplitude_is_constant_within_a_cycle() -> None:
    run = Cosine(amplitude=0.008, frequency=2.0, duration=12.0)
    effects = {"amplitude_scatter": {"scatter": 0.05}}
    clean = simulate_joint(TENDON_JOINT, run.times(), run.torque())
    scattered = simulate_joint(TENDON_JOINT, run.times(), run.torque(), effects=effects, period=run.period, seed=1)
    rest = JOINT.rest_position(TENDON_JOINT)
    moved = np.abs(clean - rest) > 0.05
    factor = (scattered - rest)[moved] / (clean - rest)[moved]
    cycle = (run.times() // run.period)[moved]
    means = [factor[cycle == c].mean() for c in range(3)]
    assert all(np.ptp(factor[cycle == c]) < 1e-9 for c in range(3))
    assert len({round(mean, 6) for mean in means}) == 3


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="cogging"):
        resolve({"coging": 1.0}, scales_of(BASE_JOINT, 0.02, 1.5))
    with pytest.raises(InputError, match="id=size"):
        parse_effects("cogging")
    with pytest.raises(InputError, match="time increasing"):
        integrate(BASE_JOINT, np.zeros(3), np.zeros(3))
    with pytest.raises(InputError, match="period"):
        simulate_joint(BASE_JOINT, np.arange(3.0), np.zeros(3), effects={"amplitude_scatter": 1.0})
    with pytest.raises(NumericalError, match="finite"):
        integrate(BASE_JOINT | {"Ks": -1e4}, np.arange(400) * 0.05, np.ones(400))
    with pytest.raises(NumericalError, match="no stable rest"):
        JOINT.rest_position(BASE_JOINT | {"Ks": -1.0})


def test_a_joint_that_runs_away_is_reported_at_once() -> None:
    """A softening spring beyond its limit drives the joint off in finite time: no step is small enough to follow it."""
    run = Cosine(amplitude=0.02, frequency=1.0)
    with pytest.raises(NumericalError, match="stopped being finite"):
        integrate({**BASE_JOINT, "spring_cubic": -5.0}, run.times(), run.torque(), start=(0.3, 0.0))
