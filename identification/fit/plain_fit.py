"""The plain model as the result of a configuration: `Compared` and `Run`s in, `Fit` out.

Where the fitted model predicts runs that no fit saw worse than the plain model of seconds does, the plain model is the
result. Its parameters are written in those of the equations, its constant torque among them (`plain_parameters`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haptid.identification.baseline.compared import Compared
from haptid.identification.baseline.delay import with_delayed_torque
from haptid.identification.baseline.plain_parameters import parameter_ids, plain_theta, with_constant_torque
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Basin, Fit, RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.protocol import Simulator, initial_state
from haptid.identification.statistics.identifiability import felt_sizes, known_sizes
from haptid.identification.statistics.score import score_of
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.support.linear_algebra import correlation_of, rms, symmetric_inverse


def plain_fit(simulator: Simulator, found: Fit, compared: Compared, runs: Sequence[Run]) -> Fit:
    """Write the plain model as a fit of the equations.

    Parameters
    ----------
    simulator
        Simulator of the configuration.
    found
        Fit that the plain model replaces.
    compared
        The plain model, and the figures of both.
    runs
        Runs of the configuration.

    Returns
    -------
    Fit
        With the scores of free simulations from the measured start.

    Raises
    ------
    ValueError
        Where there is no plain model.
    """
    baseline = compared.baseline
    if baseline is None:
        msg = "no plain model was fitted"
        raise ValueError(msg)
    equations = simulator.equations
    # The equations have no delay of the torque: the runs have it behind them.
    used = [with_delayed_torque(run, baseline.delay_s) for run in runs if run.use != "excluded"]
    theta = with_constant_torque(plain_theta(baseline, equations, used), baseline, equations, used)
    names = parameter_ids(baseline, equations.friction)
    known = np.isfinite(baseline.estimate.std)
    chosen = [k for k, id in enumerate(baseline.regressor.ids) if known[k] and names.get(id)]
    covariance = baseline.estimate.covariance[np.ix_(chosen, chosen)]
    # Scaled, so that units do not decide which directions count as unknown.
    correlation, std = correlation_of(covariance)
    free = tuple(names[baseline.regressor.ids[k]] for k in chosen)
    x0 = {run.file: initial_state(equations, run) for run in used}
    scores = tuple(_score(simulator, theta, run, x0[run.file]) for run in used)
    over_noise = rms([s.over_noise for s in scores if s.use == "fit"])
    return found.but(
        equations=_widen_to_hold(equations, theta),
        theta=theta,
        free=free,
        covariance=covariance,
        information=symmetric_inverse(correlation) / np.outer(std, std),
        cost=over_noise**2,
        outcome=Outcome.PLAIN,
        basins=(Basin(over_noise=over_noise, starts=(0,), theta=theta, simulations=len(scores)),),
        starts=1,
        x0={run.file: x0[run.file] for run in used if run.use == "fit"},
        statuses=_statuses(equations, theta, dict(zip(free, std, strict=True)), used),
        combinations=(),
        runs=scores,
        # Those of the fit are on friction that the plain model does not have.
        warnings=(),
        observer_gain=0.0,
        profiles={},
    )


def _widen_to_hold(equations: Equations, theta: Array) -> Equations:
    """Widen the ranges that the plain model leaves: the end of its soft spring lies far outside the travel."""
    changes: dict[str, dict[str, object]] = {}
    for quantity, value in zip(equations.parameters, theta.tolist(), strict=True):
        if not quantity.lower <= value <= quantity.upper:
            changes[quantity.id] = {"lower": min(quantity.lower, value), "upper": max(quantity.upper, value)}
    return equations.with_parameters(changes)


def _statuses(equations: Equations, theta: Array, std: Mapping[str, float], runs: Sequence[Run]) -> dict[str, str]:
    """Judge the plain model's parameters by the rule of every fit; what it does not have is ``fixed``."""
    parametrisation = Parametrisation.of(equations)
    fitted = [run for run in runs if run.use == "fit"]
    scaled = known_sizes(parametrisation, parametrisation.to_coordinates(theta), felt_sizes(parametrisation, fitted))
    largest = dict(zip(parametrisation.ids, scaled * parametrisation.slope(theta), strict=True))
    result = {q.id: "fixed" for q in equations.parameters}
    for id, deviation in std.items():
        result[id] = "identified" if deviation <= largest.get(id, np.inf) else "unidentifiable"
    return result


def _score(simulator: Simulator, theta: Array, run: Run, x0: Array) -> RunScore:
    y = simulator.simulate(theta, run, x0=x0).y[:, : run.y.shape[1]]
    return score_of(run, (run.y - y)[run.scored], x0)
