import numpy as np
import pytest

from haptid.discrepancy.unnamed.splines import without_polynomial
from haptid.discrepancy.unnamed.suggestion import suggestion

KNOTS = np.linspace(-0.2, 0.6, 8)
X = (KNOTS - 0.2) / 0.4
BEND = without_polynomial(KNOTS, 2)


def suggested(torque: np.ndarray, noise: float = 1e-5) -> str | None:
    error = noise * np.random.default_rng(0).standard_normal(8)
    return suggestion(KNOTS, BEND @ (torque + error), np.full(8, noise), BEND)


@pytest.mark.parametrize(
    ("size", "shape", "term"),
    [(2e-3, X**3, "·x³"), (-1e-3, X**2, "·x²"), (1e-3, np.sin(3 * np.pi * X), "·sin(3·π·x)")],
)
def test_one_term_is_found_with_its_size(size, shape, term):
    found = suggested(size * shape)
    assert term in found
    assert float(found.split("·")[0]) == pytest.approx(size, rel=0.03)
    assert "x = (variable − 0.2)/0.4" in found


def test_noise_gets_no_formula_and_a_wild_shape_neither():
    assert suggested(np.zeros(8)) is None
    assert suggested(1e-3 * np.array([1, -1, 0.3, 2, -2, 0.1, 1.4, -0.6]), noise=1e-7) is None
