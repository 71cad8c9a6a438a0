"""What one configuration hands to the next, and whether tests agree."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.identification.links.consistency import coefficients_agree, parameters_agree, summary
from haptid.identification.links.consistent_links import pseudo_inertia
from haptid.identification.links.physical_draws import physical_draws
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.carry_over import carry_over, measurement_of
from haptid.identification.sequence.configurations import configurations_of, order_of
from haptid.identification.sequence.result_json import _replaced_json
from haptid.identification.sequence.sequence import Sequence, joint_values
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.model.device.reader import load_device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.locked_dynamics import locked_motion
from haptid.support.errors import InputError

DEVICE = load_device("freedom6s")


def fit_of(free, theta, information, covariance=None) -> Fit:
    equations = configuration_equations(DEVICE, free)
    ids = tuple(q.id for q in equations.parameters if not q.fixed)
    return Fit(
        equations=equations,
        theta=theta,
        free=ids,
        information=information,
        covariance=np.linalg.inv(information) if covariance is None else covariance,
        cost=1.0,
        outcome=Outcome.CONVERGED,
        basins=(),
        starts=1,
        x0={},
        sigma={},
        correlation_time=1.0,
        simulations=0,
        wall_s=0.0,
        statuses={},
    )


def estimate(free, seed):
    """A least-squares estimate with the priors of the equations: data alone say ``y`` with information ``I``."""
    equations = configuration_equations(DEVICE, free)
    quantities = [q for q in equations.parameters if not q.fixed]
    rng, n = np.random.default_rng(seed), len(quantities)
    scale = np.array([abs(q.initial) + (q.prior.std if q.prior else 0.1 * q.upper) for q in quantities])
    A = rng.standard_normal((3 * n, n)) / (0.05 * scale)
    information = A.T @ A
    y = np.array([q.initial for q in quantities]) + 0.3 * scale * rng.standard_normal(n)
    prior = np.diag([1.0 / q.prior.std**2 if q.prior else 0.0 for q in quantities])
    mean = np.array([q.prior.mean if q.prior else 0.0 for q in quantities])
    fitted = np.linalg.solve(information + prior, information @ y + prior @ mean)
    theta = np.array([q.initial for q in equations.parameters])
    theta[[not q.fixed for q in equations.parameters]] = fitted
    return fit_of(free, theta, information, np.linalg.inv(information + prior)), y, information


def test_priors_are_taken_out_of_a_measurement_exactly():
    fit, y, information = estimate((4,), 1)
    coefficients = locked_motion(DEVICE, (4,)).coefficients
    one = measurement_of(fit, coefficients)
    places = [fit.free.index(c.id) for c in coefficients]
    expected = np.linalg.inv(information)[np.ix_(places, places)]
    np.testing.assert_allclose(one.covariance, expected, rtol=1e-3)
    np.testing.assert_allclose(one.values, y[places], rtol=1e-3, atol=1e-6)


def test_belief_becomes_the_next_prior():
    coefficients = locked_motion(DEVICE, (5,)).coefficients
    belief = LinkBelief.from_device(DEVICE)
    mean, covariance = belief.predict(coefficients)
    equations = configuration_equations(DEVICE, (5,))
    made = carry_over(equations, belief, coefficients, {"Ks": 0.031}, stated=())
    quantity = made.parameter("gravity_cos")
    k = [c.id for c in coefficients].index("gravity_cos")
    assert quantity.prior.mean == pytest.approx(mean[k])
    assert quantity.prior.std <= THRESHOLDS.carried_std_over_belief_std * np.sqrt(covariance[k, k]) * (1 + 1e-9)
    assert made.parameter("Ks").initial == 0.031
    assert made.parameter("Ks").prior is None
    kept = carry_over(equations, belief, coefficients, {"Ks": 0.031}, stated=("Ks", "gravity_cos"))
    assert kept.parameter("Ks") == equations.parameter("Ks")
    assert kept.parameter("gravity_cos") == equations.parameter("gravity_cos")


def test_a_wrong_test_is_called_contradicting():
    belief = LinkBelief.from_device(DEVICE)
    coefficients = locked_motion(DEVICE, (4,)).coefficients
    mean, covariance = belief.predict(coefficients)
    fair = Measurement(
        coefficients=coefficients, values=mean + 0.5 * np.sqrt(np.diag(covariance)), covariance=covariance
    )
    off = Measurement(coefficients=coefficients, values=mean + 20 * np.sqrt(np.diag(covariance)), covariance=covariance)
    agreed, wrong = coefficients_agree("a", belief, fair), coefficients_agree("b", belief, off)
    assert not agreed.contradicts
    assert wrong.contradicts
    assert "b" in summary([agreed, wrong])


def test_pooled_value_weighs_by_precision():
    a, _, _ = estimate((0,), 2)
    b, _, _ = estimate((0, 1), 3)
    for one in parameters_agree(a, b, "_0"):
        (x, sx), (y, sy), (p, sp) = one.earlier, one.later, one.pooled
        assert min(x, y) <= p <= max(x, y)
        assert 1 / sp**2 == pytest.approx(1 / sx**2 + 1 / sy**2)
        assert one.chi2 == pytest.approx((x - y) ** 2 / (sx**2 + sy**2))


def test_order_is_the_locking_order():
    campaign = read_campaign(embedded_campaign("paper"))
    assert order_of(campaign, DEVICE) == ((4,), (5,), (3,), (2,), (1,), (0,), (0, 1))
    chosen = configurations_of(campaign, DEVICE, (0, 1, 4))
    assert [c.free_joints for c in chosen] == [(4,), (1,), (0,), (0, 1)]
    with pytest.raises(InputError, match="joints with runs to fit"):
        configurations_of(campaign, DEVICE, (7,))


def test_postures_are_configurations_of_their_own():
    campaign = read_campaign(embedded_campaign("paper"))
    runs = list(campaign.runs)
    k = next(i for i, run in enumerate(runs) if run.free_joints == (4,) and run.use == "fit")
    runs[k] = runs[k].but(posture=np.array([0.0, 0.2, 0.0, 0.0, 0.0, 0.0]))
    made = configurations_of(campaign.but(runs=tuple(runs)), DEVICE, (4,))
    assert sorted(c.posture[1] for c in made) == [0.0, 0.2]
    assert sum(len(c.runs) for c in made) == len(campaign.runs_of((4,)))


def test_the_inertia_of_the_device_file_stands_beside_the_fitted_one():
    """It is that of the equations before any test, for a joint alone of which the campaign states no inertia."""
    overrides: dict[int, dict[str, object]] = {}
    campaign = SimpleNamespace(parameter_overrides=overrides)
    fits: Any = SimpleNamespace(device=DEVICE, campaign=campaign)

    def inertia(*joints: int) -> float | None:
        configuration: Any = SimpleNamespace(free_joints=joints)
        return Sequence._inertia_of(fits, configuration, locked_motion(DEVICE, joints, (0.0,) * 6).coefficients)

    equations = configuration_equations(DEVICE, (2,), (0.0,) * 6)
    assert inertia(2) == pytest.approx(equations.parameter("inertia").initial)
    assert inertia(2, 3) is None
    overrides[2] = {"inertia": {"initial": 1e-3}}
    assert inertia(2) is None


def test_draws_are_physical_and_spread_like_the_belief():
    belief = LinkBelief.from_device(DEVICE)
    tight = LinkBelief(mean=belief.mean, covariance=belief.covariance * 1e-4)
    start, _ = pi_prior(DEVICE)
    drawn = np.array(physical_draws(DEVICE, tight, start, 40, np.random.default_rng(0)))
    for pi in drawn:
        assert all(np.linalg.eigvalsh(pseudo_inertia(pi[i : i + 10]))[0] > 0 for i in range(0, 70, 10))
    spread = np.sqrt(np.diag(tight.covariance))
    moving = spread > 0
    ratio = drawn.std(axis=0)[moving] / spread[moving]
    assert 0.7 < np.median(ratio) < 1.2


def test_drive_and_controller_are_no_parameters_of_the_whole_device():
    single = {"inertia": 1.0, "Fc": 0.1, "torque_constant": 0.5, "resistance_ohm": 2.0}
    loop = {"controller_limit": 3.0, "controller_derivative_gain": 0.2, "controller_integral_gain": 0.1}
    assert joint_values((1,), single | loop) == {"Fc_1": 0.1}


def test_a_replaced_fit_keeps_the_drive_beside_the_parameters_that_were_compared():
    # Both models are compared on torques; a fit that is read again needs what makes them, too.
    rows = [SimpleNamespace(id=id) for id in ("inertia", "Fc")]
    model = SimpleNamespace(
        simulator=SimpleNamespace(equations=SimpleNamespace(parameters=rows)), theta=np.array([2.0, 0.3])
    )
    fit = SimpleNamespace(outcome=Outcome.PLAIN, values={"inertia": 1.0, "Fc": 0.1, "controller_limit": 3.0})
    step = SimpleNamespace(fit=fit, compared=SimpleNamespace(models={"model": model}))
    assert _replaced_json(step) == {"replaced": {"inertia": 2.0, "Fc": 0.3, "controller_limit": 3.0}}
