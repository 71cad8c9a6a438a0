"""The sampler's own coordinates: inverse, volume, and the same posterior as without them."""

import numpy as np
import pytest

from haptid.uq.density.straight import IDS, Straight, StraightDensity

NAMES = ("inertia", "gravity_cos", "gravity_sin", "Ks", "epos", "Fc")
FLAGS = (True, False, False, True, False, True)
MODE = np.array([-9.0, 2e-3, -4e-3, np.log(0.015), 0.1, -7.0])


@pytest.fixture
def straight():
    found = Straight.of(NAMES, FLAGS, MODE)
    assert found.places == tuple(NAMES.index(name) for name in IDS)
    return found


def test_back_undoes_straight_and_the_stiffness_is_the_sum(straight):
    eta = MODE + 0.05 * np.abs(MODE) * np.random.default_rng(0).standard_normal((50, 6))
    x = straight.straight(eta)
    np.testing.assert_allclose(straight.back(x), eta, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(np.exp(x[:, 3]), np.exp(eta[:, 3]) + eta[:, 2], rtol=1e-12)
    rest = x[:, 4]
    torque = np.exp(eta[:, 3]) * (rest - eta[:, 4]) + eta[:, 1] + eta[:, 2] * rest
    np.testing.assert_allclose(torque, 0, atol=1e-16)


def test_volume_is_the_determinant_of_the_map(straight):
    x = straight.straight(MODE[None])[0]
    h = 1e-6 * np.maximum(np.abs(x), 1e-2)
    jacobian = (straight.back(x + np.diag(h)) - straight.back(x - np.diag(h))).T / (2 * h)
    assert straight.log_volume(x[None])[0] == pytest.approx(np.linalg.slogdet(jacobian)[1], rel=1e-6)
    covariance = np.diag((1e-4 * np.abs(MODE)) ** 2)
    inverse = np.linalg.inv(jacobian)
    np.testing.assert_allclose(straight.covariance(MODE, covariance), inverse @ covariance @ inverse.T, rtol=1e-5)


@pytest.mark.parametrize(
    ("names", "flags", "eta"),
    [
        (NAMES[:3], FLAGS[:3], MODE[:3]),
        (NAMES, (True, False, True, True, False, True), MODE),
        (NAMES, FLAGS, np.where(np.arange(6) == 2, -0.02, MODE)),
    ],
    ids=["gravity fixed", "another scale", "no stable equilibrium"],
)
def test_where_the_map_does_not_apply_nothing_changes(names, flags, eta):
    found = Straight.of(names, flags, eta)
    assert not found.places
    np.testing.assert_array_equal(found.back(found.straight(eta)), eta)
    assert found.log_volume(eta[None])[0] == 0


def test_density_is_minus_infinity_where_the_spring_would_push(straight):
    density = StraightDensity(density=lambda eta: np.zeros(len(eta)), straight=straight)
    x = np.tile(straight.straight(MODE), (2, 1))
    x[1, 2] = 1.5
    values = density(x)
    assert np.isfinite(values[0])
    assert values[1] == -np.inf
