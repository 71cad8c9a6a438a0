"""Draws of parameters: moments as stated, never a joint that cannot be."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.statistics.parameter_draws import draw_parameters
from haptid.model.joint.locked_joint import joint_equations

EQUATIONS = joint_equations(4)
IDS = [q.id for q in EQUATIONS.parameters]
THETA = np.array([q.initial for q in EQUATIONS.parameters])
FREE = ("Fs", "Ks", "Fc", "inertia", "epos")
PLACES = [IDS.index(id) for id in FREE]


def covariance(relative: float) -> np.ndarray:
    """Return a covariance with correlations and standard deviations relative to the values (to 1 where these are 0)."""
    root = np.random.default_rng(3).standard_normal((len(FREE), 2 * len(FREE)))
    C = root @ root.T
    std = relative * np.where(THETA[PLACES] == 0, 1.0, np.abs(THETA[PLACES]))
    size = np.sqrt(np.diag(C))
    return C / np.outer(size, size) * np.outer(std, std)


def draw(relative: float, count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return draw_parameters(EQUATIONS, THETA, FREE, covariance(relative), count=count, rng=rng)


def test_moments_are_those_of_the_covariance():
    C, n = covariance(1e-3), 20_000
    drawn = draw(1e-3, n)[:, PLACES]
    std = np.sqrt(np.diag(C))
    assert np.all(np.abs(drawn.mean(axis=0) - THETA[PLACES]) < 4.5 * std / np.sqrt(n))
    np.testing.assert_allclose(drawn.std(axis=0), std, rtol=4.5 / np.sqrt(2 * n))
    np.testing.assert_allclose(np.corrcoef(drawn.T), C / np.outer(std, std), atol=4.5 / np.sqrt(n))


def test_what_was_not_fitted_keeps_its_value():
    others = [k for k in range(len(IDS)) if k not in PLACES]
    assert np.ptp(draw(0.1, 50)[:, others], axis=0).max() == 0


@pytest.mark.parametrize("relative", [0.1, 1.0, 30.0])
def test_no_draw_is_a_joint_that_cannot_be(relative: float):
    drawn = draw(relative, 300)
    assert drawn.shape == (300, len(IDS))
    assert np.isfinite(drawn).all()
    lower, upper = ([getattr(q, end) for q in EQUATIONS.parameters] for end in ("lower", "upper"))
    assert (drawn >= lower).all()
    assert (drawn <= upper).all()
    assert (drawn[:, IDS.index("inertia")] > 0).all()
    assert (drawn[:, IDS.index("Fs")] >= drawn[:, IDS.index("Fc")]).all()


def test_an_ordering_that_no_draw_meets_is_met_all_the_same():
    theta = THETA.copy()
    theta[IDS.index("Fs")] = 0.5 * theta[IDS.index("Fc")]
    rng = np.random.default_rng(0)
    drawn = draw_parameters(EQUATIONS, theta, FREE, covariance(1e-4), count=20, rng=rng)
    np.testing.assert_array_equal(drawn[:, IDS.index("Fs")], drawn[:, IDS.index("Fc")])


def test_a_seed_gives_the_same_draws():
    np.testing.assert_array_equal(draw(0.1, 30), draw(0.1, 30))
    assert not np.array_equal(draw(0.1, 30), draw(0.1, 30, seed=1))


def test_without_a_fitted_parameter_there_is_one_set():
    rng = np.random.default_rng(0)
    drawn = draw_parameters(EQUATIONS, THETA, (), np.zeros((0, 0)), count=3, rng=rng)
    np.testing.assert_array_equal(drawn, np.tile(THETA, (3, 1)))
