"""A sampled joint in words: `Posterior` in, the table and the lines that a command shows out."""

from __future__ import annotations

from haptid.support.numbers import write_interval
from haptid.support.tables import Table, Told
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.sampler_state import tell_state

HEADER = ("parameter", "median", "95 % interval", "unit", "what is known")


def tell_posterior(posterior: Posterior) -> Told:
    """Tell how well each parameter is known, and what the chains are worth.

    Parameters
    ----------
    posterior
        Posterior of one joint.

    Returns
    -------
    list
        A line for the joint, one for each doubt, one on chains that are not sound, one on chains that --quick
        shortened, one that the intervals are those of the model alone where there is a doubt, a table with a row a
        parameter (a sentence each in plain text), a line on the sampler.
    """
    sample = posterior.sample
    rows = []
    for p in posterior.parameters:
        low, high = p.intervals[0.95]
        rows.append((p.id, f"{p.median:.4g}", write_interval(low, high, 4), p.unit, p.verdict))
    known = "settled" if sample.reached else "not settled"
    return [
        f"joint {posterior.joint} ({posterior.chosen.model.words})",
        *(f"  do not use these intervals yet: {doubt}" for doubt in posterior.doubts),
        *tell_state(posterior.state),
        *([f"  shortened: {posterior.shortened}"] if posterior.shortened else []),
        *(["  what follows holds within this model, not for the joint:"] if posterior.doubts else []),
        Table(header=HEADER, rows=rows, plain="\n".join(f"  {p.verdict}" for p in posterior.parameters)),
        f"  sampler: τ {sample.tau.max():.1f} steps ({known}), R̂ {posterior.worst_rhat:.3f}, "
        f"ESS {min(p.diagnostics.ess_bulk for p in posterior.parameters):.0f}, {posterior.wall_s:.0f} s",
    ]
