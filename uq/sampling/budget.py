"""Bound of what short chains simulate: `SamplingOptions` and the cost of a density in, fewer steps out."""

from __future__ import annotations

from dataclasses import replace

from haptid.uq.sampling.sampling import SamplingOptions, walkers_of
from haptid.uq.thresholds import THRESHOLDS


def shorten(options: SamplingOptions, inner_steps: int, dimension: int) -> SamplingOptions:
    """Take fewer steps where each of them simulates much.

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
        Chunk, burn-in and longest chain by one factor shorter, so that all walkers together simulate about
        `THRESHOLDS.most_inner_steps_of_short_chains`, but no shorter than `THRESHOLDS.least_share_of_short_chains`;
        ``options`` where they simulate less.

    Notes
    -----
    The number of steps follows from rows, inner step and walkers, not from a clock: the same seed gives the same draws
    on every machine.
    """
    walkers = options.ensembles * (options.walkers or walkers_of(dimension))
    expected = (options.burn + options.longest) * walkers * inner_steps
    share = max(THRESHOLDS.most_inner_steps_of_short_chains / expected, THRESHOLDS.least_share_of_short_chains)
    if share >= 1.0:
        return options
    chunks = options.longest // options.chunk
    chunk = round(share * options.chunk)
    return replace(options, chunk=chunk, burn=round(share * options.burn), longest=chunks * chunk)


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
        f"chains of {taken.longest} steps after {taken.burn} of burn-in, in place of {usual.longest} and {usual.burn}: "
        f"each density takes {inner_steps} inner steps of simulation, and --quick bounds their number"
    )
