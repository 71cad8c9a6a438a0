"""Whole fits: basins, statuses, covariance, workers, scores."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from haptid.identification.fit.multistart import fit
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.protocol import Trajectory
from haptid.identification.statistics.covariance import curvature
from haptid.identification.statistics.excitation_warnings import excitation_warnings, presliding
from haptid.identification.statistics.score import fit_initial_state, rows_of_start, score
from haptid.identification.workers.workers import Here, Processes
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import NumericalError
from tests.identification.bench_joint import NOISE, TRUE, equations, make_run, runs, simulator


@pytest.fixture(scope="module")
def fitted() -> Fit:
    return fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=4))


def test_fit_reaches_the_noise_on_a_run_it_never_saw(fitted):
    assert fitted.outcome is Outcome.CONVERGED
    unseen = [s for s in fitted.runs if s.use == "validate"]
    assert len(unseen) == 1
    assert unseen[0].over_noise < 1.06
    assert unseen[0].rmse_rad == pytest.approx(NOISE * unseen[0].over_noise)


def test_truth_lies_within_the_error_bars(fitted):
    std = fitted.std
    for id, value in TRUE.items():
        k = fitted.index(id)
        assert abs(fitted.theta[k] - value) < 4.0 * std[k], id
        assert fitted.statuses[id] == "identified"
    assert fitted.statuses["Kp"] == "fixed"


def test_starts_end_early_and_basins_count_them(fitted):
    assert fitted.starts < 4
    assert len(fitted.basins[0].starts) >= 2
    assert sum(len(b.starts) for b in fitted.basins) == fitted.starts


def test_result_does_not_depend_on_the_workers(fitted):
    with Processes(2) as pool:
        shared = fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=4), workers=pool)
    np.testing.assert_array_equal(shared.theta, fitted.theta)
    np.testing.assert_array_equal(shared.covariance, fitted.covariance)
    assert shared.simulations == fitted.simulations
    assert [b.starts for b in shared.basins] == [b.starts for b in fitted.basins]


def test_tasks_are_consumed_in_order_whatever_their_number():
    with Processes(3) as pool:
        for workers in (Here(), pool):
            done = workers.until(divmod, [(k, 2) for k in range(9)], lambda results: 4 - len(results))
            assert done == [divmod(k, 2) for k in range(4)]


def test_no_finite_start_is_a_numerical_error():
    class Broken:
        equations = simulator().equations

        def simulate(self, theta, run, **choices):
            made = simulator().simulate(theta, run, **choices)
            made.y[:] = np.nan
            return made

    with pytest.raises(NumericalError, match="no start gave a finite simulation"):
        fit(Broken(), runs(), options=FitOptions(gains=(0.0,), starts=2))


def test_robust_loss_bears_gross_outliers():
    run = runs()[0]
    y = run.y.copy()
    y[::97] += 0.05
    dirty = (run.but(y=y), *runs()[1:])
    options = FitOptions(
        method="gauss_newton", starts=1, start=tuple(TRUE.get(q.id, 1.0) for q in equations().parameters)
    )
    plain = fit(simulator(), dirty, options=options.but(gains=(0.0,)))
    robust = fit(simulator(), dirty, options=options.but(gains=(0.0,), robust=True))
    k = plain.index("sigma2")
    assert abs(robust.theta[k] / TRUE["sigma2"] - 1) < 0.2 * abs(plain.theta[k] / TRUE["sigma2"] - 1)


def test_prior_alone_is_called_so():
    base = equations()
    free = {"Kp": {"fixed": False, "prior": Normal(mean=1.0, std=0.05), "lower": 0.5, "upper": 2.0}}
    eq = base.with_parameters(free)
    sim = type(simulator())(eq, simulator().kernel)
    start = tuple(TRUE.get(q.id, q.initial) for q in eq.parameters)
    found = fit(sim, runs(), options=FitOptions(method="gauss_newton", gains=(0.0,), starts=1, start=start))
    # Torque in, position out: one factor common to everything cannot be seen, so only the prior knows Kp.
    assert found.statuses["Kp"] == "prior"
    assert found.std[found.index("Kp")] == pytest.approx(0.05, rel=0.05)
    assert any("Kp" in c.coefficients for c in found.combinations)


def test_bound_is_named():
    eq = equations().with_parameters({"Ks": {"lower": 0.016, "initial": 0.02}})
    sim = type(simulator())(eq, simulator().kernel)
    start = tuple(TRUE.get(q.id, q.initial) if q.id != "Ks" else 0.02 for q in eq.parameters)
    found = fit(sim, runs(), options=FitOptions(method="gauss_newton", gains=(0.0,), starts=1, start=start))
    assert found.statuses["Ks"] == "at_bound"


def test_a_range_of_many_decades_does_not_make_a_known_value_one_at_its_bound():
    """A ten-thousandth of the range, which a device file may leave so wide, is many times the spring."""
    eq = equations().with_parameters({"Ks": {"lower": 0.0, "upper": 1e4}})
    sim = type(simulator())(eq, simulator().kernel)
    start = tuple(TRUE.get(q.id, q.initial) for q in eq.parameters)
    found = fit(sim, runs(), options=FitOptions(method="gauss_newton", gains=(0.0,), starts=1, start=start))
    assert found.values["Ks"] == pytest.approx(TRUE["Ks"], rel=0.05)
    assert found.statuses["Ks"] == "identified"


class Line:
    """y = a + b·t on one joint: least squares in closed form."""

    def __init__(self) -> None:
        base = joint_equations(0)
        quantities = tuple(
            Quantity(id=id, unit="1", description=id, initial=0.0, lower=-100.0, upper=100.0) for id in ("a", "b")
        )
        state = base.states[:1]
        self.equations = Equations(
            name="line",
            title="line",
            joints=(),
            states=state,
            inputs=(),
            outputs=(),
            parameters=quantities,
            rhs=(base.rhs[0] * 0,),
            rates=(base.rates[0] * 0,),
        )

    def simulate(self, theta, run, **_):
        y = (theta[0] + theta[1] * run.t)[:, None]
        dy = np.stack((np.ones_like(run.t), run.t), axis=1)[:, None, :]
        return Trajectory(t=run.t, y=y, dy_dtheta=dy, dy_dx0=np.zeros((run.t.size, 1, 1)))


def line_run(noise: np.ndarray) -> Run:
    t = np.linspace(0.0, 1.0, noise.size)
    return Run(
        file="line",
        free_joints=(0,),
        t=t,
        u=np.zeros((t.size, 1)),
        y=(1.0 + 2.0 * t + noise)[:, None],
        noise=np.array([0.1]),
        resolution=np.zeros(1),
        posture=np.zeros(0),
        use="fit",
    )


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_covariance_covers_white_and_correlated_noise(memory):
    rng, line, hits, drawn = np.random.default_rng(5), Line(), [], []
    for _ in range(60):
        white = rng.standard_normal(900)
        noise = 0.1 * np.sqrt(1 - memory**2) * lfilter([1.0], [1.0, -memory], white)
        problem = Problem.of(line, (line_run(noise),), FitOptions(weights=(1.0, 1.0)))
        blocks = problem.blocks(np.zeros(problem.size))
        x = -np.linalg.lstsq(blocks.jacobian, blocks.residual, rcond=None)[0]
        std = np.sqrt(np.diag(curvature(problem, x).covariance))[:2] * problem.parametrisation.unit
        value = problem.theta(x)
        drawn.append((value[1] - 2.0) / std[1])
        hits.append(abs(value[1] - 2.0) < 1.96 * std[1])
    assert np.mean(hits) > (0.9 if memory == 0.0 else 0.8)
    assert np.std(drawn) < (1.2 if memory == 0.0 else 1.5)


def test_starts_are_the_guess_and_points_within_reach():
    parametrisation = Parametrisation.of(equations())
    starts = sobol_starts(parametrisation, parametrisation.initial, 8, 3)
    assert len(starts) == 8
    np.testing.assert_array_equal(starts[0], parametrisation.initial)
    again = sobol_starts(parametrisation, parametrisation.initial, 8, 3)
    assert all(np.array_equal(a, b) for a, b in zip(starts, again, strict=True))
    k = [q.id for q in equations().parameters].index("sigma0")
    assert all(0.49 < s[k] / parametrisation.initial[k] < 2.01 for s in starts)


def test_every_start_meets_the_orderings_also_at_a_bound():
    # Stiction that hardly reaches Coulomb friction: half of all points around the guess lie outside.
    tight = equations().with_parameters({"Fs": {"initial": TRUE["Fc"], "upper": 1.05 * TRUE["Fc"]}})
    parametrisation = Parametrisation.of(tight)
    starts = np.array(sobol_starts(parametrisation, parametrisation.initial, 16, 3))
    Fs, Fc = (starts[:, [q.id for q in tight.parameters].index(id)] for id in ("Fs", "Fc"))
    assert (Fs >= Fc * (1 - 1e-9)).all()
    assert (Fs <= 1.05 * TRUE["Fc"] * (1 + 1e-12)).all()
    assert np.ptp(Fc) > 0.1 * TRUE["Fc"]


def test_score_profiles_the_start_of_an_unseen_run(fitted):
    unseen = runs()[2]
    off = unseen.y.copy()
    off[0] += 5 * NOISE
    judged = score(simulator(), fitted, unseen.but(y=off))
    assert judged.over_noise < 1.06


def test_start_of_an_unseen_run_hangs_on_its_first_rows_alone(fitted):
    unseen = runs()[2]
    later = unseen.y.copy()
    later[rows_of_start(unseen) :] += 0.1
    made = [fit_initial_state(simulator(), fitted.theta, run) for run in (unseen, unseen.but(y=later))]
    np.testing.assert_array_equal(*made)
    assert rows_of_start(unseen) == 61
    assert rows_of_start(unseen.but(score_from=400)) == 400


def test_warns_of_runs_that_never_slide_or_never_stick():
    def theta_of(known: Equations) -> np.ndarray:
        return np.array([TRUE.get(q.id, q.initial) for q in known.parameters])

    eq = equations()
    theta = theta_of(eq)
    t = np.linspace(0.0, 10.0, 2001)
    tiny = 1e-4 * np.sin(t)[:, None]
    said = " ".join(excitation_warnings(eq, theta, [(t, tiny)]))
    assert said.startswith("the runs never leave")
    assert "never leave presliding" in said
    assert "never faster than vs" in said
    # A stiction that ran away makes all rows presliding, though friction in sliding is well known.
    assert excitation_warnings(eq, theta, [(t, tiny)], ["Fc", "sigma2"]) == ()
    assert "never leave presliding" in " ".join(excitation_warnings(eq, theta, [(t, tiny)], ["Fc"]))
    assert said.split("(")[-1].split(")")[0].endswith("rad/s")
    slide = joint_equations(0, prismatic=True)
    said = " ".join(excitation_warnings(slide, theta_of(slide), [(t, tiny)]))
    assert said.split("(")[-1].split(")")[0].endswith(" m/s")
    steady = 3.0 * t[:, None]
    assert "in presliding" in " ".join(excitation_warnings(eq, theta, [(t, steady)]))
    run = make_run(0.005, 1.13)
    assert excitation_warnings(eq, theta, [(run.t, run.y)]) == ()


def test_presliding_counts_from_the_last_reversal():
    y = np.concatenate([np.linspace(0, 1, 101), np.linspace(0.99, 0, 100)])
    inside = presliding(y, 0.055)
    assert inside[:6].all()
    assert not inside[10:100].any()
    assert inside[100:106].all()
    assert not inside[110:].any()
