"""The only module that imports ArviZ, before 1.0 or after: chains in, diagnostics, PSIS-LOO and the NetCDF file out.

ArviZ 1 needs Python 3.12 and names its groups in another way; the files are the same.

References
----------
Vehtari, A., Gelman, A., and Gabry, J. (2017). Practical Bayesian model evaluation using leave-one-out cross-validation
and WAIC. Statistics and Computing 27, 1413–1432.
Vehtari, A., Gelman, A., Simpson, D., Carpenter, B., and Bürkner, P.-C. (2021). Rank-normalization, folding, and
localization: an improved R̂ for assessing convergence of MCMC. Bayesian Analysis 16, 667–718.
"""

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


TAILS = (0.05, 0.95)
"""Quantiles whose effective sample size is that of the tails (Vehtari et al. 2021)."""
BEFORE_1 = az.__version__.startswith("0.")
"""Whether this is ArviZ before 1.0, whose data are an ``InferenceData`` and no tree of xarray."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostics:
    """Convergence diagnostics of one quantity (Vehtari et al. 2021).

    Parameters
    ----------
    rhat
        Rank-normalised split R̂ [1].
    ess_bulk, ess_tail
        Effective sample sizes of the bulk and of the tails [1].
    mcse_mean
        Monte Carlo standard error of the mean, in the unit of the quantity.
    """

    rhat: float
    ess_bulk: float
    ess_tail: float
    mcse_mean: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaveOneOut:
    """PSIS-LOO over points, here cycles (Vehtari, Gelman, and Gabry 2017).

    Parameters
    ----------
    elpd, std
        Expected log pointwise predictive density and its standard error [1].
    effective
        Effective number of parameters [1].
    pareto_k
        Shape of the Pareto tail of every point's weights [1], shape (n_points,).
    """

    elpd: float
    std: float
    effective: float
    pareto_k: Array


def diagnose(chains: Array) -> Diagnostics:
    """Diagnose the convergence of one quantity.

    Parameters
    ----------
    chains
        Draws, shape (n_chains, n_draws).

    Returns
    -------
    Diagnostics
        Figures of the chains taken together.
    """
    return Diagnostics(
        rhat=float(az.rhat(chains, method="rank")),
        ess_bulk=float(az.ess(chains, method="bulk")),
        ess_tail=float(az.ess(chains, method="tail", prob=TAILS)),
        mcse_mean=float(az.mcse(chains, method="mean")),
    )


def leave_one_out(log_likelihood: Array) -> LeaveOneOut:
    """Estimate the predictive density by Pareto-smoothed importance sampling, leaving out one point at a time.

    Parameters
    ----------
    log_likelihood
        Log density of every point, shape (n_chains, n_draws, n_points).

    Returns
    -------
    LeaveOneOut
        Sum over the points, with the Pareto shape of each.

    References
    ----------
    Vehtari, Gelman & Gabry, Practical Bayesian model evaluation using leave-one-out cross-validation and WAIC, 2017.
    """
    groups = {"posterior": {"draw_weight": log_likelihood.sum(axis=-1)}, "log_likelihood": {"y": log_likelihood}}
    data = _data_of(groups)
    # A shape of the Pareto fit that the draws rule out has the weight 1/exp(large) = 0.
    with warnings.catch_warnings(), np.errstate(over="ignore"):
        warnings.simplefilter("ignore", UserWarning)  # large Pareto k are reported, not warned of
        found = az.loo(data, pointwise=True)
    return LeaveOneOut(
        elpd=float(found.elpd_loo if BEFORE_1 else found.elpd),
        std=float(found.se),
        effective=float(found.p_loo if BEFORE_1 else found.p),
        pareto_k=np.asarray(found.pareto_k, dtype=np.float64),
    )


def read_netcdf(path: Path) -> Any:
    """Read an ArviZ file into memory.

    Parameters
    ----------
    path
        File that `write_netcdf` wrote.

    Returns
    -------
    arviz.InferenceData, or xarray.DataTree of ArviZ 1
        It does not need the file any more.
    """
    data = az.from_netcdf(str(path), engine="h5netcdf")
    data.load()
    data.close()
    return data


def write_netcdf(
    path: Path, groups: Mapping[str, Mapping[str, Array]], *, dims: Mapping[str, list[str]],
    coords: Mapping[str, list[Any]], attributes: Mapping[str, Any],
) -> Path:  # fmt: skip
    """Write groups of named arrays as an ArviZ file, whole or not at all.

    Parameters
    ----------
    path
        File to write.
    groups
        Arrays by group and name, shape (n_chains, n_draws, …).
    dims, coords
        Dimensions of the arrays by name, and coordinates of the dimensions.
    attributes
        Attributes of the file. The time of writing is left out, so that the same posterior gives the same content.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    data = _data_of(groups, dims=dict(dims), coords=dict(coords))
    for name in groups:
        data[name].attrs = {key: value for key, value in data[name].attrs.items() if key != "created_at"}
    data.attrs = dict(attributes)
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, suffix=".nc")
    os.close(descriptor)
    data.to_netcdf(temporary, engine="h5netcdf")
    content = Path(temporary).read_bytes()
    Path(temporary).unlink()
    return write_bytes(path, content)


def _data_of(groups: Mapping[str, Mapping[str, Array]], **named: Any) -> Any:
    """Return ArviZ's data of groups of arrays."""
    content = {name: dict(group) for name, group in groups.items()}
    return az.from_dict(**content, **named) if BEFORE_1 else az.from_dict(content, **named)
