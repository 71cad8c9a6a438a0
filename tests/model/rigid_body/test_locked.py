"""Locked equations: the forms promised for one joint, and agreement with the full recursions for several."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.device.device_table import parse_device
from haptid.model.device.reader import load_device
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.locked_dynamics import locked_motion
from haptid.model.rigid_body.newton_euler import inverse_dynamics

POSTURE = (0.1, -0.2, 0.3, 0.15, 0.05, -0.4)


def evaluated(dynamics, pi, q, v):
    known = {c.symbol: float(c.linear_map @ pi) for c in dynamics.coefficients}
    known |= {sp.Symbol(f"q{j}", real=True): q[j] for j in dynamics.joints}
    known |= {sp.Symbol(f"v{j}", real=True): v[j] for j in dynamics.joints}
    M, c, g = (
        np.array(x.subs(known), dtype=float)
        for x in (dynamics.mass_matrix, dynamics.christoffel_force, dynamics.gravity_force)
    )
    return M, (c + g)[:, 0]


def full(device, pi, q, v):
    inertials = {link.name: tuple(pi[10 * i : 10 * i + 10]) for i, link in enumerate(device.massive)}
    M = mass_matrix(device, Numbers(q), inertials, tuple(pi[10 * len(device.massive) :]))
    return np.array(M, dtype=float), np.array(
        inverse_dynamics(device, Numbers(q), inertials, dict(enumerate(v)), {}), dtype=float
    )


@pytest.mark.parametrize("name", ["freedom6s", "arm6"])
@pytest.mark.parametrize("joints", [(0,), (1,), (2,), (3,), (4,), (5,), (0, 1), (1, 2), (0, 2, 5)])
def test_locked_equation_is_the_full_one_with_the_others_still(name, joints):
    device = load_device(name)
    pi = pi_prior(device)[0] * (1 + 0.1 * np.sin(np.arange(10 * len(device.massive))))
    dynamics = locked_motion(device, joints, POSTURE)
    rng = np.random.default_rng(6)
    q, v = np.array(POSTURE), np.zeros(6)
    q[list(joints)], v[list(joints)] = rng.uniform(-1, 1, (2, len(joints)))
    M, force = evaluated(dynamics, pi, q, v)
    M_full, bias = full(device, pi, q, v)
    np.testing.assert_allclose(M, M_full[np.ix_(joints, joints)], rtol=1e-11)
    np.testing.assert_allclose(force, bias[list(joints)], rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize(
    ("joint", "ids"),
    [
        (0, ["inertia"]),
        (3, ["inertia"]),
        (1, ["inertia", "gravity_cos", "gravity_sin"]),
        (2, ["inertia", "gravity_cos", "gravity_sin"]),
        (4, ["inertia", "gravity_cos", "gravity_sin"]),
        (5, ["inertia", "gravity_cos", "gravity_sin"]),
    ],
)
def test_one_free_joint_at_home(joint, ids):
    dynamics = locked_motion(load_device("freedom6s"), (joint,))
    assert [c.id for c in dynamics.coefficients] == ids
    assert dynamics.christoffel_force[0] == 0
    assert [c.unit for c in dynamics.coefficients] == ["kg m^2", "N m", "N m"][: len(ids)]


def test_coefficients_are_linearly_independent_identifiers():
    for joints in [(0, 1), (1, 2), (0, 1, 2)]:
        dynamics = locked_motion(load_device("freedom6s"), joints, POSTURE)
        rows = dynamics.linear_map
        assert np.linalg.matrix_rank(rows / np.linalg.norm(rows, axis=1, keepdims=True), tol=1e-9) == len(rows)
        assert all(c.id.isidentifier() for c in dynamics.coefficients)


def test_first_guess_of_the_locked_inertias():
    """M_ii at home by hand: each link's I + m·d² about the joint's axis."""
    device = load_device("freedom6s")
    roll = locked_motion(device, (4,)).coefficients
    assert roll[0].initial == pytest.approx(1.2e-4 + 0.03 * 0.003**2)
    assert roll[2].initial == pytest.approx(-9.81 * 0.03 * 0.003)
    assert roll[0].prior_std == pytest.approx(
        np.hypot(np.hypot(0.3 * 1.2e-4, 0.009 * 0.003**2), 2 * 0.03 * 0.003 * 0.01), rel=1e-9
    )


def test_prismatic_joint_has_a_constant_force_and_a_mass():
    device = parse_device(
        {
            "name": "slide",
            "title": "slide with a pendulum",
            "joints": [{"name": "slide", "prismatic": True}, {"name": "swing"}],
            "links": [
                {
                    "name": "a",
                    "motion": "prismatic",
                    "axis": [1, 0, 1],
                    "moved_by": {"0": 1},
                    "mass": 2.0,
                    "centroid": [0, 0, 0],
                    "inertia": {"I11": 1, "I22": 1, "I33": 1},
                },
                {
                    "name": "b",
                    "parent": "a",
                    "axis": [0, 1, 0],
                    "moved_by": {"1": 1},
                    "mass": 0.5,
                    "centroid": [0, 0, -0.3],
                    "inertia": {"I11": 0.1, "I22": 0.1, "I33": 0.1},
                },
            ],
        },
        "slide",
    )
    slide = locked_motion(device, (0,))
    assert [(c.id, c.unit) for c in slide.coefficients] == [("inertia", "kg"), ("gravity_cos", "N")]
    assert [c.initial for c in slide.coefficients] == pytest.approx([2.5, 9.81 * 2.5 / np.sqrt(2)])
    both = locked_motion(device, (0, 1))
    assert {c.id: c.unit for c in both.coefficients}["M01_c1"] == "kg m"
    pi = pi_prior(device)[0]
    q, v = np.array([0.4, 0.7]), np.array([0.3, -1.2])
    M, force = evaluated(both, pi, q, v)
    M_full, bias = full(device, pi, q, v)
    np.testing.assert_allclose(M, M_full, rtol=1e-12)
    np.testing.assert_allclose(force, bias, rtol=1e-12)


def test_tilted_base_adds_gravity_to_the_waist():
    device = replace(load_device("freedom6s"), gravity=(0.0, -1.7, -9.66))
    assert [c.id for c in locked_motion(device, (0,)).coefficients] == ["inertia", "gravity_cos", "gravity_sin"]
