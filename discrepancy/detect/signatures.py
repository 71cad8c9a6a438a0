"""First-order signatures: how each entry of the catalogue would move the readings, over its grid of shapes.

Column j of an entry is (y(θ, s·a) − y(θ, 0))/(s·σ) at the base's optimum, a its typical amplitude and s a share of it,
simulated for all shapes side by side. Parameters whose grid holds amplitudes (a dead band, a time constant) are taken
at those, s = 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.study.simulators import TwoStep
from haptid.discrepancy.study.study import Study
from haptid.identification.simulators.protocol import initial_state
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect

SHARE = 0.03
"""s: at the whole amplitude, the curvature of what the base nearly takes up passes for what it does not."""
BLOWN = 1e6
"""A column larger than this many standard deviations counts as a simulation that blew up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One shape of one entry: the values that the effect's parameters take, column by column.

    Parameters
    ----------
    key
        Entry of the catalogue.
    values
        Parameters per column.
    columns
        Where its columns lie in the matrix of signatures.
    """

    key: str
    values: tuple[dict[str, float], ...]
    columns: slice


@dataclass(frozen=True, slots=True, kw_only=True)
class Signatures:
    """Signatures of the whole catalogue at one optimum.

    Parameters
    ----------
    points
        Shapes, in the order of the columns.
    raw
        Signatures of all fitted runs over the sensor's std, one run after the other, shape (n_rows, n_columns).
    simulations
        Runs simulated.
    """

    points: tuple[Point, ...]
    raw: Array
    simulations: int

    def whitened(self, study: Study, solution: Solution) -> Array:
        """Whiten as the residuals of ``solution`` are; shape (n_rows, n_columns)."""
        edges = np.cumsum([0, *(run.y.size for run in study.fitted)])
        D = np.empty_like(self.raw)
        for w, run, a, b in zip(solution.problem.whiteners, study.fitted, edges[:-1], edges[1:], strict=True):
            readings = self.raw[a:b].reshape(*run.y.shape, -1)
            D[a:b] = w(_scored(readings, run.score_from)).reshape(b - a, -1)
        return D


def shapes(effect: Effect) -> list[tuple[dict[str, float], ...]]:
    """Return for every shape of an SI-scaled effect the parameter values of its columns."""
    initial = {x.id: x.initial for x in effect.parameters}
    amplitudes = [x.id for x in effect.parameters[: effect.amplitudes]]
    found: list[tuple[dict[str, float], ...]] = []
    for combination in itertools.product(*(grid for _, grid in effect.shapes)):
        chosen = initial | {id: value for (id, _), value in zip(effect.shapes, combination, strict=True)}
        if _has_grid_of_amplitudes(effect):
            found.append((chosen,))
        else:
            found.append(tuple(chosen | {a: 0.0 for a in amplitudes if a != alone} for alone in amplitudes))
    return found


def _has_grid_of_amplitudes(effect: Effect) -> bool:
    """Whether the grid of an effect holds amplitudes."""
    return bool({id for id, _ in effect.shapes} & {x.id for x in effect.parameters[: effect.amplitudes]})


def entry_columns(study: Study, solution: Solution, effect: Effect) -> tuple[list[tuple[dict[str, float], ...]], Array]:
    """Return the shapes of one entry and its raw columns over σ (n_rows, n_columns), rows of all runs stacked."""
    simulator = study.sketcher((*solution.effects, effect))
    grid = shapes(effect)
    share = 1.0 if _has_grid_of_amplitudes(effect) else SHARE
    amplitudes = [x.id for x in effect.parameters[: effect.amplitudes]]
    sets = [{}, *(values | {a: share * values[a] for a in amplitudes} for point in grid for values in point)]
    neutral = {x.id: x.initial for x in effect.parameters} | effect.neutral
    theta = np.array([_parameters(simulator, solution, neutral | values) for values in sets])
    stacked = []
    for run, x0 in zip(study.fitted, solution.x0, strict=True):
        start = np.array(initial_state(simulator.equations, run))
        start[: x0.size] = x0
        y = simulator.simulate_many(theta, run, x0=start) / run.sensor_std
        stacked.append((y[1:] - y[0]).reshape(len(sets) - 1, -1).T / share)
    return grid, np.concatenate(stacked)


def _parameters(simulator: TwoStep, solution: Solution, extra: dict[str, float]) -> list[float]:
    known = solution.values | extra
    return [known.get(q.id, q.initial) for q in simulator.equations.parameters]


def signatures(study: Study, solution: Solution, entries: Sequence[Effect]) -> Signatures:
    """Take the signatures of ``entries`` (SI-scaled, not random) about ``solution``."""
    with ThreadPoolExecutor(2) as pool:
        taken = list(pool.map(lambda e: entry_columns(study, solution, e), entries))
    points, blocks, column = [], [], 0
    for effect, (grid, raw) in zip(entries, taken, strict=True):
        at = 0
        for point in grid:
            block = raw[:, at : at + len(point)]
            at += len(point)
            if not np.isfinite(block).all() or np.abs(block).max() > BLOWN:
                continue
            points.append(Point(key=effect.key, values=point, columns=slice(column, column + len(point))))
            blocks.append(block)
            column += len(point)
    simulations = sum(raw.shape[1] + 1 for _, raw in taken) * len(study.fitted)
    return Signatures(points=tuple(points), raw=np.concatenate(blocks, axis=1), simulations=simulations)


def _scored(rows: Array, first: int) -> Array:
    if first == 0:
        return rows
    kept = rows.copy()
    kept[1:first] = 0.0
    return kept
