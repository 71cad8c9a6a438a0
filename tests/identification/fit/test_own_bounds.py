"""Bounds that haptid chose, and terms that a joint does not have: a stiff pendulum with plain Coulomb friction."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import odeint

from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.fit.fit_runs import Fitted, JointTest, fit_runs
from haptid.identification.fit.own_bounds import fit_within_own_bounds, wider_ranges
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.statistics.absent import with_absent_terms
from haptid.identification.statistics.covariance import curvature
from haptid.identification.statistics.identifiability import felt_sizes, statuses
from haptid.measurement.values.run import Run
from haptid.model.device.stated_parameters import possible_range
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations

TRUE = {"inertia": 0.05, "gravity_cos": 0.0, "gravity_sin": 0.8, "sigma0": 1200.0, "sigma2": 0.03, "Fc": 0.12}
NOISE, RATE = 1e-4, 500
"""Sensor noise [rad] and readings a second [1/s]."""


def swung(
    amplitudes: list[float], frequencies: list[float], *, use: str = "fit", seed: int = 0, ripple: float = 0.0
) -> Run:
    """Swing the pendulum by a sum of cosines [N m, rad/s], with a torque ripple [N m] that the model lacks.

    Its friction has no stiction and no bristle damping.
    """
    t = np.arange(5 * RATE + 1) / RATE
    torque = sum(a * np.cos(w * t) for a, w in zip(amplitudes, frequencies, strict=True))

    def rates(x: np.ndarray, _: float, u: float) -> tuple[float, float, float]:
        q, v, z = x
        pull = u - ripple * np.sin(9.0 * q) - TRUE["gravity_sin"] * np.sin(q) - TRUE["sigma0"] * z - TRUE["sigma2"] * v
        return v, pull / TRUE["inertia"], v - TRUE["sigma0"] * abs(v) / TRUE["Fc"] * z

    states = [np.zeros(3)]
    for u in torque[:-1]:
        states.append(odeint(rates, states[-1], (0.0, 1.0 / RATE), args=(u,), rtol=1e-9, atol=1e-11)[-1])
    noise = NOISE * np.random.default_rng(seed).standard_normal(t.size)
    return Run(
        file=f"swing_{seed}.csv",
        free_joints=(0,),
        t=t,
        u=torque[:, None],
        y=(np.array(states)[:, 0] + noise)[:, None],
        noise=np.array([NOISE]),
        resolution=np.zeros(1),
        posture=np.zeros(0),
        use=use,  # type: ignore[arg-type] # one of the three uses
    )


@cache
def runs() -> tuple[Run, ...]:
    """Three runs to fit and one to judge."""
    return (
        swung([0.35, 0.25, 0.2], [1.1, 3.7, 6.1], seed=1),
        swung([0.5], [2.3], seed=2),
        swung([0.2, 0.15, 0.1], [0.9, 2.1, 5.0], seed=4),
        swung([0.3], [1.7], use="validate", seed=3),
    )


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    equations = guess(joint_equations(0), runs()[:3], given={})
    options = FitOptions(method="gauss_newton", starts=3)
    return fit_runs(JointTest(equations=equations, build=KernelSimulator.of, runs=runs()), options=options)


def test_stiff_coulomb_friction_is_fitted_to_the_noise(fitted: Fitted) -> None:
    fit = fitted.fit
    assert fit.outcome is Outcome.CONVERGED
    assert max(score.over_noise for score in fit.runs) < 1.1
    first = guess(joint_equations(0), runs()[:3], given={})
    assert first.parameter("sigma0").upper < TRUE["sigma0"] < fit.equations.parameter("sigma0").upper
    for id, value in TRUE.items():
        assert abs(fit.values[id] - value) < 1.96 * fit.std[fit.index(id)], id
        assert fit.statuses[id] == "identified", id


def test_spring_and_stiction_that_the_joint_lacks_are_told_as_absent(fitted: Fitted) -> None:
    fit = fitted.fit
    for id in ("Ks", "epos", "Fs", "vs"):
        assert fit.statuses[id] == "unidentifiable", id
    said = " ".join(fit.warnings)
    assert "no spring is seen: |Ks| < " in said
    assert "no stiction is seen: Fs - Fc < " in said
    assert "gravity" not in said


def test_limit_of_a_spring_that_is_not_there_does_not_hang_on_where_its_equilibrium_ended(fitted: Fitted) -> None:
    fit = fitted.fit
    problem = Problem.of(KernelSimulator.of(fit.equations), runs()[:3], FitOptions(method="gauss_newton"))
    place, limits = fit.free.index("Ks"), {}
    for equilibrium in (0.0, 40.0):
        theta = fit.theta.copy()
        theta[fit.index("Ks")], theta[fit.index("epos")] = 0.0, equilibrium
        limits[equilibrium] = float(np.sqrt(curvature(problem, problem.unknowns_at(theta)).covariance[place, place]))
    assert limits[40.0] == pytest.approx(limits[0.0], rel=0.3)


def test_bound_that_the_user_stated_is_not_widened() -> None:
    equations = guess(joint_equations(0), runs()[:3], given={})
    own = JointTest(equations=equations, build=KernelSimulator.of, runs=runs(), stated=("sigma0",)).own
    assert "sigma0" not in own
    assert "sigma1" in own


def test_range_grows_on_the_side_of_the_estimate_and_not_below_zero(fitted: Fitted) -> None:
    fit = fitted.fit
    ends = {"sigma0": fit.equations.parameter("sigma0").upper, "Ks": 0.0}
    ends["gravity_sin"] = fit.equations.parameter("gravity_sin").lower
    edge = fit.but(theta=np.array([ends.get(id, value) for id, value in fit.values.items()]))
    wider = wider_ranges(edge, [q.id for q in fit.equations.parameters], runs())
    assert "Ks" not in wider
    assert wider["sigma0"]["upper"] == pytest.approx(100 * ends["sigma0"])
    assert wider["sigma0"]["lower"] == fit.equations.parameter("sigma0").lower
    assert wider["gravity_sin"]["lower"] < ends["gravity_sin"]
    assert wider["gravity_sin"]["upper"] == fit.equations.parameter("gravity_sin").upper


def at_upper_end(fit: Fit, id: str, upper: float) -> Fit:
    """Put a parameter on the upper end of its range."""
    quantity = fit.equations.parameter(id)
    equations = fit.equations.with_parameters({id: {"upper": upper, "lower": min(quantity.lower, upper / 100)}})
    theta = np.array([upper if name == id else value for name, value in fit.values.items()])
    return fit.but(equations=equations, theta=theta, statuses=dict(fit.statuses) | {id: "at_bound"})


def test_range_does_not_grow_beyond_what_a_result_may_state(fitted: Fitted) -> None:
    most = possible_range("sigma0")[1]
    edge = at_upper_end(fitted.fit, "sigma0", most / 7.0)
    assert wider_ranges(edge, ("sigma0",), runs())["sigma0"]["upper"] == most
    assert wider_ranges(at_upper_end(fitted.fit, "sigma0", most), ("sigma0",), runs()) == {}


def test_stiction_does_not_run_away_from_the_torque_that_moved_the_joint(fitted: Fitted) -> None:
    largest = 0.8 + abs(TRUE["gravity_sin"])  # the cosines add up to 0.8 at t = 0
    grown = wider_ranges(at_upper_end(fitted.fit, "Fs", 0.5), ("Fs",), runs())["Fs"]["upper"]
    assert grown == pytest.approx(3.0 * largest, rel=0.05)
    edge = at_upper_end(fitted.fit, "Fs", 5.0)
    assert wider_ranges(edge, ("Fs",), runs()) == {}
    told = fit_within_own_bounds(lambda *_: edge, edge.equations, runs(), ("Fs",), FitOptions())
    assert told.statuses["Fs"] == "unidentifiable"
    assert "Fs = 5 N m is more than all that acted on the joint, 1.6 N m" in told.warnings[-1]


@pytest.mark.parametrize(("left", "coarse"), [(1.0, False), (1.6, False), (1.6, True)])
def test_wider_range_is_fitted_from_the_optimum_alone_and_by_all_starts_above_the_noise_of_its_own_step(
    fitted: Fitted, left: float, coarse: bool
) -> None:
    found, asked = fitted.fit, []
    stiffness = found.values["sigma0"]
    narrow = found.equations.with_parameters({"sigma0": {"upper": stiffness}})

    def fit_equations(equations: Equations, options: FitOptions) -> Fit:
        asked.append((options.starts, options.gains))
        best = replace(found.basins[0], over_noise=left, starts=tuple(range(min(options.starts, 2))))
        outcome = Outcome.CONVERGED if left < 1.1 else Outcome.ABOVE_NOISE
        cost = left**2 if len(asked) > 1 else 9.0
        return found.but(equations=equations, basins=(best,), outcome=outcome, cost=cost, starts=options.starts)

    options = FitOptions(starts=4)
    made = fit_within_own_bounds(
        fit_equations, narrow, runs(), ("sigma0",), options, needs_finer_step=lambda _: coarse
    )  # fmt: skip
    again = [(3, options.gains)] if left > 1.1 and not coarse else []
    assert asked == [(4, options.gains), (1, options.gains[-1:]), *again]
    assert made.equations.parameter("sigma0").upper > stiffness
    assert (made.starts, len(made.basins[0].starts)) == ((3 if again else 4), 2)


def test_spring_whose_interval_holds_zero_is_not_identified(fitted: Fitted) -> None:
    fit = fitted.fit
    equations = fit.equations.with_parameters({"Ks": {"lower": 0.0, "upper": 100.0, "initial": 2.04}})
    parametrisation = Parametrisation.of(equations)
    theta = fit.theta.copy()
    theta[fit.index("Ks")] = 2.04
    physical = np.array([2.73 if id == "Ks" else fit.std[fit.index(id)] for id in parametrisation.ids])
    std = physical / parametrisation.slope(theta)
    felt = felt_sizes(parametrisation, runs())
    assert statuses(parametrisation, parametrisation.to_coordinates(theta), std, felt)["Ks"] == "unidentifiable"
    covariance = fit.covariance.copy()
    place = fit.free.index("Ks")
    covariance[place, place] = 2.73**2
    told = with_absent_terms(fit.but(equations=equations, theta=theta, covariance=covariance, warnings=()))
    assert "no spring is seen: |Ks| < 7.4 N m/rad with 95 %" in told.warnings


def test_constant_torque_that_a_spring_that_is_not_seen_holds_is_told(fitted: Fitted) -> None:
    """A joint whose friction differs by direction ended with Ks = 8.7e-4 ± 9.1e-4 and nothing said of Ks·epos."""
    fit = fitted.fit
    theta, covariance = fit.theta.copy(), np.zeros_like(fit.covariance)
    stiffness, equilibrium, held, known = 8e-4, -4.0, -3.2e-3, 1e-4
    theta[fit.index("Ks")], theta[fit.index("epos")] = stiffness, equilibrium
    # Along the ridge of equal products the data know nothing; across it they know the product to its own error.
    ridge = np.array([stiffness, -equilibrium])
    across = np.array([equilibrium, stiffness]) * known / np.hypot(stiffness, equilibrium) ** 2
    places = [fit.free.index(id) for id in ("Ks", "epos")]
    covariance[np.ix_(places, places)] = np.outer(ridge, ridge) + np.outer(across, across)
    told = with_absent_terms(fit.but(theta=theta, covariance=covariance, warnings=()))
    (said,) = (text for text in told.warnings if text.startswith("no spring is seen"))
    low, high = held - 1.96 * known, held + 1.96 * known
    assert said.endswith(f"; a constant torque is: Ks·epos = {low:.2g} to {high:.2g} N m with 95 %")
    loose = with_absent_terms(fit.but(theta=theta, covariance=covariance * 1e3, warnings=()))
    (said,) = (text for text in loose.warnings if text.startswith("no spring is seen"))
    assert "constant torque" not in said


@pytest.mark.long
def test_intervals_of_a_model_that_does_not_fit_hold_the_truth() -> None:
    weak = 0.2 * TRUE["Fc"]
    ripple = [
        swung([0.35, 0.25, 0.2], [1.1, 3.7, 6.1], seed=1, ripple=weak),
        swung([0.5], [2.3], seed=2, ripple=weak),
        swung([0.2, 0.15, 0.1], [0.9, 2.1, 5.0], seed=4, ripple=weak),
    ]
    equations = guess(joint_equations(0), ripple, given={})
    options = FitOptions(method="gauss_newton", starts=1)
    fit = fit_runs(JointTest(equations=equations, build=KernelSimulator.of, runs=ripple), options=options).fit
    assert fit.outcome in (Outcome.LONELY, Outcome.ABOVE_NOISE)
    for id in ("inertia", "gravity_sin", "sigma2", "Fc"):
        assert abs(fit.values[id] - TRUE[id]) < 1.96 * fit.std[fit.index(id)], id
    for id in ("Ks", "vs", "sigma0", "Fs"):
        assert fit.statuses[id] != "identified", id


def test_presliding_far_below_what_all_rows_tell_is_not_identified(fitted: Fitted) -> None:
    """A rigid joint had a stiffness of 3.4e6 N m/rad and a damping, both `identified`."""
    fit, mean = fitted.fit, NOISE / np.sqrt(sum(run.t.size for run in runs() if run.use == "fit"))
    place = fit.index("sigma0")
    for length, seen in ((mean, True), (0.05 * mean, False)):
        theta = fit.theta.copy()
        theta[place] = fit.values["Fs"] / length
        given = dict.fromkeys(fit.statuses, "identified")
        told = with_absent_terms(fit.but(theta=theta, statuses=given, warnings=()), resolved=(mean,))
        assert (told.statuses["sigma0"] == "identified") is seen
        assert (told.statuses["sigma1"] == "identified") is seen
        assert any(text.startswith("no presliding is seen: it ends within") for text in told.warnings) is not seen
        # Of a torque's fit no noise of a position is known.
        assert with_absent_terms(fit.but(theta=theta, statuses=given)).statuses["sigma0"] == "identified"


@pytest.mark.parametrize(
    ("largest", "said"), [(1.0, "no stiction is seen"), (1e-6, "stiction is not told by these runs")]
)
def test_stiction_that_could_exceed_any_torque_of_the_runs_is_not_told_as_absent(
    fitted: Fitted, largest: float, said: str
) -> None:
    """Fs - Fc < 18 N was told as absent where the whole force was 19 N."""
    told = with_absent_terms(fitted.fit.but(warnings=()), largest)
    assert any(said in warning for warning in told.warnings)
    assert told.statuses["vs"] == "unidentifiable"
