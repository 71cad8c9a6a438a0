"""Bound of what short chains simulate: `SamplingOptions` and a density's cost in, fewer ensembles and steps out."""

from __future__ import annotations

from dataclasses import replace

from haptid.uq.sampling.sampling import SamplingOptions, walkers_of
from haptid.uq.thresholds import THRESHOLDS


def shorten(options: SamplingOptions, inner_steps: int, dimension: int) -> SamplingOptions:
    """Take fewer ensembles and steps where each of them simulates much.

    Parameters
    ----------
    options
        Options of short chains.
    inner_steps
        Inner steps of the simulations behind one density [1].
    dimension
        Number of coordinates.

    Returns
    -------
    SamplingOptions
        ``options`` where all walkers together simulate at most `THRESHOLDS.most_inner_steps_of_short_chains`; else half
        of the ensembles, and where these simulate more, too, chunk, burn-in and longest chain by one factor shorter,
        but no shorter than `THRESHOLDS.least_share_of_short_chains`.

    Notes
    -----
    Ensembles are given up first, because steps are what chains of long autocorrelation lack; the two that remain still
    tell whether they agree. The number of steps follows from rows, inner step and walkers, not from a clock: the same
    seed gives the same draws on every machine.
    """
    walkers = options.walkers or walkers_of(dimension)
    simulated = (options.burn + options.longest) * walkers * inner_steps
    most = THRESHOLDS.most_inner_steps_of_short_chains
    if options.ensembles * simulated <= most:
        return options
    ensembles = options.ensembles // 2
    share = min(1.0, max(most / (ensembles * simulated), THRESHOLDS.least_share_of_short_chains))
    chunks = options.longest // options.chunk
    chunk = round(share * options.chunk)
    burn = round(share * options.burn)
    return replace(options, ensembles=ensembles, chunk=chunk, burn=burn, longest=chunks * chunk)


def tell_shortened(usual: SamplingOptions, taken: SamplingOptions, inner_steps: int) -> str:
    """Tell in a sentence that chains were shortened.

    Parameters
    ----------
    usual, taken
        Options of short chains, and what `shorten` made of them.
    inner_steps
        Inner steps of the simulations behind one density [1].

    Returns
    -------
    str
        Empty where nothing was shortened.
    """
    if taken == usual:
        return ""
    return (
        f"{taken.ensembles} ensembles of {taken.longest} steps after {taken.burn} of burn-in, in place of "
        f"{usual.ensembles} of {usual.longest} after {usual.burn}: each density takes {inner_steps} inner steps of "
        "simulation, and --quick bounds their number"
    )
