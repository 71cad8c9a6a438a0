"""Simulate first-order signatures: `Solution` and catalogue `Effect`s in, `Signatures` out.

A signature is the change of the readings that a catalogue effect causes at one shape of its grid. Column j is
(y(θ, s·a) − y(θ, 0))/(s·σ) at the optimum θ, with the typical amplitude a and a share s of it, simulated for all shapes
at once. Effects whose grid holds amplitudes (a dead band, a time constant) are simulated at these amplitudes, s = 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.study.simulators import TwoStep
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.protocol import initial_state
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One shape of one catalogue effect.

    Parameters
    ----------
    key
        Key of the effect.
    values
        Parameters by id, one dict for each column.
    columns
        Slice of the effect's columns in the matrix of signatures.
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
        Shapes in the order of their columns.
    raw
        Unwhitened signatures of all fitted runs over the sensor's standard deviation, run after run, shape
        (n_rows, n_columns).
    simulations
        Number of simulated runs.
    """

    points: tuple[Point, ...]
    raw: Array
    simulations: int

    def whiten(self, study: Study, solution: Solution) -> Array:
        """Whiten the signatures as the residuals of ``solution`` are whitened.

        Parameters
        ----------
        study
            Study with the fitted runs.
        solution
            Fitted model with its noise.

        Returns
        -------
        ndarray
            Whitened signatures, shape (n_rows, n_columns).
        """
        edges = np.cumsum([0, *(run.y.size for run in study.fitted)])
        D = np.empty_like(self.raw)
        for w, run, a, b in zip(solution.problem.whiteners, study.fitted, edges[:-1], edges[1:], strict=True):
            readings = self.raw[a:b].reshape(*run.y.shape, -1)
            D[a:b] = w(_keep_scored_rows(readings, run.score_from)).reshape(b - a, -1)
        return D


def shapes(effect: Effect) -> list[tuple[dict[str, float], ...]]:
    """Return the parameter values of every column, shape by shape.

    Parameters
    ----------
    effect
        Effect in SI units.

    Returns
    -------
    list of tuple of dict
        For every shape of the grid, one dict per column. A grid of amplitudes gives one column; otherwise each
        amplitude has a column in which the other amplitudes are 0.
    """
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
    """Say whether the grid of an effect holds amplitudes."""
    return bool({id for id, _ in effect.shapes} & {x.id for x in effect.parameters[: effect.amplitudes]})


def effect_columns(
    study: Study,
    solution: Solution,
    effect: Effect,
    *,
    gain: float = 0.0,
    share: float = THRESHOLDS.detect.share_of_typical_amplitude,
) -> tuple[list[tuple[dict[str, float], ...]], Array]:
    """Simulate the signatures of one catalogue effect.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model, about which the readings change.
    effect
        Effect in SI units.
    gain
        Observer gain [1/s], under which the readings change.
    share
        Share of the typical amplitude at which the change is taken [1].

    Returns
    -------
    grid, raw
        Parameter values of every column, shape by shape, and the unwhitened signatures over the sensor's standard
        deviation, shape (n_rows, n_columns).
    """
    simulator = study.sketcher((*solution.effects, effect))
    grid = shapes(effect)
    share = 1.0 if _has_grid_of_amplitudes(effect) else share
    amplitudes = [x.id for x in effect.parameters[: effect.amplitudes]]
    sets: list[dict[str, float]] = [{}]  # the first is the model without the effect
    for point in grid:
        for values in point:
            sets.append(values | {a: share * values[a] for a in amplitudes})
    neutral = {x.id: x.initial for x in effect.parameters} | effect.neutral
    theta = np.array([_parameters(simulator, solution, neutral | values) for values in sets])
    stacked = []
    for run, x0 in zip(study.fitted, solution.x0, strict=True):
        start = _start(simulator, solution, run, x0)
        y = simulator.simulate_many(theta, run, x0=start, gain=gain) / run.sensor_std
        stacked.append((y[1:] - y[0]).reshape(len(sets) - 1, -1).T / share)
    return grid, np.concatenate(stacked)


def _start(simulator: TwoStep, solution: Solution, run: Run, x0: Array) -> Array:
    """Return the fitted initial state x0 (n_x,) with the start values of the new effect's states in their places.

    States are found by their id: effects stand in the order of the torque path and of the joints, so that the states
    of a new effect may come before those of an earlier one.
    """
    fitted = dict(zip([s.id for s in solution.equations.states], x0, strict=True))
    equations = simulator.equations
    own = initial_state(equations, run)
    return np.array([fitted.get(s.id, start) for s, start in zip(equations.states, own, strict=True)])


def _parameters(simulator: TwoStep, solution: Solution, extra: dict[str, float]) -> list[float]:
    known = solution.values | extra
    return [known.get(q.id, q.initial) for q in simulator.equations.parameters]


def scored_alone(catalogue: Mapping[str, Effect]) -> list[Effect]:
    """Return the effects that a search in positions scores; a series is tried in the place of its wave alone.

    Parameters
    ----------
    catalogue
        Effects by key.

    Returns
    -------
    list of Effect
        Those without `Effect.series_of`, in their order.
    """
    return [effect for effect in catalogue.values() if not effect.series_of]


def signatures(
    study: Study,
    solution: Solution,
    effects: Sequence[Effect],
    count: Callable[[int], None] = lambda _: None,
    *,
    gain: float = 0.0,
    share: float = THRESHOLDS.detect.share_of_typical_amplitude,
) -> Signatures:
    """Simulate the signatures of all effects.

    Parameters
    ----------
    study
        Study with the fitted runs.
    solution
        Fitted model, about which the readings change.
    effects
        Effects in SI units, none of them random.
    count
        Told how many effects are simulated.
    gain
        Observer gain [1/s], under which the readings change.
    share
        Share of the typical amplitude at which the change is taken [1].

    Returns
    -------
    Signatures
        Signatures without the shapes whose simulation diverged.
    """
    taken = map_threads(
        lambda e: effect_columns(study, solution, e, gain=gain, share=share), effects, threads=2, count=count
    )
    points, blocks, column = [], [], 0
    for effect, (grid, raw) in zip(effects, taken, strict=True):
        at = 0
        for point in grid:
            block = raw[:, at : at + len(point)]
            at += len(point)
            # A diverged simulation would give its shape an arbitrary score.
            if not np.isfinite(block).all() or np.abs(block).max() > THRESHOLDS.detect.largest_change_over_sensor_std:
                continue
            points.append(Point(key=effect.key, values=point, columns=slice(column, column + len(point))))
            blocks.append(block)
            column += len(point)
    simulations = sum(raw.shape[1] + 1 for _, raw in taken) * len(study.fitted)
    return Signatures(points=tuple(points), raw=np.concatenate(blocks, axis=1), simulations=simulations)


def _keep_scored_rows(rows: Array, first: int) -> Array:
    if first == 0:
        return rows
    kept = rows.copy()
    # Row 0 stays: it is the prior of the fitted initial position, whatever the first scored row.
    kept[1:first] = 0.0
    return kept
