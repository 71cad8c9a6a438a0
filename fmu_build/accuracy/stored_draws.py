"""Draws that stand beside an ``identification.json``: its content and folder in, `Draws` out.

The posterior is preferred where it was made from the same data; else the draws are those that the identification made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from haptid.fmu_build.accuracy.draws import COUNT, Array, Draws, read_draws
from haptid.support.errors import InputError
from haptid.support.files.files import is_file, read_json
from haptid.support.linear_algebra import correlation_of

POSTERIOR, DRAWS_OF_POSTERIOR = "posterior.json", "parameters_posterior.csv"
"""Files that the posterior leaves beside identification.json."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Known:
    """Hold what results say of the uncertainty of one model's parameters.

    Parameters
    ----------
    draws
        Draws of the parameters; None where the results have none.
    why
        Sentence that says why there are none; empty where there are.
    summary
        Entry ``{mean, std, median, intervals}`` by id where a posterior was sampled.
    correlation
        Ids of its rows, and the matrix; None where the draws' own has to do.
    """

    draws: Draws | None
    why: str = ""
    summary: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    correlation: tuple[tuple[str, ...], Array] | None = None


def file_of(folder: Path, name: str) -> Path:
    """Return the file that holds the draws of a model.

    Parameters
    ----------
    folder
        Folder of the results.
    name
        Name of the model's equations, as ``joint4`` or ``freedom6s``.

    Returns
    -------
    Path
        ``draws/<name>.csv``.
    """
    return folder / "draws" / f"{name}.csv"


def of_joint(data: Mapping[str, Any], joint: int, folder: Path | None) -> Known:
    """Return what results say of the parameters of one joint tested alone.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    joint
        Number of the joint.
    folder
        Folder of the results; None where they are in no file.

    Returns
    -------
    Known
        From the posterior where its data are those of the test.

    Raises
    ------
    InputError
        Where a file of draws is damaged.
    """
    test = next(c for c in data["configurations"] if list(c["free_joints"]) == [joint])
    posterior = None if folder is None else _posterior_of(folder, joint, test.get("data"))
    if folder is not None and posterior is not None:
        settled = "" if posterior.get("sound", True) else ", whose chains have not settled"
        source, path = f"posterior that haptid posterior sampled{settled}", folder / DRAWS_OF_POSTERIOR
        draws = read_draws(path, posterior["draws"], source=source, seed=posterior.get("seed"))
        return Known(
            draws=_first(draws, f"joint{joint}."),
            summary=posterior["parameters"],
            correlation=_correlation(posterior.get("correlation")),
        )
    known = _of_identification(data, f"joint{joint}", folder)
    covariance = np.array(test.get("covariance") or [])
    if known.draws is None or covariance.ndim != 2:
        return known
    return Known(draws=known.draws, correlation=(tuple(test["free"]), correlation_of(covariance)[0]))


def of_device(data: Mapping[str, Any], name: str, folder: Path | None) -> Known:
    """Return what results say of the parameters of the whole device.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    name
        Name of the device's equations.
    folder
        Folder of the results; None where they are in no file.

    Returns
    -------
    Known
        From the draws that the identification made.

    Raises
    ------
    InputError
        Where a file of draws is damaged.
    """
    return _of_identification(data, name, folder)


def _of_identification(data: Mapping[str, Any], name: str, folder: Path | None) -> Known:
    told = data.get("draws", {}).get(name)
    if told is None:
        return Known(draws=None, why="the results hold no draws: haptid identify makes them")
    if folder is None or not is_file(file_of(folder, name)):
        return Known(draws=None, why=f"draws/{name}.csv does not lie beside identification.json")
    draws = read_draws(file_of(folder, name), told["digest"], source=told["source"], seed=told.get("seed"))
    return Known(draws=draws)


def _posterior_of(folder: Path, joint: int, data: str | None) -> Mapping[str, Any] | None:
    """Return a joint's entry of posterior.json; None where there is none of the same data."""
    if data is None or not is_file(folder / POSTERIOR) or not is_file(folder / DRAWS_OF_POSTERIOR):
        return None
    try:
        content = read_json(folder / POSTERIOR, "a posterior.json")
    except InputError:  # half written or of another program: the identification's own draws do
        return None
    for entry in content.get("joints", []):
        if entry.get("joint") == joint and entry.get("data") == data and "draws" in content:
            return {**entry, "draws": content["draws"], "seed": content.get("seed")}
    return None


def _correlation(told: Mapping[str, Any] | None) -> tuple[tuple[str, ...], Array] | None:
    """Return the correlation that a posterior states; None where it states none, or a chain stood still."""
    matrix = np.array([] if told is None else told["matrix"], dtype=np.float64)  # null becomes NaN
    return None if told is None or not np.isfinite(matrix).all() else (tuple(told["ids"]), matrix)


def _first(draws: Draws, prefix: str) -> Draws:
    """Return the first draws of the columns with a prefix that vary, as many as an FMU carries."""
    varies = np.ptp(draws.values, axis=0) > 0
    own = draws.keep({c for c, moves in zip(draws.columns, varies, strict=True) if moves and c.startswith(prefix)})
    return Draws(columns=own.columns, values=own.values[:COUNT], source=own.source, seed=own.seed)
