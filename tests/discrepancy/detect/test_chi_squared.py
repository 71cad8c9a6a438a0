"""The far tail of χ² against closed forms: two degrees of freedom are exactly exponential."""

import numpy as np
import pytest
from scipy.stats import chi2

from haptid.discrepancy.detect.chi_squared import log_tail


@pytest.mark.parametrize("T", [1.0, 400.0, 600.0, 1e4, 5e6])
def test_two_degrees_of_freedom_are_exponential(T):
    assert log_tail(T, 2) == pytest.approx(-T / 2)


@pytest.mark.parametrize("dof", [1, 3, 6])
def test_series_meets_scipy_where_both_hold(dof):
    assert log_tail(600.0, dof) == pytest.approx(chi2.logsf(600.0, dof), abs=1e-3)


def test_larger_statistics_are_always_less_likely():
    tails = [log_tail(T, 2) for T in np.geomspace(1.0, 1e7, 50)]
    assert np.all(np.diff(tails) < 0)
    assert np.isfinite(tails).all()
