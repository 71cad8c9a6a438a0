"""First guesses from data, and the equations of a campaign's configurations."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.first_guesses.initial_guess import guess, guess_from
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.stated import fields_changed_by, overridden
from haptid.measurement.signals.smoothing import dominant_period, smooth
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.reader import load_device
from haptid.model.device.stated_parameters import possible_range
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from tests.identification.bench_joint import TRUE, runs


def campaign(device="single_joint", **overrides) -> Campaign:
    given = {4: overrides} if overrides else {}
    return Campaign(folder=".", title="t", device=device, measured=False, runs=runs(), parameter_overrides=given)


def test_smoothing_keeps_a_slow_sine_and_differentiates_it():
    run = runs()[0]
    t = run.t
    made = smooth(run.but(y=np.sin(2 * t)[:, None]), width=0.02)
    inner = slice(100, -100)
    factor = np.exp(-0.5 * (2 * 0.02) ** 2)
    np.testing.assert_allclose(made.q[inner], factor * np.sin(2 * t)[inner], atol=1e-4)
    np.testing.assert_allclose(made.v[inner], 2 * factor * np.cos(2 * t)[inner], atol=3e-3)
    np.testing.assert_allclose(made.a[inner], -4 * factor * np.sin(2 * t)[inner], atol=5e-3)


def test_period_is_found_on_uneven_rows():
    rng = np.random.default_rng(0)
    t = np.sort(rng.uniform(0.0, 20.0, 3000))
    t[0] = 0.0
    assert dominant_period(t, np.cos(1.9 * t)) == pytest.approx(2 * np.pi / 1.9, rel=0.1)


def test_guess_needs_no_numbers_and_lands_within_a_factor():
    values = guess_from([run for run in runs() if run.use == "fit"]).values
    for id, factor in (("Ks", 1.3), ("Fc", 1.4), ("Fs", 1.5), ("sigma2", 1.5), ("inertia", 4.0), ("vs", 5.0)):
        assert 1 / factor < values[id] / TRUE[id] < factor, (id, values[id])


def test_no_guess_and_no_bound_lies_beyond_what_a_result_may_state():
    tiny = [run.but(u=1e-9 * run.u) for run in runs() if run.use == "fit"]
    for quantity in guess(joint_equations(0), tiny, given={}).parameters:
        least, most = possible_range(quantity.id)
        assert least <= quantity.lower <= quantity.initial <= quantity.upper <= most, quantity.id


def test_wide_motion_tells_gravity_from_the_spring():
    run = runs()[0]
    t = np.arange(4000) * 0.005
    q = 1.4 * np.sin(1.1 * t) + 0.3 * np.sin(2.7 * t)
    v = 1.4 * 1.1 * np.cos(1.1 * t) + 0.3 * 2.7 * np.cos(2.7 * t)
    a = -1.4 * 1.21 * np.sin(1.1 * t) - 0.3 * 7.29 * np.sin(2.7 * t)
    torque = 0.02 * a + 0.5 * np.cos(q) + 0.8 * np.sin(q) + 0.1 * q + 0.01 * v + 0.03 * np.sign(v)
    values = guess_from([run.but(t=t, y=q[:, None], u=torque[:, None])]).values
    assert values["gravity_cos"] == pytest.approx(0.5, rel=0.15)
    assert values["gravity_sin"] + values["Ks"] == pytest.approx(0.9, rel=0.1)
    assert values["inertia"] == pytest.approx(0.02, rel=0.2)


@pytest.mark.parametrize("travel", [0.4, 1.6])
def test_gravity_of_a_pendulum_that_its_motor_cannot_hold_lies_within_its_range(travel: float):
    """A motor swings more than it lifts: a range of twice its torque ended below the gravity, and a spring stood in."""
    run, t = runs()[0], np.arange(4000) * 0.005
    inertia, gravity = 0.0125, 0.35
    rate = np.sqrt(gravity / inertia)  # near its resonance a pendulum needs little torque
    q = 0.45 * travel * np.sin(1.05 * rate * t) + 0.05 * travel * np.sin(0.4 * rate * t)
    v, a = np.gradient(q, t), np.gradient(np.gradient(q, t), t)
    torque = inertia * a + gravity * np.sin(q) + 1e-3 * v + 1e-3 * np.sign(v)
    swung = run.but(t=t, y=q[:, None], u=torque[:, None])
    made = guess(joint_equations(0), [swung], given={}).parameter("gravity_sin")
    assert float(np.abs(torque[50:-50]).max()) < gravity / 2
    assert made.lower < gravity < made.upper


def test_single_joint_takes_guesses_from_data_and_campaign():
    made = equations_for(campaign(Ks={"initial": 0.5, "lower": 0.1, "upper": 0.9}), None, (4,))
    assert made.parameter("Ks").initial == 0.5
    assert made.parameter("Ks").upper == 0.9
    assert made.parameter("Fc").initial == pytest.approx(TRUE["Fc"], rel=0.4)


def test_device_configuration_uses_its_guesses():
    device = load_device("freedom6s")
    made = equations_for(campaign("freedom6s", vs={"fixed": 0.07}), device, (4,), (0.0,) * 6)
    assert made.parameter("vs").fixed
    assert made.parameter("vs").initial == 0.07
    assert made.parameter("inertia").prior is not None
    both = equations_for(campaign("freedom6s"), device, (0, 1), (0.0,) * 6)
    assert any(q.id == "sigma0_1" for q in both.parameters)


def test_overrides_are_checked():
    quantity = joint_equations(4).parameter("Fs")
    with pytest.raises(InputError, match="above 0"):
        fields_changed_by(quantity, {"initial": 0.0, "lower": -1.0}, "[joint.4.parameters] Fs")
    kp = joint_equations(4).parameter("Kp")
    assert fields_changed_by(kp, {"prior": {"mean": 1.0, "std": 0.1}}, "Kp")["fixed"] is False
    kept = [q for q in joint_equations(4).parameters if q.id != "gravity_cos"]
    with pytest.raises(InputError, match="a parameter of this joint"):
        overridden(joint_equations(4, parameters=kept), {"gravity_cos": {"initial": 0.1}}, 4)
