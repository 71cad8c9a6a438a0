"""The valley of a spring, made straight, in the coordinates of fits and of the sampler."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.problem.valleys import Valleys
from haptid.model.joint.locked_joint import joint_equations
from tests.identification.bench_joint import equations


@pytest.fixture(params=[False, True], ids=["fit", "sampler"])
def parametrisation(request) -> Parametrisation:
    return Parametrisation.of(equations(), every_positive_in_log=request.param)


def sets(parametrisation: Parametrisation) -> np.ndarray:
    s = parametrisation.to_coordinates(parametrisation.initial)
    return s + 0.05 * np.random.default_rng(0).standard_normal((50, s.size))


def test_back_undoes_forward_and_the_torque_is_stiffness_times_position(parametrisation):
    valleys, s = Valleys.of(parametrisation), sets(parametrisation)
    z = valleys.forward(s)
    np.testing.assert_allclose(valleys.back(z), s, rtol=1e-11, atol=1e-13)
    K, e = (parametrisation.ids.index(id) for id in ("Ks", "epos"))
    p = parametrisation.values(s)
    np.testing.assert_allclose(z[:, K], p[:, K], rtol=1e-12)
    np.testing.assert_allclose(z[:, e], p[:, K] * p[:, e], rtol=1e-12)


def test_jacobian_is_the_derivative_and_its_determinant_the_volume(parametrisation):
    valleys, s = Valleys.of(parametrisation), sets(parametrisation)[0]
    h = 1e-6 * np.maximum(np.abs(s), 1e-2)
    difference = (valleys.forward(s + np.diag(h)) - valleys.forward(s - np.diag(h))).T / (2 * h)
    np.testing.assert_allclose(valleys.jacobian(s), difference, rtol=1e-6, atol=1e-9)
    volume = valleys.log_volume(valleys.forward(s)[None])[0]
    assert volume == pytest.approx(-np.linalg.slogdet(difference)[1], rel=1e-6)


def test_equal_stiffness_and_torque_at_zero_are_a_straight_line():
    """Spring and gravity share stiffness and torque at q = 0; what a run cannot tell apart is a line in z."""
    p = Parametrisation.of(joint_equations(4))
    valleys = Valleys.of(p)
    spring, epos, g_s, g_c = (p.ids.index(id) for id in ("Ks", "epos", "gravity_sin", "gravity_cos"))
    values = np.tile(p.values(p.to_coordinates(p.initial)), (3, 1))
    K, torque = values[0, spring] + values[0, g_s], values[0, spring] * values[0, epos] - values[0, g_c]
    values[:, spring] *= [1.0, 1.1, 1.2]
    values[:, g_s] = K - values[:, spring]
    values[:, epos] = (torque + values[:, g_c]) / values[:, spring]
    z = valleys.forward(p.coordinates(values))
    np.testing.assert_allclose(z[0] + z[2], 2 * z[1], rtol=1e-9, atol=1e-12)


def test_without_a_free_rest_position_nothing_changes():
    known = equations().with_parameters({"epos": {"fixed": True}})
    p = Parametrisation.of(known, every_positive_in_log=True)
    valleys, s = Valleys.of(p), sets(p)
    assert not valleys.springs
    np.testing.assert_array_equal(valleys.back(valleys.forward(s)), s)
    assert not valleys.log_volume(s).any()


def test_a_spring_that_pushes_has_no_coordinates(parametrisation):
    valleys, s = Valleys.of(parametrisation), sets(parametrisation)
    z = valleys.forward(s)
    z[0, parametrisation.ids.index("Ks")] = -0.01
    assert np.isnan(valleys.back(z)[0]).any()
    assert np.isfinite(valleys.back(z)[1:]).all()
