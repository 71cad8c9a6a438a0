"""Noise of a fitted model: correlation from what does not repeat with the drive, scatter from cycle to cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from discrepancy.channels import channels
from discrepancy.colour import estimate_colour
from discrepancy.noise import Colour, Noise, Path
from discrepancy.scan import movable
from discrepancy.scatter import best_scatter, cycle_columns, restricted_likelihood
from discrepancy.solution import Solution
from discrepancy.study import Study
from measurement.run import Array, Run
from support.threads import mapped

SCATTER = "amplitude_scatter"
PATHS: tuple[Path, ...] = ("reading", "torque")
GAIN = 14.0
"""Twice the gain in restricted log-likelihood from which cycles count as scattering."""
WORTH = 4.0
"""Least such gain about a fixed centre for which the centre is sought."""


def estimate(study: Study, solution: Solution, paths: Sequence[Path] = PATHS) -> Noise:
    """Estimate colour and scatter (where the catalogue has it) from the unwhitened residuals of ``solution``."""
    each = channels(study.fitted)
    colour = estimate_colour([solution.raw.rows[c.number][:, c.column] for c in each], tuple(c.run for c in each))
    if SCATTER not in study.entries:
        return Noise(colour=colour)
    found = [scatter_along(study, solution, path, Colour()) for path in paths]
    best = min(found, key=lambda one: one.deviance)
    if best.gain < GAIN:
        return Noise(colour=colour)
    settled = best.noise
    left = remove_scatter(study, solution, settled)
    colour = estimate_colour(left, study.fitted)
    if not colour.white:
        again = scatter_along(study, solution, settled.path, colour)
        settled = again.noise if again.gain >= GAIN else Noise()
    return settled.but(colour=colour)


def _columns(study: Study, solution: Solution, noise: Noise) -> list[Array]:
    simulator, cycles = study.simulator(solution.effects), study.cycles()

    def one(run: Run, x0: Array) -> Array:
        return cycle_columns(simulator, run, noise, solution.theta, x0, cycles=cycles[run.file])

    return mapped(one, solution.problem.runs, solution.x0, threads=study.threads)


def remove_scatter(study: Study, solution: Solution, noise: Noise) -> list[Array]:
    """Residuals of the runs without the best linear prediction of the cycles' amplitudes."""
    left = []
    for r, M in zip(solution.raw.rows, _columns(study, solution, noise), strict=True):
        weight = M.T @ M + np.eye(M.shape[1]) / max(noise.scatter, 1e-9) ** 2
        left.append(r[:, 0] - M @ np.linalg.solve(weight, M.T @ r[:, 0]))
    return left


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """A scatter with twice its gain in restricted log-likelihood over none, and −2 ln L up to what all have alike."""

    noise: Noise
    gain: float
    deviance: float


def scatter_along(study: Study, solution: Solution, path: Path, colour: Colour) -> Scatter:
    """Return the best scatter on this path.

    Only differences between cycles of one run count: what moves all cycles of a run alike is taken out with the base
    parameters, for a deterministic effect does that too.
    """
    middle = float(np.mean([run.y[:, 0].mean() for run in study.fitted]))
    if path == "torque":
        noise = Noise(path=path)
        return _restricted(study, solution, _columns(study, solution, noise), colour, noise)
    reach = 0.3 * max(float(np.ptp(run.y)) for run in study.fitted)
    columns = _columns(study, solution, Noise(path=path, centre=middle))
    masks = [M != 0 for M in columns]
    std = [run.sensor_std[0] for run in study.fitted]

    def about(centre: float) -> Scatter:
        moved = [M - (centre - middle) * m / s for M, m, s in zip(columns, masks, std, strict=True)]
        return _restricted(study, solution, moved, colour, Noise(path=path, centre=centre))

    first = about(middle)
    if first.gain < WORTH:
        return first
    best = minimize_scalar(lambda c: about(c).deviance, bounds=(middle - reach, middle + reach), method="bounded",
                           options={"xatol": 1e-4 * reach, "maxiter": 30})  # fmt: skip
    return about(float(best.x))


def _restricted(study: Study, solution: Solution, columns: list[Array], colour: Colour, noise: Noise) -> Scatter:
    """Scatter of largest restricted likelihood, parameters and one amplitude per run projected out."""
    J = np.concatenate([*(colour.whiten(B[:, 0]) for B in solution.raw.jacobians or ())])
    J = J[:, movable(solution)]
    r = np.concatenate([colour.whiten(row[:, 0]) for row in solution.raw.rows])
    edges = np.cumsum([0, *(run.t.size for run in study.fitted)])
    common = np.zeros((r.size, len(columns)))
    M = np.zeros((r.size, sum(c.shape[1] for c in columns)))
    at = 0
    for i, (column, a, b) in enumerate(zip(columns, edges[:-1], edges[1:], strict=True)):
        whitened = colour.whiten(column)
        M[a:b, at : at + column.shape[1]] = whitened
        common[a:b, i] = whitened.sum(axis=1)
        at += column.shape[1]
    Q = orthonormal(np.column_stack((J, common)))
    r = r - Q @ (Q.T @ r)
    M -= Q @ (Q.T @ M)
    scatter, gain = best_scatter(*restricted_likelihood(r, M))
    return Scatter(noise=noise.but(scatter=scatter), gain=gain, deviance=float(r @ r) - gain)


def orthonormal(A: Array) -> Array:
    """Orthonormal basis of the columns of A, by eigenvectors of their Gram matrix."""
    scaled = A / np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    keep = values > 1e-10 * values[-1]
    return np.asarray(scaled @ (vectors[:, keep] / np.sqrt(values[keep])))
