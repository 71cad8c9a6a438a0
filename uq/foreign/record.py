"""Files of an FMU's posterior: `ForeignPosterior` in, JSON, CSV draws, NetCDF and the command's summary out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from haptid.support.tables import Told
from haptid.uq.foreign.infer import ForeignPosterior
from haptid.uq.result.arviz_door import write_netcdf
from haptid.uq.result.record import SCHEMA, parameter_json, write_draws
from haptid.uq.result.sampler_state import tell_state


def posterior_json(posterior: ForeignPosterior, seed: int) -> dict[str, Any]:
    """Convert a posterior to the content of ``posterior.json``: no joints, the parameters by variable.

    Parameters
    ----------
    posterior
        Posterior of an FMU.
    seed
        Seed of the command.

    Returns
    -------
    dict
        Content that `write_json` takes: campaign, parameters, state of the sampling, and the share of each run's
        readings within the bands.
    """
    campaign, drawn = posterior.calibrated.campaign, posterior.sample
    names = variable_names(posterior)
    return {
        "schema": SCHEMA,
        "model": campaign.model.name,
        "campaign": campaign.title,
        "measured": campaign.measured,
        "seed": seed,
        "intervals": "equal-tailed",
        "joints": [],
        "sound": posterior.sound,
        "state": posterior.state,
        "parameters": {name: parameter_json(p) for name, p in zip(names, posterior.parameters, strict=True)},
        "sampling": {
            "ensembles": drawn.chain.shape[0],
            "steps": drawn.chain.shape[1],
            "walkers": drawn.chain.shape[2],
            "move": drawn.move,
            "tau": float(drawn.tau.max()),
            "tau_known": drawn.reached,
            "effective": float(drawn.effective.min()),
            "acceptance": [float(a) for a in drawn.acceptance],
            "worst_rhat": posterior.worst_rhat,
            "modes": posterior.modes,
            "correlation_time_rows": float(posterior.calibrated.correlation_time),
        },
        "runs": [
            {
                "file": band.run.file,
                "use": band.run.use,
                "covered": {f"{content:g}": share for content, share in band.covered.items()},
            }
            for band in posterior.bands
        ],
        "wall_s": round(posterior.wall_s, 3),
    }


def variable_names(posterior: ForeignPosterior) -> tuple[str, ...]:
    """Return the names of the coordinates.

    Parameters
    ----------
    posterior
        Posterior of an FMU's parameters.

    Returns
    -------
    tuple of str
        Variables of the FMU, then the noise factor.
    """
    free = posterior.coordinates.free
    return (*(q.structured for q in free), *(h.id for h in posterior.coordinates.hyper))


def save_draws(posterior: ForeignPosterior, path: Path, seed: int, size: int = 500) -> Path:
    """Write ``parameters_posterior.csv``: a row per draw, columns named as the FMU's variables, fixed ones included.

    Parameters
    ----------
    posterior
        Posterior of an FMU.
    path
        File to write.
    seed
        Seed of the choice of draws.
    size
        Number of rows.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    flat = posterior.sample.flat()
    chosen = flat[np.random.default_rng([seed, 5]).integers(0, len(flat), size)]
    names = [q.structured for q in posterior.coordinates.equations.parameters]
    return write_draws(path, names, posterior.coordinates.thetas(chosen))


def save_chains(posterior: ForeignPosterior, path: Path) -> Path:
    """Write all draws as a file of ArviZ.

    Parameters
    ----------
    posterior
        Posterior of an FMU.
    path
        File to write.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    values = posterior.values()
    draws = {name: values[..., i] for i, name in enumerate(variable_names(posterior))}
    attributes = {
        "model": posterior.calibrated.campaign.model.name,
        "measured": int(posterior.calibrated.campaign.measured),
        "tau_steps": float(posterior.sample.tau.max()),
        "tau_known": int(posterior.sample.reached),
    }
    return write_netcdf(path, {"posterior": draws}, dims={}, coords={}, attributes=attributes)


def tell_summary(posterior: ForeignPosterior) -> Told:
    """Tell a sentence for each parameter, the share of readings in each band, and what the sampler did.

    Parameters
    ----------
    posterior
        Posterior of an FMU's parameters.

    Returns
    -------
    list
        Lines; the first names the FMU.
    """
    drawn = posterior.sample
    known = "settled" if drawn.reached else "not settled"
    least = min(p.diagnostics.ess_bulk for p in posterior.parameters)
    agreement = f"R̂ {posterior.worst_rhat:.3f}, ESS {least:.0f}"
    sampler = f"τ {drawn.tau.max():.1f} steps ({known}), {agreement}, {posterior.wall_s:.0f} s"
    lines = [posterior.calibrated.campaign.model.name, *tell_state(posterior.state)]
    lines += [f"  {p.verdict}" for p in posterior.parameters]
    for band in posterior.bands:
        lines.append(f"  {band.run.file} ({band.run.use}): {band.covered[0.95]:.0%} of the readings in the 95 % band")
    return [*lines, f"  sampler: {sampler}"]
