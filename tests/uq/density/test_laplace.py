"""Mode, normal approximation, choice of the noise model and predictions on data of known origin."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from haptid.identification.simulators.kernel import KernelSimulator
from haptid.model.equations.quantity import Normal
from haptid.noise.hyper import HalfNormal
from haptid.noise.noise_model import NoiseModel
from haptid.noise.thresholds import THRESHOLDS as NOISE
from haptid.uq.density import solver_step
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.equilibrium import equilibrium
from haptid.uq.density.forward import EachForward, KernelForward, kernel_of
from haptid.uq.density.laplace import SHORT, THOROUGH, Climb, laplace, lowest_reached
from haptid.uq.density.normal_equations import expand
from haptid.uq.density.solver_step import distinct_steps, longest_step, solver_error
from haptid.uq.job.summary import tell_posterior
from haptid.uq.prediction import choice
from haptid.uq.prediction.choice import Problem, best, compare
from haptid.uq.prediction.predict import predict
from haptid.uq.result import infer as infer_module
from haptid.uq.result.infer import QUICK, InferOptions, infer
from haptid.uq.sampling.sampling import SamplingOptions
from haptid.uq.thresholds import THRESHOLDS
from tests.uq.uq_cases import FREE, TRUTH, make_density, make_run, truth_eta


def test_mode_lies_at_the_truth_within_its_covariance(equations, runs):
    density = make_density(NoiseModel(scatter="reading"), runs, equations)
    start = truth_eta(density)
    away = start + np.where(np.arange(start.size) < len(FREE), 0.02, 0.0) * np.maximum(np.abs(start), 0.1)
    found = laplace(density, kernel_of(equations), away)
    z = (found.eta - start)[: len(FREE)] / np.sqrt(np.diag(found.covariance))[: len(FREE)]
    assert np.abs(z).max() < 4
    s = np.exp(found.eta[-1])
    assert s == pytest.approx(0.01, rel=0.6)
    assert float(density(start[None])[0]) <= found.log_density + 1e-6


def test_gradient_is_that_of_the_log_likelihood(equations, runs):
    """Gauss-Newton's gradient against central differences, scatter off so that the covariance does not move."""
    density = make_density(NoiseModel(), runs[:1], equations)
    eta = truth_eta(density)
    eta[0] += 0.01
    density = density.linearise(kernel_of(equations), eta)
    at = expand(density, kernel_of(equations), eta)
    for i in range(len(FREE)):
        h = np.zeros_like(eta)
        h[i] = 1e-5
        values = density.log_likelihoods(np.array([eta + h, eta - h])).sum(axis=1)
        slope = (values[0] - values[1]) / 2e-5
        assert at.gradient[i] == pytest.approx(slope, rel=2e-3, abs=2e-3 * np.abs(at.gradient).max())


def test_kernel_in_lanes_and_any_simulator_give_the_same_posterior(equations, runs):
    simulator: KernelSimulator = kernel_of(equations)
    density = make_density(NoiseModel(scatter="reading"), runs, equations)
    eta = truth_eta(density) + 1e-3 * np.random.default_rng(0).standard_normal((5, density.coordinates.size))
    lanes = density.but(forward=KernelForward(equations=equations, step=simulator.step))
    np.testing.assert_allclose(lanes(eta), density.but(forward=EachForward(simulator=simulator))(eta), rtol=1e-12)


def test_longest_step_keeps_the_solver_error_below_what_parameters_could_feel(equations, runs):
    """The sampler's log density against the same by simulations at 50 µs, at draws of the posterior."""

    def attempt(step):
        forward = KernelForward(equations=equations, step=step)
        problem = Problem(simulator=forward.simulator(), forward=forward, fitted=runs, unseen=(), noise_width=0.05)
        return problem.mode(NoiseModel(), np.array([q.initial for q in equations.parameters]))

    mode, step = longest_step(attempt, lambda mode: mode)
    density = mode.density
    assert step == density.forward.step
    draws = mode.eta + np.random.default_rng(5).standard_normal((16, mode.eta.size)) @ mode.lower.T
    exact = density.but(
        forward=KernelForward(equations=equations, step=5e-5),
        terms=tuple(terms.but(correction=np.zeros_like(terms.correction)) for terms in density.terms),
    )
    assert np.std(density(draws) - exact(draws)) < 1.5 * THRESHOLDS.largest_std_of_solver_error


def test_a_finer_fit_is_corrected_by_a_finer_simulation(equations, runs):
    theta = np.array([[q.initial for q in equations.parameters]])
    start = np.array([s.start for s in equations.states])
    usual, finer = (KernelForward(equations=equations, step=1e-3, correction=h) for h in (2.5e-4, 6.25e-5))
    exact = KernelForward(equations=equations, step=1e-5)
    left = [
        np.abs(f(theta, runs[0], start) + f.shortfall(theta, runs[0], start) - exact(theta, runs[0], start)).max()
        for f in (usual, finer)
    ]
    assert left[1] < 0.5 * left[0]
    assert not KernelForward(equations=equations, step=6e-5, correction=6.25e-5).shortfall(theta, runs[0], start).any()


def test_a_normal_approximation_beyond_the_posterior_does_not_refine_the_step(equations, runs):
    """A mode on a bound leaves too wide an approximation: the error of the solver far outside says nothing."""
    forward = KernelForward(equations=equations, step=5e-3)
    problem = Problem(simulator=forward.simulator(), forward=forward, fitted=runs, unseen=(), noise_width=0.05)
    mode = problem.mode(NoiseModel(correlated=True), np.array([q.initial for q in equations.parameters]))
    wide = replace(mode, covariance=1e4 * mode.covariance)
    draws = wide.eta + np.random.default_rng(5).standard_normal((64, wide.eta.size)) @ wide.lower.T
    inside = draws[np.isfinite(mode.density.coordinates.log_prior(draws))]
    assert np.median(mode.density(inside)) < lowest_reached(mode.log_density, wide.eta.size)
    assert solver_error(wide) < 3 * max(solver_error(mode), 0.01)


def test_steps_that_divide_all_intervals_alike_are_tried_once(equations):
    """At 1 kHz a longest inner step of 5 ms, 2.5 ms and 1.25 ms is one of 1 ms."""
    run = make_run(equations, rows=8001)
    fine = run.but(t=run.t / 8)
    assert distinct_steps(THRESHOLDS.inner_steps_s, [run]) == [5e-3, 6.25e-4]
    assert distinct_steps(THRESHOLDS.inner_steps_s, [fine]) == [5e-3]
    assert distinct_steps(THRESHOLDS.inner_steps_s, [fine, run]) == [5e-3, 6.25e-4]
    theta, x0 = np.array([[q.initial for q in equations.parameters]]), np.array([s.start for s in equations.states])
    alike = [KernelForward(equations=equations, step=step)(theta, run, x0) for step in (5e-3, 1.25e-3)]
    np.testing.assert_array_equal(*alike)
    assert KernelForward(equations=equations, step=5e-3).inner_steps(run) == 8000
    assert KernelForward(equations=equations, step=6.25e-4).inner_steps(run) == 16000


def test_the_noise_is_climbed_as_by_densities_one_by_one(equations, runs):
    """The misfit that a climb in the noise parameters keeps gives the density to the last bit."""
    for model in (NoiseModel(scatter="reading"), NoiseModel(scatter="torque"), NoiseModel(correlated=True)):
        density = make_density(model, runs, equations)
        eta = truth_eta(density)
        misfits = density.misfits(eta)
        point = eta + np.where(np.arange(eta.size) < len(FREE), 0.0, 0.3)
        hyper = density.hyper(point[None])
        kept = np.stack([misfit.log_likelihood(hyper) for misfit in misfits], axis=1)
        np.testing.assert_array_equal(kept, density.log_likelihoods(point[None]))
    diverged = density.but(forward=lambda thetas, run, _: np.full((len(thetas), run.t.size), np.nan))
    assert diverged.misfits(eta) == ()


def test_equilibrium_balances_spring_and_gravity(equations):
    given = equations.with_parameters({"gravity_sin": {"initial": 4e-3}, "gravity_cos": {"initial": 1e-3}})
    theta = np.array([[q.initial for q in given.parameters]] * 2)
    theta[1, [q.id for q in given.parameters].index("epos")] = 0.4
    q = equilibrium(given, theta, 0.0)
    torque = 1e-3 * np.cos(q) + 4e-3 * np.sin(q) + TRUTH["Ks"] * (q - [TRUTH["epos"], 0.4])
    np.testing.assert_allclose(torque, 0, atol=1e-12)


def test_held_out_score_prefers_scatter_where_there_is_some_and_only_there(equations):
    for s, scattered in ((0.0, False), (0.03, True)):
        fitted = tuple(make_run(equations, omega=w, seed=10 + i, s=s) for i, w in enumerate((2.5, 4.0)))
        unseen = (make_run(equations, omega=3.2, seed=20, s=s, use="validate"),)
        problem = Problem(
            simulator=kernel_of(equations), forward=KernelForward(equations=equations, step=2.5e-3), fitted=fitted,
            unseen=unseen, noise_width=0.05,
        )  # fmt: skip
        theta = np.array([q.initial for q in equations.parameters])
        chosen = best(compare(problem, theta))
        assert (chosen.model.scatter != "none") is scattered
        if scattered:
            assert chosen.model.scatter == "reading"


@pytest.mark.long
def test_short_climbs_choose_the_noise_model_that_long_ones_choose(equations):
    def scored(climb):
        fitted = tuple(make_run(equations, omega=w, seed=10 + i, s=0.03) for i, w in enumerate((2.5, 4.0)))
        problem = Problem(
            simulator=kernel_of(equations), forward=KernelForward(equations=equations, step=2.5e-3), fitted=fitted,
            unseen=(make_run(equations, omega=3.2, seed=20, s=0.03, use="validate"),), noise_width=0.05, climb=climb,
        )  # fmt: skip
        return compare(problem, np.array([q.initial for q in equations.parameters]))

    long, short = scored(THOROUGH), scored(SHORT)
    assert [s.model for s in short] == [s.model for s in long]
    assert best(short).model == best(long).model
    sizes = np.sqrt(np.diag(best(long).mode.covariance))
    assert np.abs((best(short).mode.eta - best(long).mode.eta) / sizes).max() < 1


def test_a_climb_that_stays_far_below_the_best_noise_model_ends():
    climb = Climb(rounds=20, worth=1000.0)
    assert not climb.ends(1, 0.0, -np.inf)
    assert climb.ends(2, 10.0, 0.0)
    assert not climb.ends(2, 100.0, 0.0)
    assert climb.ends(2, 2000.0, 2000.0)


def test_a_short_inference_chooses_the_noise_model_at_one_inner_step(equations, runs, monkeypatch):
    """A step that is too long under the chosen model is shortened under that model alone."""
    asked = []
    monkeypatch.setattr(infer_module, "compare", lambda *args, **kw: asked.append(1) or compare(*args, **kw))
    monkeypatch.setattr(infer_module, "shorten", lambda *_: SamplingOptions(chunk=4, burn=4, pilot=0, longest=4))
    # Every step but the last is refused under a scatter.
    monkeypatch.setattr(solver_step, "solver_error", lambda mode: 0.0 if mode.density.model == NoiseModel() else 1.0)
    theta = np.array([q.initial for q in equations.parameters])
    unseen = make_run(equations, omega=3.5, seed=40, s=0.01, use="validate")
    options = InferOptions(sampling=QUICK, stored=10, predicted=10, short=True)
    found = infer(kernel_of(equations), (*runs, unseen), theta, options, joint=4)
    assert found.chosen.model.scatter == "reading"
    assert found.mode.density.forward.step == THRESHOLDS.inner_steps_s[-1]
    assert len(asked) == 1
    assert found.shortened.startswith("4 ensembles of 4 steps after 4 of burn-in, in place of 4 of 120 after 60: each")
    assert found.shortened in str(tell_posterior(found))


def test_predictive_bands_cover_new_readings(equations):
    density = make_density(NoiseModel(), (make_run(equations, seed=31, rows=2000),), equations)
    found = laplace(density, kernel_of(equations), truth_eta(density))
    draws = found.eta + np.random.default_rng(0).standard_normal((1000, found.eta.size)) @ found.lower.T
    bands = predict(found.density, found.density.terms[0], draws, np.random.default_rng(1))
    np.testing.assert_allclose(bands.covered, [0.5, 0.8, 0.95], atol=0.04)
    assert np.all(bands.lower[2] <= bands.lower[0])


def test_priors_in_coordinates_are_the_declared_ones():
    quantities = {"Ks": {"prior": Normal(mean=0.02, std=0.004), "scale": "log", "lower": 1e-3, "upper": 1.0}}
    from tests.uq.uq_cases import make_equations  # noqa: PLC0415 # a changed copy of the shared case

    equations = make_equations().with_parameters(quantities)
    coordinates = Coordinates.of(equations, hyper=())
    eta = np.tile(coordinates.eta(np.array([q.initial for q in equations.parameters])), (2, 1))
    i = coordinates.names.index("Ks")
    eta[1, i] += 0.3
    values = coordinates.values(eta)[:, i]
    expected = np.diff(norm(0.02, 0.004).logpdf(values) + np.log(values))[0]
    assert np.diff(coordinates.log_prior(eta))[0] == pytest.approx(expected)
    outside = eta.copy()
    outside[:, i] = np.log(2.0)
    assert np.all(np.isinf(coordinates.log_prior(outside)))
    draws = coordinates.values(coordinates.draw(np.random.default_rng(0), 4000))[:, i]
    assert draws.mean() == pytest.approx(0.02, rel=0.02)


def test_half_normal_density_integrates_to_one():
    x = np.linspace(-40, 5, 200_001)
    assert np.trapezoid(np.exp(HalfNormal(scale=0.1).log_density(x)), x) == pytest.approx(1.0, abs=1e-4)


def test_infer_end_to_end_covers_the_truth(equations, runs):
    unseen = make_run(equations, omega=3.5, seed=40, s=0.01, use="validate")
    options = InferOptions(
        sampling=SamplingOptions(chunk=30, burn=30, pilot=0, longest=60), stored=100, predicted=100, sensitivity=True
    )
    theta = np.array([q.initial for q in equations.parameters])
    told: list[tuple[str, str]] = []
    found = infer(
        kernel_of(equations),
        (*runs, unseen),
        theta,
        options,
        joint=4,
        tell=lambda stage, _, figures: told.append((stage, figures)),
    )
    # The choice of the noise model may take longer than the chains, and stood still.
    assert ("noise model", "model 2 of 7, inner step 5 ms") in told
    assert found.chosen.model.scatter == "reading"
    by_id = {p.id: p for p in found.parameters}
    for name in FREE:
        p = by_id[name]
        assert abs(p.mean - TRUTH[name]) < 4.5 * p.std
        assert p.intervals[0.5][0] > p.intervals[0.95][0]
        assert p.diagnostics.rhat < 1.05
    assert "%" in by_id["cycle_scatter"].verdict
    assert found.cycle_log_density.shape[-1] == sum(t.cycles for t in found.mode.density.terms)
    assert set(found.sensitivity) == {"half", "stated", "double"}
    assert found.next_run is not None
    assert found.next_run.after < found.next_run.before


def test_a_fit_at_a_bound_has_coordinates_inside_it(equations):
    coordinates = Coordinates.of(equations, hyper=())
    theta = np.array([q.initial for q in equations.parameters])
    ids = [q.id for q in equations.parameters]
    theta[ids.index("Ks")] = -7e-15
    eta = coordinates.eta(theta)
    assert np.isfinite(eta).all()
    assert (eta >= coordinates.bounds()[0]).all()


def test_the_mode_has_a_covariance_where_the_model_leaves_hundreds_of_times_the_noise(equations):
    """Readings whose noise is stated far too small: the noise factor is large, and no bound of ours holds it."""
    run = make_run(equations, seed=3)
    run = run.but(noise=run.noise / 400)
    forward = KernelForward(equations=equations, step=2.5e-3)
    width = NOISE.estimated_noise_log_std
    problem = Problem(simulator=forward.simulator(), forward=forward, fitted=(run,), unseen=(), noise_width=width)
    mode = problem.mode(NoiseModel(), np.array([q.initial for q in equations.parameters]))
    assert mode.density.hyper(mode.eta[None])["noise_factor"][0] == pytest.approx(400, rel=0.2)
    # N rows know a standard deviation to 1/√(2·N) of its size.
    assert np.sqrt(mode.covariance[-1, -1]) == pytest.approx(1 / np.sqrt(2 * run.t.size), rel=0.2)


class _Trap(Problem):
    """A correlated model error has a better mode from the mode under white noise than from the candidate before."""

    def mode(self, model, theta, hyper=None):
        white = super().mode(NoiseModel(), theta)
        if not model.correlated:
            return white
        return replace(white, density=white.density.but(model=model), log_density=0.0 if hyper is None else -1.0)


@pytest.mark.parametrize(("noise_over_stated", "best_mode"), [(400, 0.0), (1, -1.0)])
def test_a_model_error_is_also_sought_from_the_mode_under_white_noise(
    equations, monkeypatch, noise_over_stated, best_mode
):
    """Where the residual is at the noise the candidates follow one another alone, and stored draws stay as they are."""
    monkeypatch.setattr(choice, "held_out_score", lambda *_: 0.0)
    run = make_run(equations, seed=3)
    run = run.but(noise=run.noise / noise_over_stated)
    forward = KernelForward(equations=equations, step=2.5e-3)
    width = NOISE.estimated_noise_log_std
    problem = _Trap(simulator=forward.simulator(), forward=forward, fitted=(run,), unseen=(), noise_width=width)
    scored = compare(problem, np.array([q.initial for q in equations.parameters]))
    assert next(s for s in scored if s.model == NoiseModel(correlated=True)).mode.log_density == best_mode
