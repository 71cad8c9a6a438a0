"""A torque without a name: functions of one and of two variables, as numbers and as an effect."""

from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from haptid.discrepancy.detect.localise import AXES
from haptid.discrepancy.finding.finding import as_json
from haptid.discrepancy.unnamed.splines import SYMBOLS, Curve
from haptid.discrepancy.unnamed.surface import Axis, Surface
from haptid.report.discrepancy.page import discrepancy_page
from tests.discrepancy.finding.test_finding import found

CURVE = Curve(variable="position_rad", first=-0.4, last=0.6)
SURFACE = Surface(
    axes=(Axis(variable="position_rad", first=-0.4, last=0.6), Axis(variable="velocity_rad_s", first=-2.0, last=1.5))
)


def torque_of(functions: Curve | Surface, weights: np.ndarray) -> np.ndarray:
    """Return the effect's torque at the knots, the last variable running fastest."""
    effect = functions.effect(1.0)
    values = {q.symbol: q.initial for q in effect.parameters}
    values |= {q.symbol: w for q, w in zip(effect.parameters[: effect.amplitudes], weights, strict=True)}
    formula = sp.lambdify([SYMBOLS[v] for v in functions.variables], effect.torque.subs(values), "numpy")
    grid = np.meshgrid(*functions.knots, indexing="ij")
    return np.asarray(formula(*grid)).ravel()


@pytest.mark.parametrize(("functions", "held"), [(CURVE, 2), (SURFACE, 0)], ids=["one", "two"])
def test_numbers_and_effect_are_the_same_function(functions: Curve | Surface, held: int):
    weights = np.random.default_rng(2).standard_normal(functions.design.shape[1])
    torque = torque_of(functions, weights)
    if held:
        torque -= np.polyval(np.polyfit(functions.knots[0], torque, held - 1), functions.knots[0])
    np.testing.assert_allclose(functions.design @ weights, torque, atol=1e-12)


def test_over_speed_a_surface_turns_with_the_direction_and_stays_bounded():
    speed = SURFACE.axes[1]
    assert np.count_nonzero(np.abs(speed.knots) < 0.1 * 2.0) >= 4
    assert abs(speed.coordinate(np.array([1e9]))[0]) <= 1.0
    assert speed.knots[[0, -1]] == pytest.approx([-2.0, 1.5])
    assert not {(0, 0), (1, 0), (0, 1)} & set(SURFACE.terms)


@pytest.mark.long
def test_friction_that_depends_on_load_is_a_torque_over_two_variables(tmp_path: Path):
    hidden = {"load_dependent_friction": {"load_friction": 0.4, "load_reference": 0.008}}
    finding = found(tmp_path, hidden)
    data = as_json(finding, measured=False, seed=0)
    assert data["verdict"] == "unlisted"
    shape = data["unnamed_shape"]
    assert "torque_Nm" in {shape["variable"], shape["second_variable"]}
    assert np.array(shape["torque_Nm"]).shape == (len(shape["knots"]), len(shape["second_knots"]))
    assert shape["closed"] > 0.85
    assert shape["over_one_variable"]["closed"] < shape["closed"] - 0.05
    page = discrepancy_page(finding, "test", measured=False).html
    assert "drive torque" in page
    alone, _ = AXES[shape["over_one_variable"]["variable"]]
    assert f"Over {alone} alone it would close" in page
