"""What keeps numbers that are none out of a posterior's files, and says early where the runs hold too little."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.identification.result.outcome import ROWS_PER_PARAMETER
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.support.errors import InputError, NumericalError
from haptid.uq.result.posterior import Posterior

TODO = "measure with more motion, or state priors or fixed values in campaign.toml"


def early_word(equations: Equations, runs: Sequence[Run], joint: int, folder: Path) -> str:
    """Say before any work that the runs hold few rows for the free parameters; ``''`` where they do not.

    ``folder`` is the campaign's.

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
    if rows >= ROWS_PER_PARAMETER * free:
        return ""
    return (
        f"joint {joint}: {rows} rows to fit for {free} free parameters, fewer than {ROWS_PER_PARAMETER} for each: "
        "sampling takes long, and much of the posterior will be its prior; measure longer, or fix parameters under "
        f"[joint.{joint}.parameters]"
    )


def check_finite(posterior: Posterior) -> Posterior:
    """Return a posterior whose parameters are numbers.

    Raises
    ------
    NumericalError
        With the parameters that are not.
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
    """Return what JSON holds, null for numbers that are none: a diagnostic of too few draws or cycles, say.

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
