"""A sampled joint in words: `Posterior` in, the lines that a command prints out."""

from __future__ import annotations

from haptid.uq.result.posterior import Posterior


def tell_posterior(posterior: Posterior) -> str:
    """Write how well each parameter is known, and what the chains are worth.

    Parameters
    ----------
    posterior
        Posterior of one joint.

    Returns
    -------
    str
        A line for the joint, one a parameter, one on the sampler.
    """
    sample = posterior.sample
    lines = [f"joint {posterior.joint} ({posterior.chosen.model.words})"]
    lines += [f"  {p.verdict}" for p in posterior.parameters]
    known = "settled" if sample.reached else "the chain is too short to settle it: final figures without --quick"
    lines.append(
        f"  sampler: τ {sample.tau.max():.1f} steps ({known}), R̂ {posterior.worst_rhat:.3f}, "
        f"ESS {min(p.diagnostics.ess_bulk for p in posterior.parameters):.0f}, {posterior.wall_s:.0f} s"
    )
    return "\n".join(lines)
