"""The plain model as the result of a configuration: `Compared` and `Run`s in, `Fit` out.

Where the fitted model predicts runs that no fit saw worse than the plain model of seconds does, the plain model is the
result. Its parameters are written in those of the equations: no stiction, stiff presliding, no spring; a constant
torque is the torque of a spring so soft that only Ks·epos matters, or the constant force of a slide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haptid.identification.baseline.baseline import Baseline
from haptid.identification.baseline.compared import Compared, plain_theta
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Basin, Fit, RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.simulators.protocol import Simulator, initial_state
from haptid.identification.statistics.identifiability import felt_sizes, known_sizes
from haptid.identification.statistics.score import score_of
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.friction.registry import law_named

SOFT_SPRING_OF_TORQUE = 1e-4
"""Torque of the spring that carries a constant torque, over the travel, as a share of the largest torque [1]."""


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
    used = [run for run in runs if run.use != "excluded"]
    theta = _with_offset(plain_theta(baseline, equations, used), baseline, simulator, used)
    names = parameter_ids(baseline, equations.friction)
    known = np.isfinite(baseline.estimate.std)
    chosen = [k for k, id in enumerate(baseline.regressor.ids) if known[k] and names.get(id)]
    covariance = baseline.estimate.covariance[np.ix_(chosen, chosen)]
    free = tuple(names[baseline.regressor.ids[k]] for k in chosen)
    x0 = {run.file: initial_state(equations, run) for run in used}
    scores = tuple(_score(simulator, theta, run, x0[run.file]) for run in used)
    over_noise = float(np.sqrt(np.mean([s.over_noise**2 for s in scores if s.use == "fit"])))
    return found.but(
        equations=equations,
        theta=theta,
        free=free,
        covariance=covariance,
        information=np.linalg.pinv(covariance),
        cost=over_noise**2,
        outcome=Outcome.PLAIN,
        basins=(Basin(over_noise=over_noise, starts=(0,), theta=theta, simulations=len(scores)),),
        starts=1,
        x0={run.file: x0[run.file] for run in used if run.use == "fit"},
        statuses=_statuses(equations, theta, dict(zip(free, np.sqrt(np.diag(covariance)), strict=True)), used),
        combinations=(),
        runs=scores,
        observer_gain=0.0,
        profiles={},
    )


def _statuses(equations: Equations, theta: Array, std: Mapping[str, float], runs: Sequence[Run]) -> dict[str, str]:
    """Judge the plain model's parameters by the rule of every fit; what it does not have is ``fixed``."""
    parametrisation = Parametrisation.of(equations)
    fitted = [run for run in runs if run.use == "fit"]
    scaled = known_sizes(parametrisation, parametrisation.scaled(theta), felt_sizes(parametrisation, fitted))
    largest = dict(zip(parametrisation.ids, scaled * parametrisation.slope(theta), strict=True))
    result = {q.id: "fixed" for q in equations.parameters}
    for id, deviation in std.items():
        result[id] = "identified" if deviation <= largest.get(id, np.inf) else "unidentifiable"
    return result


def _score(simulator: Simulator, theta: Array, run: Run, x0: Array) -> RunScore:
    y = simulator.simulate(theta, run, x0=x0).y[:, : run.y.shape[1]]
    return score_of(run, (run.y - y)[run.scored], x0)


def parameter_ids(baseline: Baseline, friction: Sequence[str]) -> dict[str, str]:
    """Name the parameters of the plain model by the ids of the equations.

    Parameters
    ----------
    baseline
        Plain model.
    friction
        Names of the friction laws of the free joints.

    Returns
    -------
    dict
        Id of the equations by id of the plain model; a constant torque has none of its own.
    """
    regressor = baseline.regressor
    names = {id: id for id in regressor.ids[: regressor.n_rigid]}
    for k, j in enumerate(regressor.joints):
        tail = "" if len(regressor.joints) == 1 else f"_{j}"
        roles = law_named(friction[k]).roles
        names |= {f"Fv{tail}": f"{roles.viscous}{tail}", f"Fc{tail}": f"{roles.coulomb}{tail}"}
    return names


def _with_offset(theta: Array, baseline: Baseline, simulator: Simulator, runs: Sequence[Run]) -> Array:
    """Put the constant torque of every joint into the parameters."""
    ids = [q.id for q in simulator.equations.parameters]
    moved = theta.copy()
    for k, j in enumerate(baseline.regressor.joints):
        tail = "" if len(baseline.regressor.joints) == 1 else f"_{j}"
        offset = baseline.of_joint("offset", k)
        if runs[0].prismatic[k] and f"gravity_cos{tail}" in ids:
            moved[ids.index(f"gravity_cos{tail}")] += offset
        elif f"Ks{tail}" in ids and offset:
            travel = max(float(np.ptp(run.y[:, k])) for run in runs)
            stiffness = SOFT_SPRING_OF_TORQUE * max(float(np.max(np.abs(run.u[:, k]))) for run in runs) / travel
            moved[ids.index(f"Ks{tail}")] = stiffness
            # Ks·(q − epos) is −Ks·epos at every position of the joint, to the share above.
            moved[ids.index(f"epos{tail}")] = -offset / stiffness
    return moved
