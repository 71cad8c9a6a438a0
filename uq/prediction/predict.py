"""Posterior predictive positions of a run: density, terms and draws of η in, `Bands` with their coverage out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array, Run
from haptid.noise.marginal import coefficients
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import Terms, column_scales
from haptid.uq.density.density import Density
from haptid.uq.density.equilibrium import equilibrium
from haptid.uq.density.likelihood import Misfit
from haptid.uq.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Bands:
    """Equal-tailed predictive bands of one run.

    Parameters
    ----------
    run
        The run.
    median
        Predictive median, shape (n_t,).
    lower, upper
        Band edges by level, shape (n_levels, n_t) each.
    covered
        Share of the scored rows that lie within each band [1], shape (n_levels,).
    cycle_factors
        Mean and standard deviation of the amplitude factor 1 + s·ξ of every cycle given the data [1], shape
        (n_cycles, 2); shape (0, 2) without scatter.
    unit
        Unit of median and edges: that of the position or of the torque.
    """

    run: Run
    median: Array
    lower: Array
    upper: Array
    covered: Array
    cycle_factors: Array
    unit: str


def predict(density: Density, terms: Terms, draws: Array, rng: np.random.Generator) -> Bands:
    """Draw new readings of a run, and take their bands.

    A reading takes its parameters from the posterior draws and its initial state from the state's distribution given
    the data; the amplitudes of cycles and run, and the noise, are drawn anew.

    Parameters
    ----------
    density
        Posterior density under the chosen noise model.
    terms
        The run, linearised at the mode.
    draws
        Posterior draws of η, shape (n_draws, n).
    rng
        Source of the random numbers.

    Returns
    -------
    Bands
        Median and band edges at the contents `THRESHOLDS.probability_contents`; draws whose simulation is not finite
        take no part.
    """
    thetas, hyper = density.coordinates.thetas(draws), density.hyper(draws)
    simulated = density.simulate(draws, terms)
    sound = np.isfinite(simulated).all(axis=1)  # one diverged draw would make every quantile NaN
    thetas, simulated = thetas[sound], simulated[sound]
    hyper = {name: value[sound] for name, value in hyper.items()}
    model, n_start = density.model, len(terms.states)
    gram, _ = Misfit.of(terms, model, density.equations, thetas, simulated).gram(hyper)
    mean, covariance = coefficients(gram, column_scales(terms, model, hyper))
    start = mean[:, :n_start] + _normal(covariance[:, :n_start, :n_start], rng) + terms.start_shift
    clean = simulated + start @ terms.fixed[:n_start]
    motion = clean - equilibrium(density.equations, thetas, float(terms.data.mean()))[:, None]
    y = clean + _draw_scatter(terms, model, hyper, motion, rng) + _noise(terms, model, hyper, rng)
    contents = THRESHOLDS.probability_contents
    edges = np.quantile(y, [0.5, *((1 - p) / 2 for p in contents), *((1 + p) / 2 for p in contents)], axis=0)
    lower, upper = edges[1 : 1 + len(contents)], edges[1 + len(contents) :]
    inside = (terms.data >= lower) & (terms.data <= upper)
    factors = _cycle_factors(terms, model, mean[:, n_start:], covariance[:, n_start:, n_start:])
    return Bands(
        run=terms.run,
        median=edges[0],
        lower=lower,
        upper=upper,
        covered=inside[:, terms.run.scored].mean(axis=1),
        cycle_factors=factors,
        unit=density.equations.outputs[0].unit,
    )


def _normal(covariance: Array, rng: np.random.Generator) -> Array:
    """Draw once from N(0, C) for every C (n_sets, k, k), which may be singular; shape (n_sets, k)."""
    weights, vectors = np.linalg.eigh(covariance)  # a Cholesky factor would not exist of a singular C
    scaled = np.sqrt(np.maximum(weights, 0.0)) * rng.standard_normal(weights.shape)
    return np.asarray(np.einsum("wij,wj->wi", vectors, scaled))


def _draw_scatter(
    terms: Terms, model: NoiseModel, hyper: dict[str, Array], motion: Array, rng: np.random.Generator
) -> Array:
    """Draw the deviation that new amplitudes of cycles and run cause [rad], shape (n_sets, n_t)."""
    if model.scatter == "none":
        return np.zeros_like(motion)
    xi = hyper["cycle_scatter"][:, None] * rng.standard_normal((len(motion), terms.cycles))
    common = hyper["run_scatter"][:, None] * rng.standard_normal((len(motion), 1)) if model.runs else 0.0
    if model.scatter == "reading":
        return np.asarray(motion * (xi + common)[:, terms.cycle])
    columns = terms.fixed[len(terms.states) : len(terms.states) + terms.cycles]
    return np.asarray((xi + common) @ columns)


def _noise(terms: Terms, model: NoiseModel, hyper: dict[str, Array], rng: np.random.Generator) -> Array:
    """Draw white noise, and the correlated model error where the noise model has one [rad], shape (n_sets, n_t)."""
    sets, rows = hyper["noise_factor"].size, terms.run.t.size
    out = terms.sensor_std * hyper["noise_factor"][:, None] * rng.standard_normal((sets, rows))
    if model.correlated:
        keep = np.exp(-np.diff(terms.run.t)[None] / hyper["error_time"][:, None])
        shocks = rng.standard_normal((sets, rows))
        error = hyper["model_error"] * shocks[:, 0]
        out[:, 0] += error
        for k in range(1, rows):
            phi = keep[:, k - 1]  # an Ornstein–Uhlenbeck process at its rows is AR(1), of constant variance
            error = phi * error + hyper["model_error"] * np.sqrt(1 - phi**2) * shocks[:, k]
            out[:, k] += error
    return np.asarray(out)


def _cycle_factors(terms: Terms, model: NoiseModel, mean: Array, covariance: Array) -> Array:
    """Return mean and standard deviation of each cycle's amplitude factor, shape (n_cycles, 2).

    The variance is the mean of the variances given each draw plus the variance of the means over draws.
    """
    if model.scatter == "none":
        return np.empty((0, 2))
    n = terms.cycles
    total, inner = mean[:, :n], np.einsum("wii->wi", covariance)[:, :n]
    if model.runs:
        total = total + mean[:, n:]
        inner = inner + 2 * covariance[:, :n, n] + covariance[:, n, n][:, None]
    return np.stack([1 + total.mean(axis=0), np.sqrt(inner.mean(axis=0) + total.var(axis=0))], axis=1)
