"""Summary of every coordinate of a posterior: `Sample` in, intervals, diagnostics and a sentence out.

Each summary compares posterior and prior, so that a reader sees which parameters the data determine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.numbers import with_unit, write_interval
from haptid.uq.density.coordinates import Coordinates, prior_words
from haptid.uq.result.arviz_door import Diagnostics, diagnose
from haptid.uq.sampling.sampling import Sample
from haptid.uq.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """One-sided limit on a parameter whose posterior piles up at a bound.

    Parameters
    ----------
    side
        Side of the value on which the parameter lies: ``below`` where the lower bound is the one that it piles up at.
    value
        Limit with a probability of 95 %, in the parameter's unit.
    bound
        Bound that it piles up at, in the parameter's unit.
    """

    side: Literal["below", "above"]
    value: float
    bound: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterSummary:
    """The posterior of one parameter.

    Parameters
    ----------
    id, unit, description
        Name, unit and meaning of the parameter.
    prior
        The prior in words.
    mean, std, median
        Of the untransformed value, in its unit.
    intervals
        Equal-tailed intervals by level, in the parameter's unit.
    contraction
        Posterior over prior standard deviation [1]: the smaller of that of the value and that of the coordinate in
        which it was sampled. In a logarithm, what is piled up at a bound of 0 is as wide as its prior.
    overlap
        ∫ min(prior, posterior), in the coordinate in which it was sampled [1]: 1 where the data hold no information.
    diagnostics
        Convergence diagnostics of the untransformed value.
    verdict
        Sentence on how well the parameter is known.
    limit
        What the data say of a parameter whose posterior piles up at a bound of its prior; None for any other.
    """

    id: str
    unit: str
    description: str
    prior: str
    mean: float
    std: float
    median: float
    intervals: dict[float, tuple[float, float]]
    contraction: float
    overlap: float
    diagnostics: Diagnostics
    verdict: str
    limit: Limit | None = None


def chains_of(sample: Sample) -> Array:
    """Concatenate the walkers of every ensemble to one chain.

    Parameters
    ----------
    sample
        Chains of the ensembles.

    Returns
    -------
    ndarray, shape (n_ensembles, n_draws, n)
        Coordinates η, walker after walker.

    Notes
    -----
    Walkers of one ensemble are not independent chains. Within a chain the draws of a walker stay in their order, so
    that ArviZ estimates the autocorrelation of the walkers.
    """
    e, s, w, n = sample.chain.shape
    return np.swapaxes(sample.chain, 1, 2).reshape(e, w * s, n)


def summarise(coordinates: Coordinates, sample: Sample, rng: np.random.Generator) -> tuple[ParameterSummary, ...]:
    """Summarise every coordinate of a posterior.

    Parameters
    ----------
    coordinates
        Coordinates with their priors.
    sample
        Chains of η.
    rng
        Source of the draws from the prior.

    Returns
    -------
    tuple of ParameterSummary
        In the order of η.
    """
    chains = chains_of(sample)
    values = coordinates.values(chains)
    prior = coordinates.draw(rng, 4000)
    prior_values = coordinates.values(prior)
    words = [prior_words(q) for q in coordinates.free] + [h.prior.words for h in coordinates.hyper]
    texts = [q.description for q in coordinates.free] + [h.description for h in coordinates.hyper]
    eta_bounds = np.stack(coordinates.bounds(), axis=-1)
    made = []
    for i, (id, unit) in enumerate(zip(coordinates.names, coordinates.units, strict=True)):
        x, eta = values[..., i], chains[..., i]
        intervals = {
            p: tuple(np.quantile(x, [(1 - p) / 2, (1 + p) / 2]).tolist()) for p in THRESHOLDS.probability_contents
        }
        # A value that piles up at 0 is as wide as its prior in the logarithm, and far narrower in its own unit.
        contraction = float(min(eta.std() / prior[:, i].std(), x.std() / prior_values[:, i].std()))
        limit = None
        if i < len(coordinates.free):  # the noise model's bounds are far wider than its priors
            limit = _limit_at_bound(x, eta, (coordinates.free[i].lower, coordinates.free[i].upper), eta_bounds[i])
        overlap = _overlap(eta.ravel(), prior[:, i])
        made.append(
            ParameterSummary(
                id=id,
                unit=unit,
                description=texts[i],
                prior=words[i],
                mean=float(x.mean()),
                std=float(x.std()),
                median=float(np.median(x)),
                intervals=intervals,
                contraction=contraction,
                overlap=overlap,
                diagnostics=diagnose(x),
                verdict=_verdict(id, unit, float(np.median(x)), intervals[0.95], contraction, limit),
                limit=limit,
            )
        )
    return tuple(made)


def _overlap(posterior: Array, prior: Array) -> float:
    """Return ∫ min(p, q) of two samples by histograms over their common range.

    A bin is a quarter of the posterior's standard deviation wide, within 20 to 4000 bins.
    """
    low, high = min(posterior.min(), prior.min()), max(posterior.max(), prior.max())
    bins = int(np.clip(4 * (high - low) / max(posterior.std(), 1e-300), 20, 4000))
    p, _ = np.histogram(posterior, bins=bins, range=(low, high))
    q, _ = np.histogram(prior, bins=bins, range=(low, high))
    return float(np.minimum(p / p.sum(), q / q.sum()).sum())


def _limit_at_bound(values: Array, eta: Array, bounds: tuple[float, float], eta_bounds: Array) -> Limit | None:
    """Return the limit on a parameter that piles up at a bound, in its own unit or in the coordinate of the sampler.

    The bounds are given in both. An upper bound shows in the logarithm, a lower bound of 0 in the value alone.
    """
    for part, (lower, upper) in ((values, bounds), (eta, eta_bounds)):
        low, high = np.quantile(part, [0.025, 0.975])
        most = THRESHOLDS.largest_distance_to_bound_over_reach
        if low - lower < most * (high - lower):
            return Limit(side="below", value=float(np.quantile(values, 0.95)), bound=float(bounds[0]))
        if upper - high < most * (upper - low):
            return Limit(side="above", value=float(np.quantile(values, 0.05)), bound=float(bounds[1]))
    return None


def _verdict(
    id: str, unit: str, median: float, interval: tuple[float, float], contraction: float, limit: Limit | None
) -> str:
    low, high = interval
    # The order counts: a scatter is judged by its size alone, and an interval that is the prior's says nothing about 0.
    if id.endswith("_scatter") or id == "model_error":
        return _scatter_verdict(id, unit, median, interval)
    if contraction > THRESHOLDS.largest_std_over_prior_std:
        return f"{id} is set by its prior: {_compare_to_prior(contraction)}."
    if limit is not None:
        return f"{id} {_place_of(limit, unit)}: with 95 % it is {limit_words(limit, unit)}."
    if low < 0 < high:
        return f"{id} cannot be told from 0: its 95 % interval is {write_interval(low, high, 3)}."
    half_width = (high - low) / 2 / abs(median)
    if half_width > THRESHOLDS.largest_half_width_of_known:
        return f"{id} is hardly known: its 95 % interval is {with_unit(write_interval(low, high, 3), unit)}."
    return f"{id} is known to ±{percent(half_width)} (95 %)."


def _compare_to_prior(contraction: float) -> str:
    # Of a parameter that the data do not touch, draws of posterior and prior differ by chance.
    if contraction > 0.95:
        return "its interval is as wide as without the data"
    return f"its interval is {percent(contraction)} as wide as without the data"


def _place_of(limit: Limit, unit: str) -> str:
    if limit.bound == 0:
        return "cannot be told from 0"
    side = "lower" if limit.side == "below" else "upper"
    return f"lies at its {side} bound of {with_unit(f'{limit.bound:.2g}', unit)}"


def limit_words(limit: Limit, unit: str) -> str:
    """Write a one-sided limit, as in below 1.3e-05 N m/rad.

    Parameters
    ----------
    limit
        Limit of a parameter.
    unit
        Unit of the parameter.

    Returns
    -------
    str
        Side, and the value with two digits and its unit.
    """
    return f"{limit.side} {with_unit(f'{limit.value:.2g}', unit)}"


def _scatter_verdict(id: str, unit: str, median: float, interval: tuple[float, float]) -> str:
    low, high = interval
    relative = id.endswith("_scatter")
    name = {
        "cycle_scatter": "The amplitude scatter from cycle to cycle",
        "run_scatter": "The amplitude scatter from run to run",
    }
    words = name.get(id, "The correlated model error")

    def write_size(x: float) -> str:
        return percent(x) if relative else f"{x:.2g} {unit}"

    if low < THRESHOLDS.least_ratio_of_scatter_ends * high:
        return f"{words} is not seen: with 95 % it is below {write_size(high)}."
    return f"{words} is {write_size(median)} ({write_size(low)} to {write_size(high)}, 95 %)."


def percent(share: float) -> str:
    """Write a share in percent with two digits, as in 0.42 %.

    Parameters
    ----------
    share
        Share [1].

    Returns
    -------
    str
        Whole percent from 99.5 % up.
    """
    return f"{100 * share:.2g} %" if 100 * share < 99.5 else f"{100 * share:.0f} %"
