"""The one place that touches ArviZ: diagnostics and the NetCDF file."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.files.cache import give_matplotlib_a_folder
from haptid.support.files.files import write_bytes

give_matplotlib_a_folder()  # ArviZ imports it
with warnings.catch_warnings():
    warnings.simplefilter("ignore", FutureWarning)  # ArviZ announces its next major version at every import
    try:
        import arviz as az
    except FileNotFoundError:  # another process moved the stamp of that announcement away meanwhile: it is there now
        import arviz as az


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostics:
    """What ArviZ says of one quantity: rank-normalised split R̂, bulk and tail ESS (Vehtari et al. 2021), MCSE."""

    rhat: float
    ess_bulk: float
    ess_tail: float
    mcse_mean: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaveOneOut:
    """PSIS-LOO over cycles (Vehtari, Gelman, Gabry 2017): expected log density, standard error, Pareto k by cycle."""

    elpd: float
    std: float
    effective: float
    pareto_k: Array


def diagnose(chains: Array) -> Diagnostics:
    """Diagnose one quantity, chains (n_chains, n_draws)."""
    return Diagnostics(
        rhat=float(az.rhat(chains, method="rank")),
        ess_bulk=float(az.ess(chains, method="bulk")),
        ess_tail=float(az.ess(chains, method="tail")),
        mcse_mean=float(az.mcse(chains, method="mean")),
    )


def leave_one_out(log_likelihood: Array) -> LeaveOneOut:
    """PSIS-LOO of pointwise log densities (n_chains, n_draws, n_points)."""
    data = az.from_dict(posterior={"draw_weight": log_likelihood.sum(axis=-1)}, log_likelihood={"y": log_likelihood})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # large Pareto k are reported, not warned of
        found = az.loo(data, pointwise=True)
    return LeaveOneOut(
        elpd=float(found.elpd_loo),
        std=float(found.se),
        effective=float(found.p_loo),
        pareto_k=np.asarray(found.pareto_k, dtype=np.float64),
    )


def write_netcdf(
    path: Path, groups: Mapping[str, Mapping[str, Array]], *, dims: Mapping[str, list[str]],
    coords: Mapping[str, list[Any]], attributes: Mapping[str, Any],
) -> Path:  # fmt: skip
    """Write groups of named arrays (n_chains, n_draws, …) as an ArviZ file, whole or not at all.

    The time of writing is left out, so that the same posterior gives the same content.
    """
    data = az.from_dict(**{name: dict(group) for name, group in groups.items()}, dims=dict(dims), coords=dict(coords))
    for name in data.groups():
        data[name].attrs = {key: value for key, value in data[name].attrs.items() if key != "created_at"}
    data.attrs = dict(attributes)
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, suffix=".nc")
    os.close(descriptor)
    data.to_netcdf(temporary, engine="h5netcdf")
    content = Path(temporary).read_bytes()
    Path(temporary).unlink()
    return write_bytes(path, content)
