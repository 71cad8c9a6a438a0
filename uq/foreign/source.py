"""The calibration that a posterior goes on from: folder of its results in, `Calibrated` out."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from haptid.identification.calibration.result_json import CAMPAIGN, MODEL
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.measurement.values.run import Array
from haptid.model.equations.quantity import Quantity
from haptid.support.command import word_command
from haptid.support.errors import InputError
from haptid.support.files.files import read_json
from haptid.uq.thresholds import THRESHOLDS

FILE = "identification.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """A calibration, read from its files.

    Parameters
    ----------
    campaign
        Its campaign, read again.
    values
        Estimates by variable.
    covariance
        Covariance of the free parameters in their units, shape (n_free, n_free).
    correlation_time
        Correlation time of the residuals [rows].
    """

    campaign: ForeignCampaign
    values: Mapping[str, float]
    covariance: Array
    correlation_time: float


def holds_calibration(folder: Path | None) -> bool:
    """Whether a folder holds the results of a calibration: an ``identification.json`` that names an FMU.

    Parameters
    ----------
    folder
        Folder to look into, or None.

    Returns
    -------
    bool
        False for None, for a folder without the file, and for a folder with a ``campaign.toml``.

    Raises
    ------
    InputError
        Where ``identification.json`` cannot be read.
    """
    if folder is None or not (folder / FILE).is_file() or (folder / "campaign.toml").is_file():
        return False
    return MODEL in read_json(folder / FILE, "an identification.json")


def read_calibrated(folder: Path) -> Calibrated:
    """Read the results of a calibration and its campaign.

    Parameters
    ----------
    folder
        Folder of the results.

    Returns
    -------
    Calibrated

    Raises
    ------
    InputError
        Where there are no such results, campaign or FMU are no longer where they were, or another FMU lies there.
    """
    path, todo = folder / FILE, f"repeat {word_command('identify', 'identification.run')}"
    data = read_json(path, "an identification.json")
    try:
        (one,) = data["configurations"]
        source, model = folder / data[CAMPAIGN], folder / data[MODEL]
        digest, tau = data["model_sha256"], float(one["residual_correlation_rows"])
        values = {name: float(entry["value"]) for name, entry in one["parameters"].items()}
        covariance = np.array(one["covariance"], dtype=float).reshape(len(one["free"]), len(one["free"]))
    except (KeyError, TypeError, ValueError):
        raise InputError(str(path), expected="the results of an FMU's calibration", got="others", todo=todo) from None
    where = f"{path}: {MODEL}"
    if not model.is_file():
        raise InputError(where, expected="the FMU", got=f"no file {model}", todo=todo)
    if hashlib.sha256(model.read_bytes()).hexdigest() != digest:
        raise InputError(where, expected="the FMU that was calibrated", got="another one", todo=todo)
    campaign = read_foreign_campaign(source, model)
    if set(campaign.parameters) != set(values):
        got = ", ".join(campaign.parameters) or "none"
        raise InputError(str(path), expected=f"the parameters {', '.join(values)}", got=got, todo=todo)
    return Calibrated(campaign=campaign, values=values, covariance=covariance, correlation_time=tau)


def with_finite_bounds(
    quantities: tuple[Quantity, ...], values: Mapping[str, float], std: Mapping[str, float]
) -> tuple[Quantity, ...]:
    """Give parameters without a bound one that is many standard deviations from the estimate.

    Parameters
    ----------
    quantities
        Parameters of the campaign.
    values, std
        Estimates, and standard deviations of the free ones, by variable.

    Returns
    -------
    tuple of Quantity
        Their flat prior has a finite width; fixed parameters stay.
    """
    made = []
    for q in quantities:
        if q.fixed:
            made.append(q)
            continue
        reach = THRESHOLDS.reach_of_open_bound_in_std * max(std[q.structured], 1e-12 * abs(values[q.structured]))
        estimate = values[q.structured]
        lower = q.lower if math.isfinite(q.lower) else min(q.initial, estimate - reach)
        upper = q.upper if math.isfinite(q.upper) else max(q.initial, estimate + reach)
        made.append(q.but(lower=lower, upper=upper))
    return tuple(made)
