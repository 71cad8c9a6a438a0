"""Estimate the noise model from the residuals of a fit: `Study` and `Solution` in, `Noise` out.

1. Estimate the ARMA(1,1) correlation from the part of the residuals that does not repeat with the drive.
2. Under white noise, find the joint whose cycle amplitudes scatter most clearly, then the next, by REML.
3. Estimate the correlation again from the residuals without the scatter.
4. Weigh every scatter again beside the others under that correlation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from haptid.discrepancy.fit.scatter import cycle_columns, cycles_of, most_probable
from haptid.discrepancy.fit.solution import SCATTER, Solution
from haptid.discrepancy.fit.tangent_space import movable
from haptid.discrepancy.study.channels import channels
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.noise.arma import estimate_arma
from haptid.noise.correlation import Arma, Noise, Path, Scatter, Whitener
from haptid.noise.reml import best_scatter
from haptid.support.linear_algebra import orthonormal_basis
from haptid.support.processes.threads import map_threads

PATHS: tuple[Path, ...] = ("reading", "torque")
"""Paths on which amplitudes can scatter, in the order in which they are tried."""


def estimate(study: Study, solution: Solution, paths: Sequence[Path] = PATHS) -> Noise:
    """Estimate correlation and scatter of the noise from the unwhitened residuals of a fit.

    Parameters
    ----------
    study
        Study with the fitted runs; scatter is looked for where its catalogue holds `SCATTER`.
    solution
        Fitted model.
    paths
        Paths on which amplitudes may scatter.

    Returns
    -------
    Noise
        Noise model with at most one scatter of each joint.
    """
    arma = _arma(study, solution.raw.rows)
    if SCATTER not in study.catalogue:
        return Noise(arma=arma)
    found = _scattering(study, solution, paths)
    if not found:
        return Noise(arma=arma)
    # Scatter correlates all rows of a cycle, so the correlation of the sensor noise is known only without it.
    arma = _arma(study, remove_scatter(study, solution, found))
    # One scatter under white noise was weighed under these very conditions already.
    if len(found) > 1 or not arma.white:
        found = _again(study, solution, found, arma)
    return Noise(arma=arma, scatters=found)


def _arma(study: Study, rows: Sequence[Array]) -> Arma:
    """Estimate the ARMA model from residuals over the sensor's std, those of a run (n_t, n_joints)."""
    each = channels(study.fitted)
    return estimate_arma([rows[c.number][:, c.column] for c in each], tuple(c.run for c in each))


def _scattering(study: Study, solution: Solution, paths: Sequence[Path]) -> tuple[Scatter, ...]:
    """Find the scatters under white noise: one joint after another, the most probable scatter first."""
    found: list[Scatter] = []
    free = list(range(len(study.fitted[0].free_joints)))
    while free:
        whiteners = _whiteners(study, solution, Arma(), found)
        tried = [scatter_along(study, solution, path, k, whiteners) for k in free for path in paths]
        best = min(tried, key=lambda one: one.deviance)
        if best.gain < THRESHOLDS.fit.least_twice_gain_of_scatter:
            break
        found.append(best.scatter)
        free.remove(best.scatter.column)
    return tuple(sorted(found, key=lambda one: one.column))


def _again(study: Study, solution: Solution, found: Sequence[Scatter], arma: Arma) -> tuple[Scatter, ...]:
    """Weigh every scatter again beside the others under ``arma``; return those that still gain enough."""
    kept = list(found)
    for one in found:
        others = [other for other in kept if other.column != one.column]
        again = scatter_along(study, solution, one.path, one.column, _whiteners(study, solution, arma, others))
        if again.gain >= THRESHOLDS.fit.least_twice_gain_of_scatter:
            others.append(again.scatter)
        kept = sorted(others, key=lambda s: s.column)
    return tuple(kept)


def _columns(study: Study, solution: Solution, scatter: Scatter) -> list[Array]:
    """Return M of every fitted run at the optimum, for the cycles of the torque that was sent."""
    simulator = study.simulator(solution.effects)

    def one(run: Run, sent: Run, x0: Array) -> Array:
        return cycle_columns(simulator, run, scatter, solution.theta, x0, cycles=cycles_of(sent, scatter))

    # The problem's runs may carry torques scaled by the scatter; the cycles are those of the torques as they were sent.
    return map_threads(one, solution.problem.runs, study.fitted, solution.x0, threads=study.threads)


def _scatter_columns(study: Study, solution: Solution, scatters: Sequence[Scatter]) -> list[Array]:
    """S = s·M of every fitted run, the columns of all ``scatters`` side by side: (n_t, n_joints, K)."""
    each = [[scatter.size * M for M in _columns(study, solution, scatter)] for scatter in scatters]
    return [np.concatenate(of_run, axis=2) for of_run in zip(*each, strict=True)]


def _whiteners(study: Study, solution: Solution, arma: Arma, scatters: Sequence[Scatter]) -> list[Whitener]:
    """Whiteners of the fitted runs under an ARMA model and ``scatters``."""
    if not scatters:
        return [Whitener.of(arma) for _ in study.fitted]
    return [Whitener.of(arma, S) for S in _scatter_columns(study, solution, scatters)]


def remove_scatter(study: Study, solution: Solution, scatters: Sequence[Scatter]) -> list[Array]:
    """Subtract the best linear prediction of the cycles' amplitudes from the residuals.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    scatters
        Scatters to remove.

    Returns
    -------
    list of ndarray
        Residuals over the sensor's standard deviation, one array (n_t, n_joints) for each run.
    """
    left = []
    for r, S in zip(solution.raw.rows, _scatter_columns(study, solution, scatters), strict=True):
        left.append(r - S @ most_probable(S.reshape(r.size, -1), r.ravel()))
    return left


@dataclass(frozen=True, slots=True, kw_only=True)
class Weighed:
    """A scatter with its evidence.

    Parameters
    ----------
    scatter
        Scatter of largest restricted likelihood.
    gain
        Twice its gain in restricted log-likelihood over no scatter.
    deviance
        −2 ln L up to a constant that all compared scatters share.
    """

    scatter: Scatter
    gain: float
    deviance: float


def scatter_along(study: Study, solution: Solution, path: Path, column: int, whiteners: Sequence[Whitener]) -> Weighed:
    """Estimate the scatter of one joint on one path by REML.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model.
    path
        Whether the scatter acts on the torque or on the reading.
    column
        Index of the joint among the free joints.
    whiteners
        Whiteners of the fitted runs under the rest of the noise model.

    Returns
    -------
    Weighed
        Scatter with its evidence; on the reading its centre is optimised where the gain makes this worthwhile.

    Notes
    -----
    Only differences between cycles of one run count. An amplitude that all cycles of a run share, and one that drifts
    over them, is projected out with the parameters of the model: a deterministic effect produces it too, and a motion
    that settles.
    """
    if path == "torque":
        scatter = Scatter(path=path, column=column)
        return _estimate_by_reml(solution, _columns(study, solution, scatter), whiteners, scatter)
    readings = [run.y[:, column] for run in study.fitted]
    middle = float(np.mean([y.mean() for y in readings]))
    reach = THRESHOLDS.fit.centre_reach_over_range * max(float(np.ptp(y)) for y in readings)
    # M is linear in the centre, so one simulation serves all centres.
    columns = _columns(study, solution, Scatter(path=path, centre=middle, column=column))
    masks = [M != 0 for M in columns]
    std = [run.sensor_std[column] for run in study.fitted]

    def about(centre: float) -> Weighed:
        moved = [M - (centre - middle) * m / s for M, m, s in zip(columns, masks, std, strict=True)]
        return _estimate_by_reml(solution, moved, whiteners, Scatter(path=path, centre=centre, column=column))

    first = about(middle)
    if first.gain < THRESHOLDS.fit.least_twice_gain_for_centre:
        return first
    best = minimize_scalar(lambda c: about(c).deviance, bounds=(middle - reach, middle + reach), method="bounded",
                           options={"xatol": 1e-4 * reach, "maxiter": 30})  # fmt: skip
    return about(float(best.x))


def _estimate_by_reml(
    solution: Solution, columns: Sequence[Array], whiteners: Sequence[Whitener], scatter: Scatter
) -> Weighed:
    """Estimate the scatter of largest restricted likelihood; parameters and drifts of amplitudes are projected out."""
    moving = movable(solution)
    runs = zip(whiteners, solution.raw.rows, solution.raw.jacobians or (), columns, strict=True)
    parts = [_apart(w(row).ravel(), _flat(w(B))[:, moving], _flat(w(M))) for w, row, B, M in runs]
    r, J, M = zip(*parts, strict=True)
    Q = np.split(orthonormal_basis(np.concatenate(J)), np.cumsum([part.size for part in r])[:-1])
    along = sum(q.T @ part for q, part in zip(Q, r, strict=True))
    left = [part - q @ along for q, part in zip(Q, r, strict=True)]
    size, gain = best_scatter(left, Q, M)
    deviance = sum(float(part @ part) for part in left) - gain
    return Weighed(scatter=scatter.but(size=size), gain=gain, deviance=deviance)


def _apart(r: Array, J: Array, M: Array) -> tuple[Array, Array, Array]:
    """Project the amplitude that a run's cycles share, and its drift over them, off residual, Jacobian and columns."""
    if not np.isfinite(M).all():
        return r, J, M
    count = np.arange(M.shape[1])
    Q = orthonormal_basis(M @ np.column_stack((np.ones_like(count), count - count.mean())))
    return r - Q @ (Q.T @ r), J - Q @ (Q.T @ J), M - Q @ (Q.T @ M)


def _flat(x: Array) -> Array:
    """Rows of all joints one after the other, (n_t·n_joints, k)."""
    return x.reshape(-1, x.shape[-1])
