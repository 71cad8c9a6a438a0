"""Scan the catalogue against a residual torque: `TorqueFit` and `Effect`s in, `Promise`s out.

The signature of every effect is projected off what the fitted model can move. Effects are sorted by the share of the
residual's energy that their best shape explains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.detect.signatures import shapes
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.discrepancy.torque.study import TorqueStudy
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.support.linear_algebra import orthonormal_basis
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class Promise:
    """The best shape of one catalogue effect.

    Parameters
    ----------
    effect
        Effect in SI units.
    share
        Share of the residual's energy that it explains to first order.
    start
        Start values of its parameters by id for a refit.
    columns
        Number of signatures that were simulated.
    """

    effect: Effect
    share: float
    start: dict[str, float]
    columns: int


def promises(
    study: TorqueStudy,
    current: TorqueFit,
    catalogue: Mapping[str, Effect],
    count: Callable[[int], None] = lambda _: None,
) -> list[Promise]:
    """Return every effect with its best shape.

    Parameters
    ----------
    study
        Study with its fitted rows.
    current
        Fitted model.
    catalogue
        Catalogue effects by key, in SI units.
    count
        Told how many effects are scanned.

    Returns
    -------
    list of Promise
        Promises, largest share of the residual first.
    """
    Q, r = orthonormal_basis(current.jacobian), current.weighted
    r = r - Q @ (Q.T @ r)
    found = map_threads(
        lambda e: _best(study, current, e, Q, r), catalogue.values(), threads=study.threads, count=count
    )
    return sorted((p for p in found if p is not None), key=lambda p: -p.share)


def _signatures(
    study: TorqueStudy, current: TorqueFit, effect: Effect, grid: list[tuple[dict[str, float], ...]]
) -> Array:
    """Return how each column of the grid would change the fitted rows' weighted torque, shape (n_rows, n_columns)."""
    simulator = study.simulator((*current.effects, effect), many=True)
    neutral = {x.id: x.initial for x in effect.parameters} | effect.neutral
    sets = [neutral, *(neutral | values for point in grid for values in point)]
    theta = np.array([[(current.values | s)[q.id] for q in simulator.equations.parameters] for s in sets])
    start = np.array([s.start for s in simulator.equations.states])
    stacked = []
    for run, rows, weight in zip(study.runs, study.fitted_rows, study.weights, strict=True):
        y = simulator.simulate_many(theta, run, x0=start)[:, :, 0].T
        stacked.append((weight[:, None] * (y[:, 1:] - y[:, :1]))[rows])
    D = np.concatenate(stacked)
    # A zero column explains nothing, so a diverged shape is never the best one.
    D[:, ~np.isfinite(D).all(axis=0)] = 0.0
    return D


def _best(study: TorqueStudy, current: TorqueFit, effect: Effect, Q: Array, r: Array) -> Promise | None:
    grid = shapes(effect)
    D = _signatures(study, current, effect, grid)
    D -= Q @ (Q.T @ D)
    best: Promise | None = None
    at = 0
    for point in grid:
        block = D[:, at : at + len(point)]
        at += len(point)
        factor = np.asarray(np.linalg.lstsq(block, r, rcond=1e-8)[0], dtype=np.float64)
        share = 1.0 - float(np.sum((r - block @ factor) ** 2) / np.sum(r**2))
        if best is None or share > best.share:
            best = Promise(effect=effect, share=share, start=_start(effect, point, factor), columns=D.shape[1])
    return best


def _start(effect: Effect, point: tuple[dict[str, float], ...], factor: Array) -> dict[str, float]:
    """Return the parameters of the shape with amplitudes at their linear estimates, inside the bounds."""
    values = {x.id: x.initial for x in effect.parameters}
    amplitudes = [x.id for x in effect.parameters[: effect.amplitudes]]
    for column, f in zip(point, factor, strict=True):
        values |= {id: v * (f if id in amplitudes else 1.0) for id, v in column.items() if v != 0.0}
    limits = {x.id: (x.lower, x.upper) for x in effect.parameters}
    return {id: float(np.clip(v, *limits[id])) for id, v in values.items()}
