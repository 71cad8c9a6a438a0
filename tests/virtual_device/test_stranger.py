"""The stranger's joint against the equations written again, its disturbances one by one, and its recorder."""

import ast
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.effects import Scales
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.stranger.effects import FORMULAS
from haptid.virtual_device.stranger.physics import LAWS, STRANGER, integrate
from haptid.virtual_device.stranger.ranges import draw_all, draw_friction, read_ranges
from haptid.virtual_device.stranger.readings import Recorder, draw_recorder

JOINT = {
    "inertia": 1.2e-4, "gravity_cos": -2e-3, "gravity_sin": 1e-3, "Ks": 0.02, "epos": -0.05,
    "sigma0": 0.6, "sigma1": 0.003, "sigma2": 0.0015, "vs": 0.06, "Fs": 1.4e-3, "Fc": 1.1e-3,
    "sharpness": 1.4, "creep": 0.01, "attraction": 0.05, "spread": 1.8, "unevenness": 1.3,
}  # fmt: skip
RUN = Cosine(amplitude=0.008, frequency=6.0, duration=1.5, spacing=0.05)
SCALES = Scales(torque=0.008, amplitude=0.4, speed=1.0, rest=-0.05, Ks=0.02, inertia=1.2e-4, sigma2=0.0015)
SMOOTH = {
    "bias": 3e-4, "bias_time": 2.0, "bias_power": 1.4, "fading": 0.1, "fading_time": 3.0,
    "dead": 5e-4, "dead_sharpness": 3.0,
    "gain": 0.1, "gain_torque": 8e-3, "gain_power": 1.5, "limit": 9e-3, "limit_sharpness": 4.0, "lag": 0.02,
    "ripple": 0.1, "ripple_number": 9.0, "ripple_phase": 0.3, "ripple_steepness": 2.0,
    "spring": 1e-3, "spring_travel": 0.4, "spring_power": 2.5, "bend": 3e-3, "bend_width": 0.1,
    "gear": 3e-4, "gear_number": 8.0, "gear_phase": 0.2, "gear_second": 0.5, "gear_third": 0.3, "gear_change": 0.4,
    "gear_change_number": 2.0,
    "oil": 0.3, "oil_share": 0.4, "oil_fast": 0.5, "oil_slow": 4.0,
    "damping_direction": 0.2, "damping_direction_speed": 0.3,
    "cosh_damping": 5e-4, "cosh_width": 0.3, "drag": 5e-4, "drag_speed": 1.0, "drag_power": 1.7,
    "warm": 0.4, "warm_share": 0.6, "warm_fast": 0.3, "warm_slow": 5.0, "direction": 0.2, "direction_speed": 0.2,
    "bump": 0.5, "bump_centre": 0.1, "bump_width": 0.2, "load_drive": 0.3, "load_back": 0.5, "load_torque": 8e-3,
    "cable": 2e-3, "cable_travel": 0.1, "cable_power": 1.5, "cable_share": 0.7,
    "beat": 3e-4, "beat_frequency": 9.0, "beat_phase": 0.4, "beat_depth": 0.3, "beat_slow": 1.0,
    "swing": 0.2, "swing_number": 1.5, "swing_phase": 0.7,
}  # fmt: skip
"""Everything that acts in the joint's own equation, at once."""


def asked(p: dict[str, float], t: float, command: float) -> float:
    w = (
        command * (1 + p["fading"] * np.log(1 + t / p["fading_time"]))
        + p["bias"] * (t / p["bias_time"]) ** p["bias_power"]
    )
    r = (abs(w) / p["dead"]) ** p["dead_sharpness"]
    w = w * r / (1 + r)
    w = w * (1 + p["gain"] * (abs(w) / p["gain_torque"]) ** p["gain_power"])
    return w / (1 + (abs(w) / p["limit"]) ** p["limit_sharpness"]) ** (1 / p["limit_sharpness"])


def held(p: dict[str, float], q: float) -> float:
    e, turn = q - p["epos"], p["gear_number"] * q + p["gear_phase"]
    torque = p["gravity_cos"] * np.cos(q) + p["gravity_sin"] * np.sin(q) + p["Ks"] * e
    torque += p["spring"] * np.sign(e) * abs(e / p["spring_travel"]) ** p["spring_power"]
    torque += p["bend"] * (np.sqrt(e**2 + p["bend_width"] ** 2) - p["bend_width"])
    waves = np.sin(turn) + p["gear_second"] * np.sin(2 * turn + 1) + p["gear_third"] * np.sin(3 * turn + 2)
    return torque + p["gear"] * (1 + p["gear_change"] * np.sin(p["gear_change_number"] * q)) * waves


def two_times(p: dict[str, float], name: str, t: float) -> float:
    share = p[f"{name}_share"]
    return share * np.exp(-t / p[f"{name}_fast"]) + (1 - share) * np.exp(-t / p[f"{name}_slow"])


def factor(p: dict[str, float], t: float, q: float, v: float, w: float) -> float:
    scale = (1 + p["warm"] * two_times(p, "warm", t)) * (1 + p["direction"] * np.tanh(v / p["direction_speed"]))
    scale *= 1 + p["bump"] / (1 + ((q - p["bump_centre"]) / p["bump_width"]) ** 2)
    return scale * (1 + (p["load_drive"] if w * v > 0 else p["load_back"]) * abs(w) / p["load_torque"])


def damped(p: dict[str, float], t: float, q: float, v: float) -> float:
    d = p["sigma2"] * (1 + p["damping_direction"] * np.tanh(v / p["damping_direction_speed"]))
    d = d * np.exp(p["oil"] * two_times(p, "oil", t)) + p["cosh_damping"] * (
        np.cosh((q - p["epos"]) / p["cosh_width"]) - 1
    )
    return d * v + p["drag"] * np.sign(v) * abs(v / p["drag_speed"]) ** p["drag_power"]


def rubbed(p: dict[str, float], law: str, scale: float, v: float, z: float) -> tuple[float, float]:
    excess = p["Fs"] - p["Fc"]
    if law == "static":
        return scale * (p["Fc"] + excess * (1 - np.tanh(abs(v) / p["vs"]))) * np.tanh(v / p["creep"]), 0.0
    if law == "dahl":
        left = 1 - np.sign(v) * z / (scale * p["Fc"])
        return z, p["sigma0"] * v * np.sign(left) * abs(left) ** p["sharpness"]
    level = scale * (p["Fc"] + excess / (1 + (abs(v) / p["vs"]) ** p["sharpness"]))
    rate = v - p["sigma0"] * abs(v) / level * z
    return p["sigma0"] * z + p["sigma1"] * rate, rate


def rates(t: float, x: np.ndarray, command: float, p: dict[str, float], law: str) -> list[float]:
    q, v, drive, cable, z = x
    w = drive * (1 + p["ripple"] * np.tanh(p["ripple_steepness"] * np.sin(p["ripple_number"] * q + p["ripple_phase"]))
                 / np.tanh(p["ripple_steepness"]))  # fmt: skip
    friction, dz = rubbed(p, law, factor(p, t, q, v, w), v, z)
    back = p["cable_share"] * abs(v) * np.sign(cable) + (1 - p["cable_share"]) * v
    force = w - held(p, q) - damped(p, t, q, v) - friction - p["cable"] * cable
    size = p["beat"] * (1 + p["beat_depth"] * np.sin(p["beat_slow"] * t))
    force += size * np.sin(p["beat_frequency"] * t + p["beat_phase"])
    angle = p["swing_number"] * q + p["swing_phase"]
    force += 0.5 * p["inertia"] * p["swing"] * p["swing_number"] * np.sin(angle) * v**2
    slips = (abs(cable) / p["cable_travel"]) ** p["cable_power"] * back
    mass = p["inertia"] * (1 + p["swing"] * np.cos(angle))
    return [v, force / mass, (asked(p, t, command) - drive) / p["lag"], v - slips, dz]


@pytest.mark.parametrize("law", ["bristle", "dahl", "static"])
def test_a_joint_with_everything_in_it_moves_as_scipy_says(law: str) -> None:
    p, t, torque = JOINT | SMOOTH, RUN.times(), RUN.torque()
    start = STRANGER.rest_position(p)
    state, expected = np.array([start, 0.0, 0.0, 0.0, 0.0]), [start]
    for k, (begin, end) in enumerate(pairwise(t)):
        limits = {"method": "LSODA", "rtol": 1e-8, "atol": 1e-11, "max_step": 2e-3}
        state = solve_ivp(rates, (begin, end), state, args=(torque[k], p, law), **limits).y[:, -1]
        expected.append(state[0])
    moved = integrate(p | {"law": float(LAWS.index(law))}, t, torque, start)[0]
    assert np.std(expected) > 0.02
    np.testing.assert_allclose(moved, expected, atol=2e-6)


def test_generalised_maxwell_slip_moves_as_small_euler_steps_say() -> None:
    p, step, torque = JOINT | {"law": 2.0}, 5e-6, 0.006
    t = np.array([0.0, 0.1, 0.2])
    stiffness, share = (p[name] ** -np.arange(6.0) for name in ("spread", "unevenness"))
    stiffness, share = p["sigma0"] * stiffness / stiffness.sum(), share / share.sum()
    q, v, forces, slips, seen = STRANGER.rest_position(p), 0.0, np.zeros(6), np.zeros(6), []
    for k in range(40_000):
        if k == 20_000:
            torque, seen = -0.006, [q]
        level = p["Fc"] + (p["Fs"] - p["Fc"]) / (1 + (abs(v) / p["vs"]) ** p["sharpness"])
        drift = slips * p["attraction"] * (share - abs(forces) / level)
        gravity = p["gravity_cos"] * np.cos(q) + p["gravity_sin"] * np.sin(q)
        force = torque - p["Ks"] * (q - p["epos"]) - gravity - p["sigma2"] * v - forces.sum()
        forces = forces + step * np.where(slips == 0, stiffness * v, drift)
        v += step * force / p["inertia"]
        q += step * v
        slips = np.where(v * slips < 0, 0.0, slips)
        slips = np.where((slips == 0) & (forces * np.sign(v) > share * level), np.sign(v), slips)
    moved = integrate(p, t, np.array([0.006, -0.006, 0.0]), STRANGER.rest_position(p))[0]
    np.testing.assert_allclose(moved[1:], [*seen, q], atol=2e-5)


def test_tendon_neighbour_and_stop_move_as_scipy_says() -> None:
    p = JOINT | {
        "rotor_inertia": 4e-5, "tendon": 1.0, "tendon_damping": 1e-3, "tendon_hysteresis": 0.3, "tendon_travel": 2e-3,
        "neighbour_inertia": 1e-4, "neighbour_coupling": 4e-5, "neighbour_stiffness": 0.02, "neighbour_damping": 1e-4,
        "neighbour_travel": 0.05, "stop": 0.5, "stop_restitution": 0.3, "stop_upper": 0.15, "stop_lower": -0.1,
    }  # fmt: skip

    def hit(depth: float, rate: float) -> float:
        return max(p["stop"] * depth**1.5 * (1 + p["stop_restitution"] * rate), 0.0) if depth > 0 else 0.0

    def moving(t: float, x: np.ndarray, command: float) -> list[float]:  # noqa: ARG001
        q, v, z, rotor, turning, s, side, sway = x
        friction, dz = rubbed(p, "bristle", 1.0, v, z)
        stretch, rate = rotor - q, turning - v
        pull = p["tendon"] * stretch + p["tendon_damping"] * rate + p["tendon_hysteresis"] * s
        gravity = p["gravity_cos"] * np.cos(q) + p["gravity_sin"] * np.sin(q)
        force = pull - gravity - p["Ks"] * (q - p["epos"]) - p["sigma2"] * v - friction
        force += hit(p["stop_lower"] - q, -v) - hit(q - p["stop_upper"], v)
        own = (
            -p["neighbour_stiffness"] * side * (1 + (side / p["neighbour_travel"]) ** 2) - p["neighbour_damping"] * sway
        )
        m = p["neighbour_coupling"]
        turn = np.linalg.solve([[p["inertia"], m], [m, p["neighbour_inertia"]]], [force, own])
        ds = rate - abs(rate) * s / p["tendon_travel"]
        return [v, turn[0], dz, turning, (command - pull) / p["rotor_inertia"], ds, sway, turn[1]]

    t, torque, start = RUN.times(), RUN.torque(), STRANGER.rest_position(p)
    state, expected = np.array([start, 0.0, 0.0, start, 0.0, 0.0, 0.0, 0.0]), [start]
    for k, (begin, end) in enumerate(pairwise(t)):
        limits = {"method": "LSODA", "rtol": 1e-8, "atol": 1e-11, "max_step": 2e-3}
        state = solve_ivp(moving, (begin, end), state, args=(torque[k],), **limits).y[:, -1]
        expected.append(state[0])
    moved = integrate(p, t, torque, start)[0]
    assert moved.max() > p["stop_upper"]
    np.testing.assert_allclose(moved, expected, atol=2e-6)


def test_there_are_ranges_for_every_disturbance() -> None:
    assert list(read_ranges()["effects"]) == list(FORMULAS)


@pytest.mark.parametrize("name", FORMULAS)
def test_a_disturbance_changes_the_motion_beyond_the_noise_and_grows_with_its_size(name: str) -> None:
    rng = np.random.default_rng(5)
    run = Cosine(amplitude=0.008, frequency=1.5, duration=8.0, spacing=0.02)
    joint = JOINT | {"law": 0.0}
    start = STRANGER.rest_position(joint)
    still = integrate(joint, run.times(), run.torque(), start, 2e-4)[2]
    for _ in range(2):
        shape = draw_all(read_ranges()["effects"][name], rng)
        changes = [
            integrate(joint | FORMULAS[name](SCALES, size, shape), run.times(), run.torque(), start, 2e-4)[2] - still
            for size in (0.1, 0.3, 0.6)
        ]
        small, marked, large = (float(np.sqrt(np.mean(change**2))) for change in changes)
        assert marked > 1e-4
        assert small < marked < large


def test_shapes_and_recorders_repeat_with_a_seed() -> None:
    drawn = [draw_recorder(np.random.default_rng(seed)) for seed in (3, 3, 4)]
    assert drawn[0] == drawn[1] != drawn[2]
    laws = [draw_friction(JOINT, np.random.default_rng(seed)) for seed in (3, 3)]
    assert laws[0] == laws[1]
    assert {draw_friction(JOINT, np.random.default_rng(seed))["law"] for seed in range(40)} == set(LAWS)


def test_what_is_stated_of_the_noise_is_off_by_a_fifth_at_most_or_missing() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw_recorder(rng) for _ in range(300)]
    told = [stated / recorder.std for recorder, stated in drawn if stated is not None]
    assert 0.5 < len(told) / 300 < 0.7
    assert 0.8 <= min(told) < 0.85
    assert 1.15 < max(told) <= 1.2
    assert 0.25 < np.mean([recorder.coloured > 0 for recorder, _ in drawn]) < 0.42


def test_readings_have_the_noise_that_the_recorder_claims() -> None:
    t = np.arange(100_000) * 0.01
    for recorder in (
        Recorder(white=2e-4, resolution=1e-4),
        Recorder(white=2e-4, resolution=1e-4, smoothing=5),
        Recorder(white=1e-5, resolution=1e-6, coloured=3e-4, correlation_time=0.05),
    ):
        read = recorder.read(t, np.zeros(t.size), np.zeros(t.size), np.random.default_rng(0))
        assert np.std(read) == pytest.approx(recorder.std, rel=0.03)
    moving = Recorder(white=1e-9, resolution=1e-9, jitter=1e-3).read(t, 2 * t, 2 + 0 * t, np.random.default_rng(0))
    assert np.std(moving - 2 * t) == pytest.approx(2e-3, rel=0.02)


def test_smoothing_has_no_delay() -> None:
    t = np.arange(200) * 0.01
    read = Recorder(white=0.0, resolution=1e-9, smoothing=7).read(t, 3 * t, 0 * t, np.random.default_rng(0))
    np.testing.assert_allclose(read, 3 * t, atol=1e-8)


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="parameters of the stranger's joint"):
        integrate({"sticky": 1.0}, RUN.times(), RUN.torque(), 0.0)
    with pytest.raises(InputError, match="time increasing"):
        integrate(JOINT, np.zeros(3), np.zeros(3), 0.0)
    with pytest.raises(NumericalError, match="no stable rest"):
        STRANGER.rest_position(JOINT | {"Ks": -1.0})
    with pytest.raises(NumericalError, match="finite"):
        integrate(JOINT | {"Ks": -1e4}, np.arange(400) * 0.05, np.ones(400), 0.0)


def test_the_stranger_knows_no_model_and_shares_no_formula() -> None:
    folder = Path(__file__).parents[2] / "virtual_device" / "stranger"
    for path in folder.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("haptid"):
                assert node.module.startswith(("haptid.support", "haptid.virtual_device"))
    assert '#include "friction.h"' not in (folder / "stranger.c").read_text(encoding="utf-8")
