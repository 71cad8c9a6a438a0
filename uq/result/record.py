"""Files of a posterior: `Posterior` in, NetCDF for ArviZ, JSON for scripts and CSV draws for external tools out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.fmu_build.accuracy.draws import draws_text
from haptid.fmu_build.description.variables import structured_name
from haptid.measurement.values.run import Array
from haptid.support.files.files import write_text
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.arviz_door import write_netcdf
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.summary import ParameterSummary
from haptid.uq.thresholds import THRESHOLDS

SCHEMA = "posterior/1"


def save_chains(posterior: Posterior, path: Path, *, measured: bool) -> Path:
    """Write ``joint<j>.nc``: posterior, prior, log densities by cycle and run, predictive bands, measurements.

    Measurements and bands are those of the residual: ``position_<k>`` [rad, m] or ``torque_<k>`` [N m, N] of run k.

    Parameters
    ----------
    posterior
        Posterior of the joint.
    path
        File to write.
    measured
        Whether the runs are measured (else simulated by a virtual device).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    coordinates = posterior.mode.density.coordinates
    values = coordinates.values(posterior.draws)
    prior = coordinates.values(coordinates.draw(np.random.default_rng(0), 2000))[None]
    terms = posterior.mode.density.terms
    cycles = [f"{t.run.file}#{c}" for t in terms for c in range(t.cycles)]
    rows = {f"{posterior.residual}_{k}": band for k, band in enumerate(posterior.bands)}
    groups: dict[str, dict[str, Any]] = {
        "posterior": {name: values[..., i] for i, name in enumerate(coordinates.names)},
        "prior": {name: prior[..., i] for i, name in enumerate(coordinates.names)},
        "log_likelihood": {"cycle": posterior.cycle_log_density, "run": posterior.run_log_density},
        "observed_data": {name: band.run.y[:, 0] for name, band in rows.items()},
        "constant_data": {
            **{f"band_{k}": np.concatenate([b.lower, b.upper]) for k, b in enumerate(posterior.bands)},
            **{f"median_{k}": b.median for k, b in enumerate(posterior.bands)},
            **{f"time_{k}": b.run.t for k, b in enumerate(posterior.bands)},
        },
    }
    dims = {"cycle": ["cycle_of_run"], "run": ["file"]}
    dims |= {name: [f"row_{k}"] for k, name in enumerate(rows)}
    for k in range(len(posterior.bands)):
        dims |= {f"band_{k}": ["edge", f"row_{k}"], f"median_{k}": [f"row_{k}"], f"time_{k}": [f"row_{k}"]}
    edges = [f"{end}_{p:g}" for end in ("lower", "upper") for p in THRESHOLDS.probability_contents]
    attributes = {
        "joint": posterior.joint,
        "unit": posterior.unit,
        "measured": int(measured),
        "noise_model": posterior.chosen.model.id,
        "tau_steps": float(posterior.sample.tau.max()),
        "tau_known": int(posterior.sample.reached),
        "rhat_of_the_full_chains": posterior.worst_rhat,
    }
    coords = {"cycle_of_run": cycles, "file": [t.run.file for t in terms], "edge": edges}
    return write_netcdf(path, groups, dims=dims, coords=coords, attributes=attributes)


def save_draws(posteriors: Sequence[Posterior], path: Path, rng: np.random.Generator, size: int = 500) -> Path:
    """Write ``parameters_posterior.csv``: a row per draw, columns named as the parameters of the FMUs.

    Parameters
    ----------
    posteriors
        One posterior per joint. Joints are sampled independently, so each joint draws its own rows.
    path
        File to write.
    rng
        Source of the random choice of draws.
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
    names, columns = [], []
    for posterior in posteriors:
        coordinates = posterior.mode.density.coordinates
        flat = posterior.draws.reshape(-1, posterior.draws.shape[-1])
        thetas = coordinates.thetas(flat[rng.integers(0, len(flat), size)])
        for i, quantity in enumerate(coordinates.equations.parameters):
            names.append(structured_name(coordinates.equations, quantity.id, quantity.structured))
            columns.append(thetas[:, i])
    return write_draws(path, names, np.array(columns).T)


def correlation_json(posterior: Posterior) -> dict[str, Any]:
    """Return the correlation of the joint's parameters over all chains, as ``posterior.json`` holds it.

    Parameters
    ----------
    posterior
        Posterior of a joint.

    Returns
    -------
    dict
        ``ids`` of the free parameters, and their ``matrix`` (n × n) as lists.
    """
    coordinates = posterior.mode.density.coordinates
    n = len(coordinates.free)
    values = coordinates.values(posterior.sample.flat())[:, :n]
    matrix = np.corrcoef(values.T).reshape(n, n)
    return {"ids": list(coordinates.names[:n]), "matrix": matrix.tolist()}


def write_draws(path: Path, names: Sequence[str], draws: Array) -> Path:
    """Write draws as CSV, a row a draw with its number.

    Parameters
    ----------
    path
        File to write.
    names
        Names of the columns.
    draws
        Parameters in their units, shape (n_draws, n_names).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    return write_text(path, draws_text(names, draws))


def as_json(posterior: Posterior, data: str = "") -> dict[str, Any]:
    """Return the posterior of one joint in the form of ``posterior.json``.

    Parameters
    ----------
    posterior
        Posterior of the joint.
    data
        Digest of what it was inferred from, as identification.json states it of the fit.

    Returns
    -------
    dict
        JSON data; numbers may be NaN.
    """
    sample = posterior.sample
    return {
        "joint": posterior.joint,
        "sound": posterior.sound,
        "state": posterior.state,
        "doubts": list(posterior.doubts),
        "data": data,
        "residual": posterior.residual,
        "correlation": correlation_json(posterior),
        "parameters": {p.id: parameter_json(p) for p in posterior.parameters},
        "noise_model": {
            "id": posterior.chosen.model.id,
            "words": posterior.chosen.model.words,
            "held_out_log_score": {s.model.id: s.score for s in posterior.candidates},
        },
        "sampling": {
            "ensembles": sample.chain.shape[0],
            "steps": sample.chain.shape[1],
            "walkers": sample.chain.shape[2],
            "move": sample.move,
            "tau_of_moves": sample.trials,
            "tau": float(sample.tau.max()),
            "tau_known": sample.reached,
            "effective": float(sample.effective.min()),
            "acceptance": [float(a) for a in sample.acceptance],
            "worst_rhat": posterior.worst_rhat,
            "modes": posterior.modes,
        },
        "loo": {
            "elpd": posterior.loo.elpd,
            "std": posterior.loo.std,
            "effective_parameters": posterior.loo.effective,
            "pareto_k_above_0.7": int((posterior.loo.pareto_k > 0.7).sum()),
            "worst_pareto_k": float(posterior.loo.pareto_k.max()),
            "points": "cycles",
        },
        "runs": [
            {
                "file": b.run.file,
                "use": b.run.use,
                "covered": _share_by_content(b),
                "cycle_factors": b.cycle_factors.tolist(),
            }
            for b in posterior.bands
        ],
        "next_run": _next_run(posterior),
        "prior_sensitivity": posterior.sensitivity,
        "wall_s": posterior.wall_s,
        "notes": list(posterior.notes),
    }


def _next_run(posterior: Posterior) -> dict[str, Any] | None:
    run = posterior.next_run
    return None if run is None else {name: getattr(run, name) for name in run.__slots__}


def _share_by_content(bands: Bands) -> dict[str, float]:
    """Return the share of readings within each predictive band, by the band's probability content."""
    return {f"{p:g}": float(c) for p, c in zip(THRESHOLDS.probability_contents, bands.covered, strict=True)}


def parameter_json(p: ParameterSummary) -> dict[str, Any]:
    """Return the posterior of one parameter as ``posterior.json`` holds it.

    Parameters
    ----------
    p
        Summary of the parameter.

    Returns
    -------
    dict
        Values in the parameter's unit, diagnostics, prior and verdict.
    """
    return {
        "mean": p.mean,
        "std": p.std,
        "median": p.median,
        "unit": p.unit,
        "intervals": {f"{level:g}": list(ends) for level, ends in p.intervals.items()},
        "prior": p.prior,
        "posterior_over_prior_width": p.contraction,
        "prior_posterior_overlap": p.overlap,
        "rhat": p.diagnostics.rhat,
        "ess_bulk": p.diagnostics.ess_bulk,
        "ess_tail": p.diagnostics.ess_tail,
        "mcse_mean": p.diagnostics.mcse_mean,
        "limit": None if p.limit is None else {"side": p.limit.side, "value": p.limit.value, "probability": 0.95},
        "verdict": p.verdict,
    }
