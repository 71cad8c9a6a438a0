"""First guesses of resonant effects against machines that SciPy simulates: two masses, a belt, a joint without any."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import integrate, signal

from haptid.api.campaign import Campaign
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.resonance.frequency_response import measure_response
from haptid.discrepancy.resonance.linear_response import linearise
from haptid.discrepancy.resonance.resonances import find_resonances
from haptid.discrepancy.search.search import search
from haptid.discrepancy.study.study import study_of
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.support.linear_algebra import rms

RATE, ROWS = 500.0, 5000
WHOLE, SHARE, OMEGA, ZETA, VISCOUS = 6.0, 0.7, 2 * np.pi * 12.0, 0.03, 20.0
SCALES = Scales(torque=60.0, position=0.1, speed=0.4, inertia=WHOLE, friction=5.0, viscous=VISCOUS, duration=10.0)
EFFECTS = {
    key: catalogue()[key].at(SCALES)
    for key in (
        "lock_compliance",
        "lock_compliance:friction",
        "tendon_elasticity",
        "amplifier_lag:rest",
        "cubic_spring",
    )
}


def torque(seed: int, first: float = 0.6, last: float = 30.0) -> np.ndarray:
    """A multisine over ``ROWS`` rows [N m]."""
    draw = np.random.default_rng(seed)
    t = np.arange(ROWS) / RATE
    lines = np.unique(np.round(np.geomspace(first, last, 40) * 10) / 10)
    waves = [
        np.cos(2 * np.pi * f * t + phase) for f, phase in zip(lines, draw.uniform(0, 6.3, lines.size), strict=True)
    ]
    return np.asarray(20.0 * np.sum(waves, axis=0) / np.sqrt(lines.size))


def run(u: np.ndarray, y: np.ndarray, seed: int) -> Run:
    """A run whose readings have 1 µm of noise."""
    noisy = y + np.random.default_rng(seed).normal(0.0, 1e-6, y.size)
    return Run(
        file=f"{seed}.csv", free_joints=(0,), posture=(), t=np.arange(y.size) / RATE, u=u[:, None], y=noisy[:, None],
        noise=[1e-6], resolution=[0.0], use="fit", hold="zero", prismatic=(False,),
    )  # fmt: skip


def two_masses(at_motor: bool) -> tuple[np.ndarray, ...]:
    """ẋ = A·x + B·τ of motor and load with a spring between, and the reading of either."""
    motor, load = (1 - SHARE) * WHOLE, SHARE * WHOLE
    k, c = load * OMEGA**2, 2 * ZETA * OMEGA * load
    A = np.array(
        [
            [0, 1, 0, 0],
            [-k / motor, -(c + VISCOUS) / motor, k / motor, c / motor],
            [0, 0, 0, 1],
            [k / load, c / load, -k / load, -c / load],
        ]
    )
    C = np.array([[1.0, 0, 0, 0]] if at_motor else [[0, 0, 1.0, 0]])
    return A, np.array([[0], [1 / motor], [0], [0]]), C, np.zeros((1, 1))


def simulate(system: tuple[np.ndarray, ...], u: np.ndarray) -> np.ndarray:
    made = signal.cont2discrete(system, 1 / RATE, method="zoh")
    return np.asarray(signal.dlsim(made, u)[1][:, 0])


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_the_response_of_a_mass_with_a_damper_is_one_over_jwm_plus_b(hold: str):
    A, B = np.array([[0, 1], [0, -VISCOUS / WHOLE]]), np.array([[0], [1 / WHOLE]])
    system = (A, B, np.array([[1.0, 0]]), np.zeros((1, 1)))
    u = torque(1)
    linear = signal.lsim(system, u, np.arange(ROWS) / RATE, interp=True)[1]
    y = simulate(system, u) if hold == "zero" else linear
    measured = measure_response([replace(run(u, y, 2), hold=hold)])
    assert measured is not None
    strong = measured.relative_error < 0.03
    assert strong.sum() > 20
    expected = 1 / (1j * measured.omega * WHOLE + VISCOUS)
    # Between its lines a multisine has little torque of its own, and the window leaks there.
    assert np.median(np.abs(measured.mobility / expected - 1)[strong]) < 0.02


def test_linear_two_masses_have_the_response_of_their_matrices():
    joint = linearise(EFFECTS["lock_compliance"], prismatic=False)
    assert joint is not None
    values = {"inertia": WHOLE, "Ks": 0.0, "sigma2": VISCOUS}
    values |= {"lock_share": SHARE, "lock_frequency": OMEGA, "lock_damping": ZETA}
    omega = np.geomspace(1.0, 300.0, 60)
    A, B, C, _ = two_masses(at_motor=True)
    expected = [(1j * w * C @ np.linalg.solve(1j * w * np.eye(4) - A, B)).item() for w in omega]
    np.testing.assert_allclose(joint.mobility(np.array([values[id] for id in joint.ids]), omega), expected, rtol=1e-9)


def test_two_masses_with_the_reading_at_the_motor_are_found_with_their_values():
    runs = [run(torque(seed), simulate(two_masses(at_motor=True), torque(seed)), seed) for seed in (1, 2, 3)]
    found = find_resonances(runs, EFFECTS, prismatic=False)
    assert {"lock_compliance", "lock_compliance:friction"} <= set(found)
    assert found["lock_compliance"]["inertia"] == pytest.approx(WHOLE, rel=0.05)
    assert found["lock_compliance"]["lock_share"] == pytest.approx(SHARE, rel=0.05)
    assert found["lock_compliance"]["lock_frequency"] == pytest.approx(OMEGA, rel=0.02)
    assert found["lock_compliance"]["lock_damping"] == pytest.approx(ZETA, rel=0.5)
    assert "sigma2" not in found["lock_compliance"]
    assert "cubic_spring" not in found


def test_two_masses_with_the_reading_at_the_load_are_an_elastic_tendon():
    runs = [run(torque(seed), simulate(two_masses(at_motor=False), torque(seed)), seed) for seed in (1, 2, 3)]
    found = find_resonances(runs, EFFECTS, prismatic=False)
    assert "lock_compliance:friction" not in found
    stiffness = SHARE * WHOLE * OMEGA**2
    assert 1 / found["tendon_elasticity"]["tendon_compliance"] == pytest.approx(stiffness, rel=0.05)
    assert found["tendon_elasticity"]["inertia"] == pytest.approx(WHOLE, rel=0.05)
    share = found["tendon_elasticity"]["tendon_rotor_share"]
    # Without friction, motor and load may change places: (c·s + k)/(…) is the same for both.
    assert share * (1 - share) == pytest.approx(SHARE * (1 - SHARE), rel=0.1)


def test_a_rigid_joint_with_dry_friction_has_no_resonance():
    def move(t: float, x: np.ndarray, u: np.ndarray) -> list[float]:
        friction = 4.0 * np.tanh(x[1] / 1e-3) + VISCOUS * x[1]
        return [x[1], (u[min(int(t * RATE), ROWS - 1)] - friction - 30.0 * x[0]) / WHOLE]

    u = torque(4)
    t = np.arange(ROWS) / RATE
    y = integrate.solve_ivp(move, (0, t[-1]), [0.0, 0.0], t_eval=t, args=(u,), max_step=2e-3, rtol=1e-6).y[0]
    assert find_resonances([run(u, y, 5)], EFFECTS, prismatic=False) == {}


def test_runs_too_short_for_a_response_show_none():
    u = torque(6)[:100]
    assert measure_response([run(u, np.zeros(100), 7)]) is None
    assert find_resonances([run(u, np.zeros(100), 7)], EFFECTS, prismatic=False) == {}


def belt(u: np.ndarray) -> np.ndarray:
    """Position of a motor that pulls a carriage by a belt, where both rub. Symplectic Euler at 10 kHz."""
    motor, load = (1 - SHARE) * WHOLE, SHARE * WHOLE
    fine = 20
    k, c, h = load * OMEGA**2, 2 * ZETA * OMEGA * load, 1 / (RATE * fine)
    x = v = x2 = v2 = 0.0
    y = np.empty(u.size)
    for row, force in enumerate(u):
        y[row] = x
        for _ in range(fine):
            pull = k * (x - x2) + c * (v - v2)
            a = (force - pull - 3.0 * math.tanh(v / 2e-3) - 3.0 * v) / motor
            a2 = (pull - 6.0 * math.tanh(v2 / 2e-3) - 8.0 * v2) / load
            v, v2 = v + h * a, v2 + h * a2
            x, x2 = x + h * v, x2 + h * v2
    return y


@pytest.mark.long
def test_a_belt_drive_whose_carriage_rubs_is_named_with_its_masses():
    """From the nominal model no fit found the resonance: 25,000 times the noise were left."""
    tables = {}
    for seed in (1, 2, 3, 4):
        u = 2.0 * torque(seed)
        noise = np.random.default_rng(seed).normal(0.0, 5e-6, ROWS)
        columns = {"time_s": np.arange(ROWS) / RATE, "force_0_N": u, "position_0_m": belt(u) + noise}
        tables[f"run{seed}"] = pd.DataFrame(columns)
    campaign = Campaign.from_frames(tables, validate=["run4"], noise=5e-6, measured=False).values
    keys = ("lock_compliance", "lock_compliance:friction", "tendon_elasticity", "cubic_spring", "amplifier_lag:rest")
    found = search(study_of(campaign, 0, {key: catalogue()[key] for key in keys}), starts=2)
    best = found.best.solution
    assert best.keys == ("lock_compliance:friction",)
    expected = {
        "inertia": WHOLE,
        "lock_share": SHARE,
        "lock_frequency": OMEGA,
        "lock_deceleration": 6.0 / SHARE / WHOLE,
    }
    for id, value in expected.items():
        assert best.values[id] == pytest.approx(value, rel=0.05), id
    unseen = found.study.unseen[0]
    left = rms(unseen.y[:, 0] - predict(found.study, best, [unseen]).y[0][:, 0])
    assert left < 0.02 * float(np.ptp(unseen.y))
