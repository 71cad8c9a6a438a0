"""From coefficients to links: the Gaussian update against the information form, and the physical estimate."""

from dataclasses import replace

import numpy as np
import pytest

from haptid.identification.links.consistent_links import consistent_links, pseudo_inertia
from haptid.model.device.device import STANDARD, Inertial
from haptid.model.device.reader import load_device
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.inertial_parameters import pi_prior, standard_initial, standard_std, to_pi
from haptid.model.rigid_body.locked_dynamics import locked_motion

ORDER = [(4,), (5,), (3,), (2,), (1,), (0,), (0, 1)]
POSTURES = [None, (0.3, 0.2, -0.3, 0.4, -0.5, 0.4), (-0.3, -0.4, 0.3, -0.6, 0.5, -0.6), (0.1, 0.4, 0.4, 0.7, 0.7, 0.2)]


def physical_truth(device, seed):
    """A device drawn around the first guesses that a distribution of mass could have."""
    rng = np.random.default_rng(seed)
    while True:
        pi = to_pi(
            device,
            standard_initial(device) + 0.4 * standard_std(device) * rng.normal(size=70) * np.tile([1] * 7 + [0] * 3, 7),
        )
        if all(np.linalg.eigvalsh(pseudo_inertia(pi[i : i + 10]))[0] > 0 for i in range(0, 70, 10)):
            return pi


def measured(device, pi, postures=(None,), relative=1e-3):
    result = []
    for posture in postures:
        for free in ORDER:
            dynamics = locked_motion(device, free, posture)
            values = dynamics.linear_map @ pi
            sigma = relative * np.abs(values) + 1e-8
            result.append(Measurement(coefficients=dynamics.coefficients, values=values, covariance=np.diag(sigma**2)))
    return result


def test_update_is_bayes_rule():
    device = load_device("freedom6s")
    belief, dynamics = LinkBelief.from_device(device), locked_motion(device, (1,))
    values, covariance = np.array([0.014, -0.01, -0.02]), np.diag([1e-6, 1e-6, 1e-6])
    updated = belief.update(dynamics.coefficients, values, covariance)
    mean, P = pi_prior(device)
    A = dynamics.linear_map
    scale = np.sqrt(np.diag(P))
    whitened = np.linalg.inv(P / np.outer(scale, scale))
    information = whitened + (A * scale).T @ np.linalg.inv(covariance) @ (A * scale)
    expected = np.linalg.inv(information)
    np.testing.assert_allclose(updated.covariance / np.outer(scale, scale), expected, atol=1e-8)
    shift = expected @ (A * scale).T @ np.linalg.inv(covariance) @ (values - A @ mean)
    np.testing.assert_allclose((updated.mean - mean) / scale, shift, atol=1e-8)


def test_what_one_test_found_narrows_the_next_ones_prior():
    device = load_device("freedom6s")
    pi, belief = physical_truth(device, 1), LinkBelief.from_device(device)
    next_one = locked_motion(device, (1,)).coefficients
    before = np.sqrt(np.diag(belief.predict(next_one)[1]))
    for one in measured(device, pi)[:4]:
        belief = belief.update(one.coefficients, one.values, one.covariance)
    after = np.sqrt(np.diag(belief.predict(next_one)[1]))
    assert (after <= before * (1 + 1e-9)).all()
    own = 9.81 * np.hypot(0.25 * 0.01, 0.16 * 0.01)  # of links 2 and 3 alone: the rest is known from joint 2
    assert after[1] == pytest.approx(own, rel=1e-2)


def test_links_agree_with_the_data_and_are_physical():
    device = load_device("freedom6s")
    pi = physical_truth(device, 2)
    found = consistent_links(device, measured(device, pi))
    assert all(np.linalg.eigvalsh(pseudo_inertia(found.pi[i : i + 10]))[0] > 0 for i in range(0, 70, 10))
    assert max(np.abs(misfit).max() for misfit in found.misfit) < 3
    assert found.links["7"]["I22"].status == "identified"
    assert found.links["1"]["z"].status == "prior"
    assert found.links["1"]["z"].value == pytest.approx(0.02, abs=1e-6)
    assert found.links["7"]["m"].status == "unidentifiable"


def test_impossible_data_still_give_possible_links():
    device = load_device("freedom6s")
    dynamics = locked_motion(device, (4,))
    values = np.array([1e-6, 0.05, 0.0])  # gravity that asks for far more inertia than there is
    one = Measurement(
        coefficients=dynamics.coefficients,
        values=values,
        covariance=np.diag((0.01 * np.array([1e-4, 0.05, 0.05])) ** 2),
    )
    found = consistent_links(device, [one])
    assert np.linalg.eigvalsh(pseudo_inertia(found.pi[60:70]))[0] > 0
    assert np.abs(found.misfit[0]).max() > 3  # and the misfit says that the data were not met


def test_other_postures_pin_down_what_home_leaves_open():
    device = load_device("freedom6s")
    pi = physical_truth(device, 3)
    home, planned = (
        consistent_links(device, measured(device, pi)),
        consistent_links(device, measured(device, pi, POSTURES)),
    )
    assert planned.links["7"]["I13"].std < 0.3 * home.links["7"]["I13"].std


def test_mass_known_through_its_centroids_prior_alone_is_not_identified():
    """Gravity tells the elbow's m·c alone; a centroid stated to 3 % made the mass look measured."""
    device = load_device("double_pendulum")
    links = tuple(replace(link, inertial=_with_known_centroid(link.inertial)) for link in device.links)
    held = replace(device, links=links)
    dynamics = locked_motion(held, (1,))
    values = dynamics.linear_map @ pi_prior(held)[0]
    one = Measurement(
        coefficients=dynamics.coefficients, values=values, covariance=np.diag((1e-3 * np.abs(values) + 1e-8) ** 2)
    )
    found = consistent_links(held, [one]).links[held.links[1].name]
    mass = held.links[1].inertial.guesses[0]
    assert found["m"].std < mass.std / 5
    assert found["m"].status == "unidentifiable"


def _with_known_centroid(inertial):
    return Inertial(
        guesses=tuple(
            replace(guess, std=0.03 * abs(guess.initial) + 1e-6) if key in ("x", "y", "z") else guess
            for key, guess in zip(STANDARD, inertial.guesses, strict=True)
        )
    )
