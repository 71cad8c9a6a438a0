"""The fast likelihood against the dense normal density of SciPy, for every noise model."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from haptid.noise.cycle_torque import torque_columns
from haptid.noise.gram import correlated_gram, dense_columns, weigh_white, white_products
from haptid.noise.marginal import coefficients, eliminate
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import column_scales, prepare, scatter_columns
from haptid.noise.thresholds import THRESHOLDS
from haptid.noise.whitening import gram, whiten
from haptid.uq.density.equilibrium import equilibrium
from haptid.uq.density.forward import kernel_of
from haptid.uq.density.likelihood import cycle_scores, log_likelihood
from tests.uq.uq_cases import make_density, truth_eta

MODELS = [
    NoiseModel(),
    NoiseModel(scatter="reading"),
    NoiseModel(scatter="torque"),
    NoiseModel(scatter="reading", runs=True),
    NoiseModel(scatter="torque", runs=True),
    NoiseModel(correlated=True),
    NoiseModel(scatter="reading", runs=True, correlated=True),
]


def dense(density, eta):
    """Mean and covariance of one run's rows, written out."""
    terms, model = density.terms[0], density.model
    thetas, hyper = density.coordinates.thetas(eta[None]), density.hyper(eta[None])
    simulated = density.simulate(eta[None], terms)[0]
    rest = equilibrium(density.equations, thetas, float(terms.data.mean()))[0]
    n = len(terms.states)
    mean = simulated + terms.start_shift @ terms.fixed[:n]
    noise = hyper["noise_factor"][0] * terms.sensor_std
    cov = noise**2 * np.eye(terms.run.t.size)
    if model.correlated:
        gaps = np.abs(terms.run.t[:, None] - terms.run.t[None])
        cov += hyper["model_error"][0] ** 2 * np.exp(-gaps / hyper["error_time"][0])
    columns = dense_columns(terms, model, np.zeros_like(simulated), simulated - rest)[1:]
    scales = column_scales(terms, model, hyper)[0]
    cov += (columns.T * scales**2) @ columns
    return mean, cov


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.id)
def test_log_likelihood_is_the_dense_normal_density(model, equations, runs):
    density = make_density(model, runs[:1], equations)
    eta = truth_eta(density) + 1e-3
    mean, cov = dense(density, eta)
    expected = multivariate_normal(mean, cov, allow_singular=False).logpdf(density.terms[0].data)
    assert density.log_likelihoods(eta[None])[0, 0] == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("model", MODELS[1:4], ids=lambda m: m.id)
def test_a_kept_subset_is_the_dense_density_of_those_rows(model, equations, runs):
    density = make_density(model, runs[:1], equations)
    eta, terms = truth_eta(density), density.terms[0]
    keep = terms.cycle != 1
    mean, cov = dense(density, eta)
    expected = multivariate_normal(mean[keep], cov[np.ix_(keep, keep)]).logpdf(terms.data[keep])
    simulated = density.simulate(eta[None], terms)
    thetas, hyper = density.coordinates.thetas(eta[None]), density.hyper(eta[None])
    found = log_likelihood(terms, model, equations, thetas, hyper, simulated, keep)
    assert found[0] == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_cycle_scores_are_conditional_densities(equations, runs):
    density = make_density(NoiseModel(scatter="reading"), runs[:1], equations)
    eta, terms = truth_eta(density), density.terms[0]
    mean, cov = dense(density, eta)
    left, kept = terms.cycle == 1, terms.cycle != 1
    gain = np.linalg.solve(cov[np.ix_(kept, kept)], cov[np.ix_(kept, left)]).T
    conditional = multivariate_normal(
        mean[left] + gain @ (terms.data[kept] - mean[kept]),
        cov[np.ix_(left, left)] - gain @ cov[np.ix_(kept, left)],
    )
    thetas, hyper = density.coordinates.thetas(eta[None]), density.hyper(eta[None])
    simulated = density.simulate(eta[None], terms)
    scores = cycle_scores(terms, density.model, equations, thetas, hyper, simulated)
    assert scores[0, 1] == pytest.approx(conditional.logpdf(terms.data[left]), rel=1e-8, abs=1e-5)


def test_white_and_correlated_grams_agree_without_correlation(equations, runs):
    model = NoiseModel(scatter="reading", runs=True)
    density = make_density(model, runs[:1], equations)
    terms, rng = density.terms[0], np.random.default_rng(1)
    r, m = rng.standard_normal((2, 3, terms.run.t.size))
    noise, keep = np.array([1.0, 2.0, 0.5]), rng.random(terms.run.t.size) < 0.8
    white = weigh_white(white_products(terms, model, r, m, keep), noise, keep)
    other = correlated_gram(terms, model, r, m, noise, (np.zeros(3), np.ones(3)), keep)
    np.testing.assert_allclose(white[0], other[0], rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(white[1], other[1], rtol=1e-11)


def test_whitening_is_the_cholesky_solution_on_uneven_times():
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.uniform(0.01, 0.3, 60))
    S = 0.3**2 * np.eye(60) + 0.7**2 * np.exp(-np.abs(t[:, None] - t) / 0.4)
    v = rng.standard_normal((4, 60))
    white, logdet = whiten(v, t, noise=0.3, error=0.7, time=0.4, keep=np.ones(60, bool))
    np.testing.assert_allclose(white, np.linalg.solve(np.linalg.cholesky(S), v.T).T, rtol=1e-10, atol=1e-12)
    assert logdet == pytest.approx(np.linalg.slogdet(S)[1], rel=1e-12)
    np.testing.assert_allclose(gram(white), white @ white.T, rtol=1e-12)


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_columns_of_a_torque_resumed_at_their_cycle_are_those_of_whole_simulations(equations, runs, hold):
    class Whole:
        """The kernel without its way to go on from a state."""

        simulate = staticmethod(kernel_of(equations).simulate)

    terms = prepare(equations, runs[0].but(hold=hold))
    theta, model = np.array([q.initial for q in equations.parameters]), NoiseModel(scatter="torque")
    made, whole = (scatter_columns(terms, simulator, theta, model).fixed for simulator in (kernel_of(equations), Whole))
    assert len(made) > 3
    forgotten = THRESHOLDS.forgotten_share_of_cycle_effect * np.abs(whole[1:]).max()
    np.testing.assert_allclose(made, whole, rtol=0.0, atol=forgotten)
    simulated = made != 0.0
    np.testing.assert_array_equal(made[simulated], whole[simulated])


def test_columns_of_a_recorder_that_averages_rows_are_averaged(equations, runs):
    simulator, theta = kernel_of(equations), np.array([q.initial for q in equations.parameters])
    plain = prepare(equations, runs[0])
    averaging = plain.run.but(averaged_rows=4)
    M, averaged = (torque_columns(simulator, theta, r, plain.x0, plain.cycle) for r in (plain.run, averaging))
    u = averaging.u * (1.0 + THRESHOLDS.torque_change_of_scatter * (plain.cycle == 1)[:, None])
    y, moved = (simulator.simulate(theta, r, x0=plain.x0).y for r in (averaging, averaging.but(u=u)))
    whole = (moved - y) / THRESHOLDS.torque_change_of_scatter
    np.testing.assert_allclose(averaged[..., 1], whole, rtol=0.0, atol=1e-5 * np.abs(whole).max())
    assert np.abs(M - averaged).max() > 1e-3 * np.abs(M).max()


def test_columns_of_a_cycle_are_whitened_as_their_rows_alone_would_be():
    """Rows before a column begins are left out of inner products, and the sums stay as they were."""
    rng = np.random.default_rng(4)
    v = rng.standard_normal((5, 203))
    for column, first in zip(v, (0, 3, 64, 200, 203), strict=True):
        column[:first] = 0.0
    sums = np.array([[sum_of_eight(a * b) for b in v] for a in v])
    np.testing.assert_array_equal(gram(v), sums)


def sum_of_eight(products):
    """Add products in the order of ``uq_gram``: eight sums side by side, the rest to the first."""
    whole = products.size // 8 * 8
    s = np.zeros(8)
    for group in products[:whole].reshape(-1, 8):
        s += group
    for product in products[whole:]:
        s[0] += product
    return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]))


def test_coefficients_and_elimination_are_the_normal_posterior():
    rng = np.random.default_rng(3)
    U, J, r = rng.standard_normal((50, 3)), rng.standard_normal((50, 2)), rng.standard_normal(50)
    scales = np.array([0.5, 2.0, 1e-3])
    C = np.eye(50) + (U * scales**2) @ U.T
    stacked = np.column_stack([r, J, U]).T
    reduced = eliminate(stacked @ stacked.T, scales, 3)
    block = np.column_stack([r, J])
    np.testing.assert_allclose(reduced, block.T @ np.linalg.solve(C, block), rtol=1e-10)
    alone = np.column_stack([r, U]).T
    mean, cov = coefficients(alone @ alone.T, scales)
    expected = np.linalg.inv(U.T @ U + np.diag(scales**-2))
    np.testing.assert_allclose(cov, expected, rtol=1e-8, atol=1e-16)
    np.testing.assert_allclose(mean, expected @ U.T @ r, rtol=1e-8, atol=1e-14)
