"""Standard errors against the truth of the virtual device, where contacts make the likelihood rough and where not."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.candidate.refit import sharpen_discontinuities
from haptid.discrepancy.fit.nominal_fit import fit_nominal
from haptid.discrepancy.fit.scatter import cycles_of
from haptid.discrepancy.fit.solution import Solution, deviance, solve
from haptid.discrepancy.fit.standard_errors import covariance, of_curvature, rough, standard_errors
from haptid.discrepancy.study.study import Study, scales_over
from haptid.discrepancy.verdict.verdict import finer
from haptid.measurement.values.run import Array
from haptid.model.effects.registry import catalogue
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.noise.correlation import Noise, Scatter
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import TRUTH, study_with

SLACK = {
    "inertia": 1.1e-4, "rotor_inertia": 5e-5, "tendon_stiffness": 3.0, "tendon_damping": 4e-3, "tendon_slack": 0.01,
}  # fmt: skip
AS_FITTED = {
    "slack_half_width": 0.01, "slack_compliance": 1 / 3, "slack_rotor_share": 5 / 16, "slack_damping_time": 4e-3 / 3,
}  # fmt: skip
SOFTER = SLACK | {"tendon_stiffness": 0.8, "tendon_damping": 8e-4, "tendon_slack": 0.02}
SOFTER_AS_FITTED = AS_FITTED | {"slack_half_width": 0.02, "slack_compliance": 1.25, "slack_damping_time": 1e-3}


def fitted(
    tmp_path: Path, key: str, hidden: dict[str, float], start: dict[str, float], seed: int = 5
) -> tuple[Study, Solution]:
    study = study_with(tmp_path / "c", {key: hidden}, {key: catalogue()[key]}, seed=seed)
    base = fit_nominal(study, starts=2, seed=0).solution
    effect = catalogue()[key].at(scales_over(study.fitted, base.values, law_named(DEFAULT).roles))
    first = solve(study, (effect,), Noise(), TRUTH | start, x0=base.x0)
    return study, sharpen_discontinuities(study, first, first.calls)[0]


def by_id(solution: Solution, errors: Array) -> dict[str, float]:
    return dict(zip([q.id for q in solution.equations.parameters], errors.tolist(), strict=True))


def off(solution: Solution, std: dict[str, float], truths: dict[str, float]) -> float:
    """Return the largest distance from the truth, in standard errors."""
    return max(abs(solution.values[id] - truth) / std[id] for id, truth in truths.items())


def test_errors_of_a_play_cover_all_minima_that_the_likelihood_allows(tmp_path: Path):
    study, solution = fitted(tmp_path, "tendon_slack", SLACK, AS_FITTED)
    best, errors = standard_errors(study, solution)
    std, plain = by_id(best, errors), by_id(solution, of_curvature(solution))
    assert off(solution, plain, AS_FITTED) > 2.5
    assert off(best, std, AS_FITTED) < 2.5
    assert all(std[id] >= plain[id] for id in AS_FITTED)


@pytest.mark.long
def test_a_slack_is_told_as_abrupt_as_it_is_and_with_all_minima_of_the_likelihood(tmp_path: Path):
    """Contacts rounded off as in the search, and errors of one minimum's curvature, miss the truth of these data."""
    study, solution = fitted(tmp_path, "tendon_slack", SOFTER, SOFTER_AS_FITTED, seed=15)
    fine, at_first = finer(study, solution)
    best, errors = standard_errors(fine, at_first, solution)
    std, plain = by_id(best, errors), by_id(solution, of_curvature(solution))
    assert best.values["slack_contact"] == pytest.approx(solution.values["slack_contact"] / 10.0)
    assert best.log_likelihood >= at_first.log_likelihood
    assert off(solution, plain, SOFTER_AS_FITTED) > 2.5
    assert off(best, std, SOFTER_AS_FITTED) < 2.0
    assert all(std[id] >= e for id, e in plain.items())


@pytest.mark.long
def test_errors_of_a_smooth_effect_are_those_of_its_curvature(tmp_path: Path):
    study, solution = fitted(tmp_path, "cubic_spring", {"spring_cubic": 0.02}, {"k3": 0.02})
    best, errors = standard_errors(study, solution)
    std = by_id(solution, errors)
    assert best is solution
    assert std == by_id(solution, of_curvature(solution))
    assert std["gravity_cos"] == 0.0
    (spring,) = solution.effects
    aside = spring.parameters[0].but(initial=solution.values["k3"] + 2.0 * std["k3"], fixed=True)
    values = {id: p for id, p in solution.values.items() if id != "k3"}
    refitted = solve(study, (spring.but(parameters=(aside,)),), Noise(), values, x0=solution.x0)
    assert refitted.chi2 - solution.chi2 == pytest.approx(4.0, rel=0.05)


def test_a_ridge_that_bends_is_smooth(tmp_path: Path):
    """Number, phase and amplitude of a wave: straight on, the likelihood falls far more than its curvature says."""
    hidden = {"cogging": 2e-4, "cogging_number": 3.0, "cogging_phase": 0.4}
    start = {"cogging_sin": 2e-4 * np.cos(0.4), "cogging_cos": 2e-4 * np.sin(0.4), "cogging_number": 3.0}
    study, solution = fitted(tmp_path, "cogging", hidden, start)
    C, k = covariance(solution), solution.problem.parametrisation.ids.index("cogging_number")
    valley = C[:, k] / np.sqrt(C[k, k])
    assert deviance(study, solution, solution.x + valley) + 2.0 * solution.log_likelihood > 3.0
    assert not rough(study, solution, k, valley)
    best, errors = standard_errors(study, solution)
    assert best is solution
    np.testing.assert_array_equal(errors, of_curvature(solution))


def test_of_a_stop_that_no_run_reaches_no_more_is_known_than_its_bounds(tmp_path: Path):
    _, solution = fitted(tmp_path, "cubic_spring", {"spring_cubic": 0.02}, {"k3": 0.02})
    J = solution.blocks.jacobian.copy()
    k = solution.problem.parametrisation.ids.index("k3")
    J[:, k] = 0.0
    unseen = SimpleNamespace(
        blocks=SimpleNamespace(jacobian=J), problem=solution.problem, x=solution.x, theta=solution.theta
    )
    (spring,) = solution.effects
    width = spring.parameters[0].upper - spring.parameters[0].lower
    assert np.sqrt(covariance(unseen)[k, k]) * solution.problem.parametrisation.slope(solution.theta)[
        k
    ] == pytest.approx(width / np.sqrt(12.0))


def test_a_lag_of_a_fifth_of_the_inner_step_is_told_from_a_finer_one(tmp_path: Path):
    lag = 4.5e-4
    listed = {"amplifier_lag:rest": catalogue()["amplifier_lag:rest"]}
    sensor = Sensor(noise=2e-5, resolution=0.0)
    study = study_with(tmp_path, {"amplifier_lag": {"amplifier_lag": lag}}, listed, sensor)
    coarse = solve(study, tuple(listed.values()), Noise(), TRUTH | {"lag_time": lag})
    fine = finer(study, coarse)[1]
    assert coarse.values["lag_time"] < 0.9 * lag
    assert fine.values["lag_time"] == pytest.approx(lag, rel=0.02)


def test_beside_a_torque_that_scatters_errors_hold_the_factor_that_all_torques_share(tmp_path: Path):
    """n cycles of scatter s leave the mean torque open by s/√n, and all that a torque is measured against with it."""
    s = 0.02
    study = study_with(tmp_path / "c", {"amplitude_scatter": {"scatter": s, "scatter_on_torque": 1.0}}, {})
    scatter = Scatter(size=s, path="torque")
    base = fit_nominal(study, starts=2, seed=0).solution
    solution = solve(study, (), Noise(scatters=(scatter,)), TRUTH, x0=base.x0)
    shared = s / np.sqrt(sum(cycles_of(run, scatter).count for run in study.fitted))
    curved, told = (by_id(solution, e) for e in (of_curvature(solution), standard_errors(study, solution)[1]))
    assert curved == told
    for id in ("inertia", "Ks", "Fc", "sigma2"):
        assert told[id] / solution.values[id] == pytest.approx(shared, rel=0.2), id
        assert abs(solution.values[id] - TRUTH[id]) < 3.0 * told[id]
