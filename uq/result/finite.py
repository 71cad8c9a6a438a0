"""Guards of a posterior: a warning where the runs hold few rows, and no NaN or infinity in the files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.support.errors import InputError, NumericalError
from haptid.uq.result.posterior import Posterior

TODO = "measure with more motion, or state priors or fixed values in campaign.toml"


def early_word(equations: Equations, runs: Sequence[Run], joint: int, folder: Path) -> str:
    """Warn before any work where the runs hold few rows for the free parameters.

    Parameters
    ----------
    equations
        Equations of the free joint.
    runs
        Runs of the joint.
    joint
        Number of the joint.
    folder
        Folder of the campaign.

    Returns
    -------
    str
        The warning; ``''`` where the runs hold `THRESHOLDS.least_rows_per_parameter` rows for each free parameter.

    Raises
    ------
    InputError
        Where no parameter is free.
    """
    free = sum(not q.fixed for q in equations.parameters)
    if free == 0:
        where, todo = f"{folder / 'campaign.toml'}, joint.{joint}.parameters", "leave one free, with bounds or a prior"
        raise InputError(where, expected="a parameter whose posterior is wanted", got="all fixed", todo=todo)
    rows = sum(run.t.size for run in runs if run.use == "fit")
    if rows >= THRESHOLDS.least_rows_per_parameter * free:
        return ""
    return (
        f"joint {joint}: {rows} rows to fit for {free} free parameters, "
        f"fewer than {THRESHOLDS.least_rows_per_parameter} for each: "
        "sampling takes long, and much of the posterior will be its prior; measure longer, or fix parameters under "
        f"[joint.{joint}.parameters]"
    )


def check_finite(posterior: Posterior) -> Posterior:
    """Refuse a posterior whose summaries are not all finite.

    Parameters
    ----------
    posterior
        Posterior of a joint.

    Returns
    -------
    Posterior
        The same, unchanged.

    Raises
    ------
    NumericalError
        Where a mean, standard deviation, median or interval is not finite; it names the parameters.
    """
    lost = []
    for p in posterior.parameters:
        ends = [end for interval in p.intervals.values() for end in interval]
        if not np.isfinite([p.mean, p.std, p.median, *ends]).all():
            lost.append(p.id)
    if lost:
        named = ", ".join(lost[:4])
        msg = f"joint {posterior.joint}: the posterior of {named} is not finite: the runs do not determine it; {TODO}"
        raise NumericalError(msg)
    return posterior


def with_null(value: Any) -> Any:
    """Replace NaN and infinity by None, which JSON writes as null: a diagnostic of too few draws or cycles, say.

    Parameters
    ----------
    value
        Dicts, lists and tuples, nested, of numbers and text.

    Returns
    -------
    Any
        The same with lists for tuples.

    Examples
    --------
    >>> with_null({"ess": [float("nan"), 1.5], "tau": float("inf")})
    {'ess': [None, 1.5], 'tau': None}
    """
    if isinstance(value, dict):
        return {key: with_null(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [with_null(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
