"""Steps of the search on joints of the virtual device: stand-ins, what is known already, chance finds."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.candidate.candidate import score_candidate, significance
from haptid.discrepancy.candidate.refit import begin, settle
from haptid.discrepancy.candidate.starts import start_values, starts_of
from haptid.discrepancy.candidate.trial import Trial, keys_of
from haptid.discrepancy.detect.inner_step import at_step, visible
from haptid.discrepancy.detect.omnibus import Omnibus
from haptid.discrepancy.detect.score_tests import scan
from haptid.discrepancy.detect.signatures import signatures
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.fit.homotopy import through_homotopy
from haptid.discrepancy.fit.nominal_fit import agreeing, fit_nominal
from haptid.discrepancy.fit.scatter import relinearise_cycles
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.search import backward_elimination, forward_selection
from haptid.discrepancy.search.backward_elimination import exchange_effects, prune_stand_ins
from haptid.discrepancy.search.forward_selection import _ways
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.search.step_refinement import refine_step
from haptid.discrepancy.search.trials.finishing import find_finished, find_twins, finish, finish_best
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.discrepancy.search.trials.preliminary_fits import begin_effects
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.study.study import Study, scales_over
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.verdict import at_their_bounds
from haptid.identification.problem.initial_states import first_slopes, start_of
from haptid.identification.problem.residuals import Blocks
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.noise.correlation import Arma, Noise, Scatter
from haptid.support.listener import ignore_progress
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import EFFECTS, study_with


def tools_of(study: Study, starts: int) -> tuple[Searcher, Trial]:
    """Return the tools of the search, and the base under white noise."""
    base = fit_nominal(study, starts=starts).solution
    effects = study.in_si(base.values)
    found = signatures(study, base, list(effects.values()))
    searcher = Searcher(study, effects, found, scan(study, base, found, effects).tests, ignore_progress)
    return searcher, judge_candidate(searcher, score_candidate(study, base, 0))


def tools(folder: Path, sensor: Sensor) -> tuple[Searcher, Trial]:
    """Return the tools of the search on a joint with a hidden cubic spring, and the base."""
    study = study_with(folder / "c", {"cubic_spring": {"spring_cubic": 0.02}}, EFFECTS, sensor)
    return tools_of(study, starts=4)


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> tuple[Searcher, Trial]:
    return tools(tmp_path_factory.mktemp("search"), Sensor(noise=2e-4))


@pytest.fixture(scope="module")
def among_drifts(tmp_path_factory: pytest.TempPathFactory) -> tuple[Searcher, Trial]:
    """Return the tools where a catalogue of weight and drifts is searched beside the spring that is hidden."""
    keys = ("cubic_spring", "payload_gravity", "coulomb_drift", "viscous_drift", "gain_drift")
    folder, hidden = tmp_path_factory.mktemp("drifts"), {"cubic_spring": {"spring_cubic": 0.02}}
    return tools_of(study_with(folder, hidden, {key: catalogue()[key] for key in keys}), starts=2)


def test_the_rivals_of_what_scores_best_are_begun_too_whichever_names_the_other(
    among_drifts: tuple[Searcher, Trial],
) -> None:
    s, start = among_drifts
    assert "payload_gravity" not in s.catalogue["cubic_spring"].rivals
    scored = [score.key for score in s.beside(start.solution, s.scan(start.solution))]
    assert scored[0] in ("cubic_spring", "payload_gravity")
    assert {fit.effects[-1].key for fit in begin_effects(s, start.solution, 1)} == {"cubic_spring", "payload_gravity"}


def clean(start: Trial, effect: Effect, parameters: int, bic: float) -> Trial:
    """Return a trial of one effect that leaves nothing but noise."""
    left = Omnibus(energy=100.0, dof=100.0, p=0.5, parts={}, total=100.0, rows=100)
    prediction = replace(start.candidate.prediction, chi2=100.0, rows=100, excess=0.0)
    solution = replace(start.solution, effects=(effect,))
    made = replace(start.candidate, solution=solution, prediction=prediction, parameters=parameters, bic=bic)
    return Trial(candidate=made, left=left, left_p=0.5, gain=100.0, held_out=100.0, least_evidence=100.0)


@pytest.mark.parametrize(
    ("key", "further", "worse", "rival"),
    [
        ("payload_gravity", 2, 9.0, True),
        ("payload_gravity", 2, 11.0, False),
        ("payload_gravity", 0, 11.0, False),
        ("gain_drift", 0, 9.0, True),
        ("gain_drift", 2, 0.0, False),
    ],
)
def test_a_rival_of_the_catalogue_that_fits_as_well_need_not_earn_its_parameters(
    among_drifts: tuple[Searcher, Trial], key: str, further: int, worse: float, rival: bool
) -> None:
    """``worse`` is its criterion beside what its ``further`` parameters cost."""
    s, start = among_drifts
    price = further * np.log(s.study.rows)
    best = clean(start, s.catalogue["cubic_spring"], 1, 0.0)
    other = clean(start, s.catalogue[key], 1 + further, price + worse)
    found = Search(study=s.study, base=None, plain=start, scan=None, trials=(best, other), best=best)
    assert [t.candidate.ids for t in found.rivals] == ([(key,)] if rival else [])


@pytest.mark.parametrize(("worse", "rival"), [(9.0, True), (11.0, False)])
def test_what_is_just_not_adequate_is_a_rival_by_its_criterion(
    among_drifts: tuple[Searcher, Trial], worse: float, rival: bool
) -> None:
    s, start = among_drifts
    best, other = (
        clean(start, s.catalogue[key], 1, bic) for key, bic in (("gain_drift", 0.0), ("cubic_spring", worse))
    )
    other = replace(other, left_p=1e-4)
    assert best.adequate
    assert not other.adequate
    found = Search(study=s.study, base=None, plain=start, scan=None, trials=(best, other), best=best)
    assert found.rivals == ((other,) if rival else ())


def test_variants_that_predict_as_well_are_no_rivals_but_may_be_the_truth_too(
    among_drifts: tuple[Searcher, Trial],
) -> None:
    s, start = among_drifts
    effects = catalogue()
    best, other, far = (
        clean(start, effects[f"end_stop:{variant}"], 2, bic)
        for variant, bic in (("upper", 0.0), ("lower", 9.0), ("both", 11.0))
    )
    rest, settled = (
        clean(start, effects[f"amplifier_lag:{variant}"], 1, bic) for variant, bic in (("rest", 3.0), ("settled", 2.0))
    )
    trials = (best, other, far, rest, settled)
    found = Search(study=s.study, base=None, plain=start, scan=None, trials=trials, best=best)
    assert found.rivals == (settled,)
    assert found.variants(best) == (other,)
    assert found.variants(settled) == (rest,)


@pytest.mark.long
def test_what_is_fitted_side_by_side_changes_neither_trials_nor_their_cost(
    among_drifts: tuple[Searcher, Trial],
) -> None:
    s, start = among_drifts
    solution, rough = start.solution, at_step(s.study, THRESHOLDS.study.coarse_step_s)
    scores = {score.key: score for score in s.scan(solution).scores}
    fits = [begin(rough, solution, s.catalogue[key], scores[key]) for key in scores if key.endswith("drift")]
    assert len(fits) == 3

    def stepped(threads: int) -> tuple[list[tuple[tuple[str, ...], float]], int]:
        study = replace(s.study, threads=threads)
        own = Searcher(study, s.catalogue, s.found, s.tests, ignore_progress)
        made = finish_best(own, start.candidate, fits, most=3, freed=True)
        assert len(made) == 2  # the third is fitted beside the second, in vain
        return [(t.solution.keys, t.solution.log_likelihood) for t in made], own.simulations

    assert stepped(1) == stepped(2)


@pytest.mark.long
@pytest.mark.parametrize("nothing", [("cogging",), ("cogging", "asymmetric_viscous")])
def test_what_comes_to_nothing_beside_another_effect_is_taken_out(
    begun: tuple[Searcher, Trial], nothing: tuple[str, ...]
) -> None:
    """A gain and a friction that drift had stood in for a clock error, and both were still there beside it."""
    s, start = begun
    effects = [*(stand_in(s, start, key) for key in nothing), s.catalogue["cubic_spring"]]
    both = solve(s.study, effects, Noise(), start.solution.values | {"k3": 0.02}, x0=start.solution.x0)
    full = judge_candidate(s, settle(s.study, effects, both), start.candidate)
    assert full.adequate
    assert not full.acceptable
    (left,) = prune_stand_ins(s, [full], start)
    assert left.solution.ids == ("cubic_spring",)
    assert left.adequate
    assert prune_stand_ins(s, [left], start) == []


def stand_in(s: Searcher, start: Trial, key: str) -> Effect:
    """An effect that the searcher's catalogue lacks."""
    return catalogue()[key].at(scales_over(s.study.fitted, start.solution.values, law_named(DEFAULT).roles))


@pytest.mark.long
def test_beside_effects_that_the_catalogue_was_tried_on_nothing_is_exchanged(
    begun: tuple[Searcher, Trial], monkeypatch: pytest.MonkeyPatch
) -> None:
    s, start = begun
    effects = [stand_in(s, start, key) for key in ("quadratic_drag", "asymmetric_viscous")]
    both = solve(s.study, effects, Noise(), start.solution.values, x0=start.solution.x0)
    best = judge_candidate(s, settle(s.study, effects, both), start.candidate)
    assert not best.adequate
    asked: list[frozenset[str]] = []
    monkeypatch.setattr(
        backward_elimination, "begin_effects", lambda _, solution, __: asked.append(keys_of(solution)) or []
    )
    monkeypatch.setattr(Omnibus, "far", False)
    exchange_effects(s, best, start)
    assert asked == [{"asymmetric_viscous"}]
    tried = replace(s, extended={frozenset({"asymmetric_viscous"})})
    exchange_effects(tried, best, start)
    assert len(asked) == 1


@pytest.mark.long
def test_what_leaves_more_than_the_steps_error_is_not_fitted_again_at_a_finer_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    s, start = tools(tmp_path, Sensor(noise=2e-5, resolution=0.0))
    rough = replace(s, study=at_step(s.study, THRESHOLDS.study.signature_step_s))
    other = stand_in(s, start, "asymmetric_viscous")
    wrong = solve(rough.study, [other], Noise(), start.solution.values, x0=start.solution.x0)
    trial = judge_candidate(rough, score_candidate(rough.study, wrong, wrong.calls), start.candidate)
    monkeypatch.setattr(Omnibus, "far", False)
    assert not trial.adequate
    error = visible(rough.study, trial.solution, THRESHOLDS.study.signature_step_s)
    assert (
        trial.left.energy - trial.left.dof
        > THRESHOLDS.search.least_excess_over_step_error * error
        > THRESHOLDS.search.least_excess_over_step_error * THRESHOLDS.detect.invisible_step_error_chi2
    )
    assert refine_step(rough, trial, [trial]) is None
    near = replace(trial, left=replace(trial.left, energy=trial.left.dof + error))
    assert refine_step(rough, near, [near]) is not None


@pytest.mark.long
def test_an_effect_that_its_curvature_says_is_nothing_stays_where_a_fit_without_it_loses(tmp_path: Path):
    hidden = {"cubic_spring": {"spring_cubic": 0.02}, "asymmetric_viscous": {"viscous_asymmetry": 0.1}}
    study = study_with(tmp_path, hidden, {key: catalogue()[key] for key in hidden}, Sensor(noise=2e-4))
    base = fit_nominal(study, starts=2, seed=0).solution
    effects = [e.at(scales_over(study.fitted, base.values, law_named(DEFAULT).roles)) for e in study.catalogue.values()]
    s = Searcher(study, {e.key: e for e in effects}, signatures(study, base, effects), 1.0, ignore_progress)
    start = judge_candidate(s, score_candidate(study, base, base.calls))
    both, _ = through_homotopy(study, effects, {"k3": 0.02, "viscous_asymmetry": 0.05})
    full = judge_candidate(s, settle(study, effects, both), start.candidate)
    assert full.acceptable
    doubtful = replace(full, least_evidence=THRESHOLDS.candidate.least_wald_statistic / 2)
    assert not doubtful.acceptable
    (kept,) = prune_stand_ins(s, [doubtful], start)
    assert kept.solution is full.solution
    assert kept.least_evidence > 100.0


def test_an_effect_that_begins_too_large_begins_again_smaller(tmp_path: Path):
    effects = {"friction_lag": catalogue()["friction_lag"]}
    study = study_with(tmp_path, {"friction_lag": {"stribeck_lag": 0.017}}, effects, Sensor(noise=2e-4))
    base = fit_nominal(study, starts=2, seed=0).solution
    effect = effects["friction_lag"].at(scales_over(study.fitted, base.values, law_named(DEFAULT).roles))
    score = scan(study, base, signatures(study, base, [effect]), {effect.key: effect}).scores[0]
    large = replace(score, amplitude=(5.0,))
    values = base.values | start_values(effect, score.point, large.amplitude)
    lost = solve(
        study,
        (effect,),
        Noise(),
        values,
        x0=base.x0,
        iterations=THRESHOLDS.candidate.first_try_simulations,
        tolerance=THRESHOLDS.fit.rough_tolerance_chi2,
    )
    assert lost.log_likelihood < base.log_likelihood - THRESHOLDS.candidate.largest_first_try_loss
    assert begin(study, base, effect, large).log_likelihood > base.log_likelihood


def test_what_was_fitted_to_the_end_is_not_fitted_again_from_a_start_that_is_no_better(
    begun: tuple[Searcher, Trial],
) -> None:
    s, start = begun
    score = next(score for score in s.scan(start.solution).scores if score.key == "cubic_spring")
    fit = begin(s.study, start.solution, s.catalogue["cubic_spring"], score)
    assert find_finished(s, start.candidate, fit) is None
    made = finish(s, start.candidate, fit)
    again = find_finished(s, start.candidate, fit)
    assert again is not None
    assert again.candidate is made.candidate
    better = replace(fit, log_likelihood=made.solution.log_likelihood + 1e3)
    assert find_finished(s, start.candidate, better) is None


def test_a_score_that_no_entry_confirms_does_not_make_a_gap(begun: tuple[Searcher, Trial]) -> None:
    clean = Omnibus(energy=100.0, dof=100.0, p=0.5, parts={}, total=100.0, rows=100)
    prediction = replace(begun[1].candidate.prediction, chi2=100.0, rows=100)
    base = Trial(
        candidate=replace(begun[1].candidate, prediction=prediction),
        left=clean,
        left_p=(THRESHOLDS.candidate.family_wise_p_value * THRESHOLDS.candidate.refuted_family_wise_p_value) ** 0.5,
    )
    assert not base.adequate
    assert replace(base, refuted=True).adequate
    assert not replace(base, refuted=True, left_p=0.5 * THRESHOLDS.candidate.refuted_family_wise_p_value).adequate
    assert not replace(base, refuted=True, left=replace(clean, p=1e-6)).adequate


@pytest.mark.parametrize(
    ("scatter", "left", "entry", "tried"),
    [(0.03, 0.05, 0.5, True), (0.03, 0.5, 0.5, False), (0.0, 0.05, 0.5, False), (0.03, 0.05, 0.05, False)],
)
def test_entries_are_tried_under_scatter_where_it_makes_up_for_most_of_a_large_gap_and_none_of_them_does(
    begun: tuple[Searcher, Trial],
    scatter: float,
    left: float,
    entry: float,
    tried: bool,
    monkeypatch: pytest.MonkeyPatch,
):
    s, start = begun
    base = start.solution
    noise = Noise(scatters=(Scatter(size=scatter, path="torque"),) if scatter else ())
    far = Omnibus(energy=1e5, dof=100.0, p=0.0, parts={}, total=1e5, rows=100)

    def with_share(share: float) -> Blocks:
        return replace(base.blocks, rows=tuple(np.sqrt(share) * r for r in base.blocks.rows), prior=np.zeros(0))

    scattered = replace(base, noise=noise, blocks=with_share(left))
    explained = replace(base, blocks=with_share(entry))
    bare = replace(base, blocks=replace(base.blocks, prior=np.zeros(0)))
    seen: list[Noise] = []
    monkeypatch.setattr(forward_selection, "begin_effects", lambda _, fit, *__: seen.append(fit.noise) or [explained])
    list(_ways(s, replace(start, left=far, candidate=replace(start.candidate, solution=scattered)), bare))
    assert seen == [Noise(), *([noise] if tried else [])]


def test_minima_count_as_one_by_the_noise_or_by_their_share_of_a_large_gap():
    assert agreeing((1000.4, 1000.0, 1002.0), rows=1000) == 2
    assert agreeing((5.0001e6, 5.0e6, 5.2e6), rows=1000) == 2
    assert agreeing((), rows=1000) == 0


@pytest.mark.parametrize(("slack", "none"), [(0.0, True), (1e-4, True), (2.2e-3, True), (3e-3, False)])
def test_a_slack_that_cannot_be_told_from_none_stands_for_something_else(slack: float, none: bool):
    rng = np.random.default_rng(7)
    ids = ("slack_half_width", "slack_compliance", "slack_rotor_share", "slack_damping_time")
    parametrisation = SimpleNamespace(
        ids=ids, to_coordinates=lambda p: p, bounds=(np.array([0, 0, 0.02, 1e-5]), np.ones(4))
    )
    blocks = SimpleNamespace(jacobian=rng.standard_normal((400, 4)) * (50.0, 1e3, 1e3, 1e3))
    x = np.array([slack, 0.1, 0.3, 0.005])
    problem = SimpleNamespace(parametrisation=parametrisation)
    found = SimpleNamespace(problem=problem, blocks=blocks, x=x, theta=x, effects=(catalogue()["tendon_slack"],))
    wald, at_bound = significance(found)
    assert wald == np.inf
    assert at_bound == none


@pytest.mark.parametrize(
    ("key", "size", "none"),
    [
        ("tendon_elasticity", 2e-3, True),  # a pole of rotor and tendon may do what neither is
        ("tendon_elasticity", 4e-3, False),
        ("amplifier_dead_band:jump", 2e-3, False),  # where a jump lies changes nothing between two torques
    ],
)
def test_a_lone_amplitude_that_cannot_be_told_from_none_stands_for_something_else(key: str, size: float, none: bool):
    effect, rng = catalogue()[key], np.random.default_rng(7)
    lower, upper = (np.array([getattr(q, end) for q in effect.parameters]) for end in ("lower", "upper"))
    ids = tuple(q.id for q in effect.parameters)
    parametrisation = SimpleNamespace(ids=ids, to_coordinates=lambda p: p, bounds=(lower, upper))
    x = np.array([size, *(q.initial for q in effect.parameters[1:])])
    blocks = SimpleNamespace(jacobian=rng.standard_normal((400, x.size)) * 1e3)
    blocks.jacobian[:, 0] *= 0.05  # 0.001 of the amplitude is one standard error
    problem = SimpleNamespace(parametrisation=parametrisation)
    found = SimpleNamespace(problem=problem, blocks=blocks, x=x, theta=x, effects=(effect,))
    assert significance(found)[1] == none


def test_an_effect_found_earlier_has_to_stay_significant_beside_the_last_one():
    rng = np.random.default_rng(8)
    effects = (catalogue()["cubic_spring"], catalogue()["quadratic_drag"])
    ids = tuple(e.parameters[0].id for e in effects)
    parametrisation = SimpleNamespace(ids=ids, to_coordinates=lambda p: p, bounds=(-np.ones(2), np.ones(2)))
    blocks = SimpleNamespace(jacobian=rng.standard_normal((400, 2)))
    for x, significant in ((np.array([0.5, 0.0]), True), (np.array([0.01, 0.5]), False)):
        problem = SimpleNamespace(parametrisation=parametrisation)
        found = SimpleNamespace(problem=problem, blocks=blocks, x=x, theta=x, effects=effects)
        assert (significance(found)[0] > THRESHOLDS.candidate.least_wald_statistic) == significant


def test_a_finding_without_a_name_says_which_entry_it_is_like(begun: tuple[Searcher, Trial]):
    _, start = begun
    clean = Omnibus(energy=100.0, dof=100.0, p=0.5, parts={}, total=100.0, rows=100)
    prediction = replace(start.candidate.prediction, chi2=100.0, rows=100, excess=0.0)
    solution = replace(start.solution, effects=(catalogue()["tendon_slack"],))
    near = replace(start.candidate, solution=solution, prediction=prediction)
    slack = Trial(candidate=near, left=clean, left_p=0.5, at_bound=True)
    assert at_their_bounds((slack, slack)) == ("tendon_slack",)
    assert at_their_bounds((replace(slack, at_bound=False), replace(slack, left_p=0.0))) == ()


def test_a_large_compliance_is_begun_at_its_size_though_it_scores_nothing(begun: tuple[Searcher, Trial]) -> None:
    s, start = begun
    score = next(score for score in s.scan(start.solution).scores if score.key == "cubic_spring")
    assert len(starts_of(s.catalogue["cubic_spring"], score)) == 1
    tendon = catalogue()["tendon_elasticity"]
    values = {q.id: q.initial for q in tendon.parameters}
    nothing = replace(score, T=0.0, amplitude=(0.0,), point=replace(score.point, values=(values,)))
    assert [own["tendon_compliance"] for own in starts_of(tendon, nothing)] == [0.4]
    something = replace(nothing, T=5.0, amplitude=(0.5,))
    assert [own["tendon_compliance"] for own in starts_of(tendon, something)] == [0.005, 0.4]


def test_a_run_whose_start_moves_only_once_its_scatter_is_out_is_predicted(begun: tuple[Searcher, Trial]) -> None:
    s, start = begun
    solution, noise = start.solution, Noise(scatters=(Scatter(size=0.03, path="torque"),))
    simulator, run = s.study.factory(solution.equations), s.study.fitted[0]
    slope, std = (float(each[0]) for each in first_slopes(run))
    moved = slope
    for _ in range(3):
        aim = np.sign(moved - slope) * IDENTIFICATION.least_initial_velocity_in_std * std - (moved - slope) / 2
        ramp = (aim - slope) * run.t * np.exp(-((run.t / 0.3) ** 4))
        run = run.but(y=run.y + ramp[:, None])
        about, _ = relinearise_cycles(simulator, run, noise, solution.theta, solution.x0[0])
        slope, moved = float(first_slopes(run)[0][0]), float(first_slopes(about)[0][0])
    assert [len(start_of(solution.equations, each).states) for each in (run, about)] == [1, 2]
    assert np.isfinite(predict(s.study, solution, [run], noise=noise).score)


def test_effects_may_not_take_a_gap_for_correlated_noise_where_the_noise_is_stated(
    begun: tuple[Searcher, Trial],
) -> None:
    s, start = begun
    assert s.study.noise_given
    (run,) = s.study.unseen
    gap = start.candidate.prediction.rms[0] ** 2 / run.sensor_std[0] ** 2 - 1.0
    assert start.candidate.prediction.excess == pytest.approx(gap - 5.0 * np.sqrt(2.0 / run.t.size))
    estimated = predict(replace(s.study, noise_given=False), start.solution)
    assert estimated.excess == 0.0
    scatter = Scatter(size=1e-6, path="reading")
    for noise in (
        Noise(scatters=(scatter,)),
        Noise(arma=Arma(phi=0.98, theta=0.95, sigma=2.0), scatters=(scatter,)),
    ):
        beside = predict(s.study, start.solution, noise=noise)  # a scatter of next to nothing, correlation or none
        assert beside.excess == pytest.approx(start.candidate.prediction.excess, rel=0.05)
    large = predict(s.study, start.solution, noise=Noise(scatters=(scatter.but(size=0.2),)))
    assert large.excess == pytest.approx(large.chi2 / large.rows - 1.0 - 5.0 * np.sqrt(2.0 / large.rows))
    assert large.excess < 0.8 * gap
    clean = Omnibus(energy=100.0, dof=100.0, p=0.5, parts={}, total=100.0, rows=100)
    whitened = replace(start.candidate.prediction, chi2=100.0, rows=100, excess=0.1)
    explained = replace(start.solution, effects=(catalogue()["cubic_spring"],))
    bare, named = (replace(start.candidate, solution=x, prediction=whitened) for x in (start.solution, explained))
    assert Trial(candidate=bare, left=clean).passes
    assert not Trial(candidate=named, left=clean).passes


@pytest.mark.parametrize(("number", "long"), [(1.02, True), (1.2, True), (2.0, False)])
def test_a_wave_that_cannot_be_told_from_the_longest_one_stands_for_something_else(number: float, long: bool):
    rng = np.random.default_rng(9)
    cogging = catalogue()["cogging"]
    parametrisation = SimpleNamespace(
        ids=("cogging_sin", "cogging_cos", "cogging_number"),
        to_coordinates=lambda p: np.array([p[0], p[1], 0.0]),
        bounds=(np.array([-1.0, -1.0, 0.0]), np.array([1.0, 1.0, 3.0])),
    )
    blocks = SimpleNamespace(jacobian=rng.standard_normal((400, 3)) * (1e3, 1e3, 0.4))  # ln n is known to 0.125
    x = np.array([0.2, 0.3, np.log(number)])
    found = SimpleNamespace(
        problem=SimpleNamespace(parametrisation=parametrisation), blocks=blocks, x=x, theta=x, effects=(cogging,)
    )
    assert significance(found)[1] == long


@pytest.mark.parametrize("order", [("tendon_slack", "lock_compliance"), ("lock_compliance", "tendon_slack")])
def test_every_effect_of_a_model_may_have_another_name(begun: tuple[Searcher, Trial], order: tuple[str, str]):
    s = begun[0]
    effects = tuple(catalogue()[key] for key in order)
    s = Searcher(s.study, catalogue(), s.found, s.tests, s.tell)
    ((twin, names),) = find_twins(s, effects)
    assert [e.key for e in twin] == [key.replace("tendon_slack", "backlash:motor") for key in order]
    assert names["slack_half_width"] == "gear_play"
    assert list(find_twins(s, (*effects, catalogue()["backlash:encoder"]))) == []
