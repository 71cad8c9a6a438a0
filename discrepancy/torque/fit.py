"""Fit a joint with effects to the torque that a position controller recorded: `TorqueStudy` in, `TorqueFit` out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.fit.solution import start_vector
from haptid.discrepancy.fit.whitened import OPTIONS
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.first_states import first_states
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.identification.baseline.least_squares import correlation_length
from haptid.identification.fit.stribeck_restraint import pays_for_release, release_stribeck, restrained_ids
from haptid.identification.fit.weight_near_reversals import refit_until_weight_stays, weight_near_reversals
from haptid.identification.optimise.levenberg_marquardt import Descent, SumOfSquares, minimise
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.inverse_dynamics import noise_along
from haptid.identification.statistics.identifiability import on_bound
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.model.friction.registry import law_named
from haptid.support.errors import NumericalError
from haptid.support.linear_algebra import rms, scaled_covariance
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueFit:
    """Optimum of a model on the fitted rows.

    Parameters
    ----------
    effects
        Effects in the equations, in SI units.
    problem
        The least-squares problem.
    x
        Optimum in scaled unknowns, shape (n_x,).
    residual
        Measured minus modelled torque of every run [N m], shape (n_t,).
    jacobian
        Derivative of the weighted residual over the noise with respect to x, fitted rows only, shape (n_rows, n_x).
    study
        Study that tells fitted from held-out rows.
    calls
        Number of simulations of all runs.
    """

    effects: tuple[Effect, ...]
    problem: Problem
    x: Array
    residual: tuple[Array, ...]
    jacobian: Array
    study: TorqueStudy
    calls: int

    @property
    def theta(self) -> Array:
        """Parameters, shape (n_p,)."""
        return self.problem.theta(self.x)

    @property
    def values(self) -> dict[str, float]:
        """Parameters by id."""
        return {q.id: float(p) for q, p in zip(self.problem.simulator.equations.parameters, self.theta, strict=True)}

    @property
    def fitted(self) -> Array:
        """Residual torque of all fitted rows [N m]."""
        return np.concatenate([r[rows] for r, rows in zip(self.residual, self.study.fitted_rows, strict=True)])

    @property
    def weighted(self) -> Array:
        """Residual torque of all fitted rows, each times its weight [N m]."""
        rows = zip(self.residual, self.study.weights, self.study.fitted_rows, strict=True)
        return np.concatenate([(weight * r)[fitted] for r, weight, fitted in rows])

    @property
    def unseen(self) -> Array:
        """Residual torque of all held-out rows [N m]."""
        return np.concatenate([r[rows] for r, rows in zip(self.residual, self.study.unseen_rows, strict=True)])

    @property
    def fitted_away(self) -> Array:
        """Residual torque of the fitted rows that name effects [N m], those away from reversals."""
        return self.fitted[self.study.names(self.study.fitted_rows)]

    @property
    def unseen_away(self) -> Array:
        """Residual torque of the held-out rows that name effects [N m], those away from reversals."""
        return self.unseen[self.study.names(self.study.unseen_rows)]

    @property
    def left(self) -> float:
        """RMS of the rows that name effects [N m]: the larger one of fitted and held-out rows.

        One run that holds what the others lack raises it.
        """
        return max(rms(self.fitted_away), rms(self.unseen_away))

    @property
    def noise(self) -> float:
        """Noise of the torque along the measured motion [N m], √(σ_τ² + (M/Kp·σ_a)²), RMS over the runs.

        The inertia is this model's: that of a model in which much is missing may be far off.
        """
        inertia = self.values["inertia"] / self.values["Kp"]
        return rms([noise_along(run, inertia) for run in self.study.runs])

    @property
    def leaves_noise(self) -> bool:
        """Whether the model leaves no more than noise, so that nothing is left to name."""
        return self.left <= THRESHOLDS.finding.largest_rms_over_torque_noise * self.noise

    def compute_missed(self, run: Run) -> Array:
        """Return measured minus modelled torque of a run of no fit [N m], shape (n_t,).

        Parameters
        ----------
        run
            Run with the position as ``u`` and the torque as ``y``.

        Returns
        -------
        ndarray, shape (n_t,)
            Residual torque [N m].
        """
        simulator = self.problem.simulator
        x0 = first_states(simulator, self.theta, run)
        return np.asarray(run.y[:, 0] - simulator.simulate(self.theta, run, x0=x0).y[:, 0])

    @property
    def correlation_time(self) -> float:
        """Autocorrelation time of the weighted residual [rows], 1 + 2·Σρₖ up to the first ρₖ < 0; the longest run's."""
        rows = zip(self.residual, self.study.weights, self.study.moving, strict=True)
        return max(correlation_length((weight * r)[moving]) for r, weight, moving in rows)

    @property
    def covariance(self) -> Array:
        """Covariance of the fitted parameters, shape (n_free, n_free)."""
        n = self.problem.n_parameters
        J = self.jacobian[:, :n] @ np.diag(1.0 / self.problem.parametrisation.slope(self.theta))
        inverse, size = scaled_covariance(J)
        # The residual under position control is larger than the noise and correlated, so the errors grow by both.
        scale = rms(self.weighted) / float(self.study.runs[0].sensor_std[0]) * np.sqrt(self.correlation_time)
        # What moves no torque gets no error from it: divided by an infinite size it stays where it is in draws.
        moved = np.where(size > np.sqrt(np.finfo(float).tiny), size, np.inf)
        return np.asarray(scale**2 * inverse / np.outer(moved, moved))

    @property
    def std(self) -> dict[str, float]:
        """Standard errors of parameters by id; 0 where fixed."""
        errors = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        found = {q.id: 0.0 for q in self.problem.simulator.equations.parameters}
        return found | dict(zip(self.problem.parametrisation.ids, errors.tolist(), strict=True))


def descend_from_all(
    problem: Problem,
    thetas: Sequence[Array],
    *,
    threads: int,
    relative: float = THRESHOLDS.torque.least_decrease_of_cost,
) -> list[Descent]:
    """Follow every start to its minimum.

    Parameters
    ----------
    problem
        Problem to minimise.
    thetas
        Parameters of the starts, shape (n_p,) each.
    threads
        Number of threads; the results do not depend on it.
    relative
        Predicted decrease of the cost over the cost below which a descent stops [1].

    Returns
    -------
    list of Descent
        In the order of the starts.
    """
    return map_threads(
        lambda theta: minimise(
            SumOfSquares.of(problem),
            problem.unknowns_at(theta),
            iterations=THRESHOLDS.torque.most_simulations_of_start,
            relative=relative,
        ),
        thetas,
        threads=threads,
    )


def fit_nominal(study: TorqueStudy, *, starts: int, seed: int) -> TorqueFit:
    """Fit the nominal model, with presliding as stiff as the torque asks for.

    1. Fit all rows that count alike.
    2. Weight the rows near reversals by the RMS residual of the others over theirs, and fit again. There the filter
       decides when friction turns: a joint that sticks for a few rows leaves as much as its friction, in 1 or 2 % of
       the rows, and a fit that counts them alike bends its friction to them.
    3. Widen the range of the stiffness while the fit ends at its upper end.
    4. Drop the restraint of the Stribeck curve where that pays (`identification.fit.stribeck_restraint`).
    5. Repeat steps 2 to 4 until nothing changes (`settle`).

    The largest stiffness in presliding is a guess from the travel. A joint whose friction turns within less than that
    would show, at every reversal, a discrepancy that is none of the joint's.

    Parameters
    ----------
    study
        Study with its fitted rows.
    starts
        Number of starts, the further ones by a Sobol sequence.
    seed
        Seed of the starts.

    Returns
    -------
    TorqueFit
        Optimum of least cost; its study has the weight of rows near reversals, and the range of the stiffness that it
        was found in.

    Raises
    ------
    NumericalError
        If no start gives a finite torque.
    """
    found = fit_model(study, starts=starts, seed=seed)
    study = replace(study, weight_of_turning=_weight_of_turning(found))
    if study.weight_of_turning < 1.0:
        found = fit_model(study, start=found.values, starts=starts, seed=seed)
    return settle(found)


def settle(found: TorqueFit) -> TorqueFit:
    """Repeat a fit with the weight, the range of the stiffness and the restraint that it asks for itself.

    What a model without an effect asks for is not what the model with it does: a wave that nobody knows makes rows away
    from reversals weigh no more than those near them, and holds the Stribeck curve restrained.

    Parameters
    ----------
    found
        Fit of a model with effects or without.

    Returns
    -------
    TorqueFit
        Its study is another one where anything changed: models that are compared with it are fitted to that.
    """
    for _ in range(IDENTIFICATION.most_reweighings):
        before = found.study
        found = _released(_reweighed(_with_wide_stiffness(found)))
        # One may lead to the next: rows near reversals that weigh less ask for a stiffer friction, and that to sharper.
        if found.study is before:
            break
    return found


def _reweighed(found: TorqueFit) -> TorqueFit:
    """Return the fit with the weight of rows near reversals that it asks for itself."""

    def refit(found: TorqueFit, weight: float) -> TorqueFit:
        return fit_model(replace(found.study, weight_of_turning=weight), found.effects, found.values)

    weight = found.study.weight_of_turning
    return refit_until_weight_stays(found, weight, asked_by=_weight_of_turning, refit=refit)[0]


def _with_wide_stiffness(found: TorqueFit) -> TorqueFit:
    """Return the fit in a range of the stiffness that it does not end at, as far as that lowers the cost."""
    study = found.study
    stiffness = law_named(study.base.friction[0]).roles.stiffness
    for _ in range(IDENTIFICATION.most_widenings_of_bounds):
        if stiffness in study.stated or not _is_at_upper_bound(found, stiffness):
            return found
        wider = IDENTIFICATION.bounds_over_guess * study.base.parameter(stiffness).upper
        study = replace(study, base=study.base.with_parameters({stiffness: {"upper": wider}}))
        again = fit_model(study, found.effects, found.values)
        # The energy is what is minimised, but for priors that a stiffness has none of.
        if rms(again.weighted) >= (1.0 - THRESHOLDS.torque.least_decrease_of_cost) * rms(found.weighted):
            return found
        found = again
    return found


def _released(found: TorqueFit) -> TorqueFit:
    """Return the fit without the restraint of the Stribeck curve where that pays (`stribeck_restraint`)."""
    held = restrained_ids(found.study.base)
    if not held:
        return found
    base = release_stribeck(found.study.base)
    begin = {id: max(found.values[id], base.parameter(id).initial) for id in held}
    freed = fit_model(replace(found.study, base=base), found.effects, found.values | begin)
    before, after = (float(np.mean((one.fitted_away / one.noise) ** 2)) for one in (found, freed))
    rows = freed.fitted_away.size / max(freed.correlation_time, 1.0)
    return freed if pays_for_release(before, after, rows, len(held), leaves_noise=freed.leaves_noise) else found


def _weight_of_turning(found: TorqueFit) -> float:
    """Return the weight of rows near reversals that a fit asks for."""
    away = found.study.names(found.study.fitted_rows)
    return weight_near_reversals(found.fitted[away], found.fitted[~away])


def _is_at_upper_bound(found: TorqueFit, id: str) -> bool:
    """Whether a parameter was fitted and ended at the upper end of its range."""
    parametrisation = found.problem.parametrisation
    if id not in parametrisation.ids:
        return False
    at = parametrisation.ids.index(id)
    s = parametrisation.to_coordinates(found.theta)
    return bool(on_bound(parametrisation, s)[at]) and found.values[id] > found.study.base.parameter(id).initial


def fit_model(
    study: TorqueStudy, effects: Sequence[Effect] = (), start: Mapping[str, float] | None = None, *,
    starts: int = 1, seed: int = 0, relative: float = THRESHOLDS.torque.least_decrease_of_cost,
) -> TorqueFit:  # fmt: skip
    """Fit nominal model and effects together to the torque.

    Parameters
    ----------
    study
        Study with its fitted rows.
    effects
        Effects in SI units.
    start
        Start values of parameters by id; first guesses where None.
    starts
        Number of starts, the further ones by a Sobol sequence.
    seed
        Seed of the starts.
    relative
        Predicted decrease of the cost over the cost below which a descent stops [1].

    Returns
    -------
    TorqueFit
        Optimum of least cost.

    Raises
    ------
    NumericalError
        If no start gives a finite torque.
    """
    simulator = study.simulator(effects)
    # Held-out rows have weight 0, and so have rows at rest.
    roots = tuple(rows * weight for rows, weight in zip(study.fitted_rows, study.weights, strict=True))
    problem = replace(Problem.of(simulator, study.runs, OPTIONS), roots=roots)
    first = start_vector(simulator.equations, start or {})
    thetas = sobol_starts(problem.parametrisation, first, starts, seed)
    found = descend_from_all(problem, thetas, threads=study.threads if starts > 1 else 1, relative=relative)
    best = min(found, key=lambda d: d.cost)
    if not np.isfinite(best.cost):
        msg = f"joint {study.joint}: no start gave a finite torque; check units, bounds and first guesses"
        raise NumericalError(msg)
    theta = problem.theta(best.x)
    x0 = [
        x if rows.any() else first_states(simulator, theta, run)
        for run, x, rows in zip(study.runs, problem.x0(best.x), study.fitted_rows, strict=True)
    ]
    left = [run.y[:, 0] - simulator.simulate(theta, run, x0=x).y[:, 0] for run, x in zip(study.runs, x0, strict=True)]
    jacobian = problem.blocks(best.x).jacobian
    fitted = np.concatenate(study.fitted_rows)
    return TorqueFit(
        effects=tuple(effects), problem=problem, x=best.x, residual=tuple(left),
        jacobian=jacobian[: fitted.size][fitted], study=study, calls=sum(d.calls for d in found),
    )  # fmt: skip
