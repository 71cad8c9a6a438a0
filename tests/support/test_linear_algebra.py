"""Linear algebra of fits against plain formulas, and its promises where matrices are singular."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptid.support.installing.environment import ROOT
from haptid.support.linear_algebra import inverse, orthonormal_basis, profile_out, scaled_covariance


def jacobian(seed: int) -> np.ndarray:
    """Columns of very different sizes; the last two are one."""
    J = np.random.default_rng(seed).standard_normal((30, 6)) * np.array([1.0, 1e4, 1e-4, 1.0, 10.0, 1.0])
    J[:, 5] = 3.0 * J[:, 4]
    return J


@given(st.integers(0, 1000))
def test_what_is_profiled_is_what_a_fit_of_the_others_leaves(seed: int):
    J = jacobian(seed)
    kept, others = [0, 2], [1, 3, 4, 5]
    left = J[:, kept] - J[:, others] @ np.linalg.lstsq(J[:, others], J[:, kept], rcond=1e-10)[0]
    np.testing.assert_allclose(
        profile_out(J.T @ J, kept), left.T @ left, rtol=1e-5, atol=1e-6 * np.abs(left.T @ left).max()
    )


@given(st.integers(0, 1000), st.sets(st.integers(0, 5), min_size=1))
def test_what_is_profiled_is_never_indefinite(seed: int, kept: set[int]):
    matrix = profile_out(jacobian(seed).T @ jacobian(seed), sorted(kept))
    assert np.linalg.eigvalsh(matrix).min() >= -1e-12 * np.trace(matrix)


def test_a_covariance_in_scaled_columns_is_that_of_least_squares():
    J = jacobian(1)[:, :5]
    C, size = scaled_covariance(J)
    np.testing.assert_allclose(C / np.outer(size, size), np.linalg.inv(J.T @ J), rtol=1e-6)


def test_a_direction_without_information_has_a_large_and_finite_variance():
    covariance = inverse(np.diag([4.0, 1e-310]))
    assert covariance[0, 0] == pytest.approx(0.25)
    assert 1e100 < covariance[1, 1] < np.inf


def test_a_basis_spans_the_columns_whatever_their_units_and_leaves_out_the_dependent_one():
    J = jacobian(1)
    Q = orthonormal_basis(J)
    assert Q.shape == (30, 5)
    np.testing.assert_allclose(Q.T @ Q, np.eye(5), atol=1e-12)
    np.testing.assert_allclose(Q @ (Q.T @ J), J, rtol=1e-9, atol=1e-9 * np.abs(J).min())


OWN_INVERSES = {
    "support/linear_algebra.py": "defines them",
    "identification/problem/initial_states.py": "least squares of a parabola, not a covariance",
    "identification/links/consistent_links.py": "of a square Jacobian, which is not symmetric",
    "uq/density/laplace.py": "of a matrix root, which is not symmetric",
}
"""Modules that may call NumPy's inverse: why."""


def test_symmetric_matrices_are_inverted_in_one_place():
    calling = {
        path.relative_to(ROOT).as_posix()
        for package in ("model", "measurement", "fmu_build", "identification", "noise", "uq", "discrepancy", "report")
        for path in (ROOT / package).rglob("*.py")
        if re.search(r"linalg\.p?inv\(", path.read_text(encoding="utf-8"))
    }
    assert calling | {"support/linear_algebra.py"} == set(OWN_INVERSES)


def test_the_inverse_of_what_rounding_left_of_a_parameter_is_finite():
    """A parameter that one block of rows alone sees has nothing left without it but rounding beside its zero."""
    matrix = np.array([[0.0, 1e-9, -3e-7], [1e-9, 2.0, 0.5], [-3e-7, 0.5, 1.0]])
    found = inverse(matrix)
    assert np.isfinite(found).all()
    assert found[1:, 1:] == pytest.approx(np.linalg.inv(matrix[1:, 1:]))
    assert found[0, 0] > 1e100
    assert inverse(matrix - np.diag([1e-12, 0.0, 0.0])) == pytest.approx(found)
