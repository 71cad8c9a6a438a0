"""No parameter set inside wide bounds leaves the finite numbers, passive or not."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.model.device.reader import load_device
from haptid.model.rigid_body.locked_dynamics import locked_motion
from tests.model.kernel_cases import CASES, IDS, KERNEL, TENDON, draw, torque, vector

T = np.arange(0.0, 8.0, 0.005)


@pytest.mark.parametrize("passive", [True, False])
@pytest.mark.parametrize("case", CASES)
def test_finite_within_a_decade(case: str, passive: bool):
    parameters, amplitude = CASES[case]
    P = draw(parameters, 400, seed=1, passive=passive)
    y = KERNEL.simulate_many(T, torque(T, amplitude), P, np.tile([0.1, 0.0, 0.0], (len(P), 1)))
    assert np.isfinite(y).all()


@pytest.mark.parametrize("case", CASES)
def test_finite_within_two_decades_where_passive(case: str):
    parameters, amplitude = CASES[case]
    P = draw(parameters, 400, seed=2, decades=2.0)
    y = KERNEL.simulate_many(T, torque(T, amplitude), P, np.tile([0.1, 0.0, 0.0], (len(P), 1)))
    assert np.isfinite(y).all()


@pytest.mark.parametrize("sigma0", [1e3, 1e5, 1e7])
def test_very_stiff_bristles_are_stable_at_the_standard_step(sigma0: float):
    p = vector(TENDON | {"sigma0": sigma0, "sigma1": 1e-4})
    y = KERNEL.simulate(T, torque(T, 5e-3), p, [0.1, 0.0, 0.0])
    sliding = KERNEL.simulate(T, torque(T, 5e-3), vector(TENDON | {"sigma0": 1e3, "sigma1": 1e-4}), [0.1, 0.0, 0.0])
    assert np.abs(y - sliding).max() < 2e-3  # with ever stiffer bristles the motion tends to a limit


def test_a_state_that_blows_up_ends_in_nan_rows_and_harms_no_neighbour():
    good = vector(TENDON)
    bad = vector(TENDON | {"Ks": -1e3})
    P, x0 = np.array([good, bad, good]), np.tile([0.1, 0.0, 0.0], (3, 1))
    y = KERNEL.simulate_many(T, torque(T, 5e-3), P, x0)
    alone = KERNEL.simulate(T, torque(T, 5e-3), good, x0[0])
    assert np.isnan(y[1]).all()
    np.testing.assert_array_equal(y[0], alone)
    np.testing.assert_array_equal(y[2], alone)
    one = KERNEL.simulate(T, torque(T, 5e-3), bad, x0[0])[:, 0]
    first = int(np.argmax(np.isnan(one)))
    assert first > 1
    assert np.isnan(one[first:]).all()


def test_wrong_shapes_are_named():
    with pytest.raises(ValueError, match=r"u needs shape \(1600, 1\), got \(1599, 1\)"):
        KERNEL.simulate(T, torque(T, 1.0)[1:], vector(TENDON), [0.1, 0.0, 0.0])
    with pytest.raises(ValueError, match=rf"p needs shape \({len(IDS)},\)"):
        KERNEL.simulate(T, torque(T, 1.0), [1.0], [0.1, 0.0, 0.0])


@pytest.mark.parametrize("joint", range(6))
def test_finite_over_the_bounds_of_the_built_in_device(joint: int):
    device = load_device("freedom6s")
    guesses = device.joints[joint].parameters
    inertia = next(c.initial for c in locked_motion(device, [joint]).coefficients if c.id == "inertia")
    rng = np.random.default_rng(joint)
    n = 300
    drawn = {"inertia": inertia * 10 ** rng.uniform(-0.7, 0.7, n)}
    for name, guess in guesses.items():
        low, high = (guess.initial, guess.initial) if guess.fixed else (guess.lower, guess.upper)
        drawn[name] = np.exp(rng.uniform(*np.log([low, high]), n)) if low > 0 else rng.uniform(low, high, n)
    drawn["Fc"], drawn["Fs"] = np.sort([drawn["Fc"], drawn["Fs"]], axis=0)
    gravity = 0.2 * device.joints[joint].torque_limit
    P = np.column_stack([drawn.get(i, rng.uniform(-gravity, gravity, n)) for i in IDS])
    not_passive = drawn["sigma2"] < drawn["sigma1"] * (drawn["Fs"] - drawn["Fc"]) / drawn["Fc"]
    assert not_passive.mean() > 0.5  # most of the box: fits pass through it
    y = KERNEL.simulate_many(T, torque(T, gravity), P, np.tile([0.1, 0.0, 0.0], (n, 1)))
    assert np.isfinite(y).all()
