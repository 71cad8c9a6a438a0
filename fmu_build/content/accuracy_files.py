"""The files below ``extra/haptid`` of an FMU: `Interface` and `Accuracy` in, CSV and JSON out.

A host reads from them how good the model is, and steps the draws of its parameters beside the nominal model.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.fmu_build.accuracy.accuracy import Accuracy
from haptid.fmu_build.accuracy.draws import draws_text
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.provenance import Provenance
from haptid.fmu_build.description.variables import Variable
from haptid.support.files.files import json_text

Array = NDArray[np.float64]
FOLDER = "extra/haptid"
"""Place of the files within the archive (FMI 2.0.4, section 2.3: ``extra`` is for tools)."""
QUANTILES = (0.025, 0.25, 0.5, 0.75, 0.975)
"""Probabilities of the quantiles in parameters.csv."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownParameter:
    """Say how well one parameter of an FMU is known.

    Parameters
    ----------
    variable
        FMU variable; its start is the value.
    origin
        Where the value comes from.
    mean, std
        Mean and standard deviation in the variable's unit; None where unknown.
    quantiles
        Quantiles at `QUANTILES`, in the variable's unit; empty where nothing was drawn.
    """

    variable: Variable
    origin: Provenance
    mean: float | None
    std: float | None
    quantiles: tuple[float, ...]


def draws_of(interface: Interface, accuracy: Accuracy) -> tuple[tuple[Variable, ...], Array]:
    """Return the draws of the parameters that an FMU has.

    Parameters
    ----------
    interface
        Variables of the FMU.
    accuracy
        Draws by ids or FMU variable names.

    Returns
    -------
    variables : tuple of Variable
        Parameters that vary, in the order of the FMU.
    values : ndarray, shape (n_draws, n_variables)
        Draws in the variables' units; (0, 0) where there are none.
    """
    drawn = accuracy.known.draws
    if drawn is None:
        return (), np.zeros((0, 0))
    places = {column: k for k, column in enumerate(drawn.columns)}
    own = [v for v in interface.of_role("parameter") if v.id in places or v.name in places]
    columns = [places[v.id] if v.id in places else places[v.name] for v in own]
    return tuple(own), drawn.values[:, columns]


def known_parameters(
    interface: Interface, accuracy: Accuracy, origins: Mapping[str, Provenance]
) -> tuple[KnownParameter, ...]:
    """Return how well each parameter of an FMU is known.

    Parameters
    ----------
    interface
        Variables of the FMU.
    accuracy
        Draws, and the summary of a posterior where there is one.
    origins
        Provenance by id, for all parameters.

    Returns
    -------
    tuple of KnownParameter
        In the order of the FMU. Mean and standard deviation are the posterior's where one was sampled; else the mean
        is that of the draws, and the standard deviation that of the results.
    """
    variables, values = draws_of(interface, accuracy)
    columns = dict(zip((v.id for v in variables), values.T, strict=True))
    rows = []
    for v in interface.of_role("parameter"):
        drawn, origin = columns.get(v.id), origins[v.id]
        told = None if drawn is None else accuracy.known.summary.get(v.id)
        mean = None
        if told:
            mean = told["mean"]
        elif drawn is not None:
            mean = float(drawn.mean())
        rows.append(
            KnownParameter(
                variable=v,
                origin=origin,
                mean=mean,
                std=told["std"] if told else origin.std,
                quantiles=() if drawn is None else _quantiles(drawn, told),
            )
        )
    return tuple(rows)


def _quantiles(drawn: Array, told: Mapping[str, Any] | None) -> tuple[float, ...]:
    """Return the quantiles of the whole chains where the posterior states them, else those of the draws."""
    stated = {} if told is None else told.get("intervals", {})
    half, most = stated.get("0.5"), stated.get("0.95")
    if told is None or half is None or most is None:
        return tuple(np.quantile(drawn, QUANTILES).tolist())
    return (most[0], half[0], told["median"], half[1], most[1])


def accuracy_files(interface: Interface, accuracy: Accuracy, origins: Mapping[str, Provenance]) -> dict[str, bytes]:
    """Return the files below ``extra/haptid``.

    Parameters
    ----------
    interface
        Variables of the FMU.
    accuracy
        How good its values are.
    origins
        Provenance by id, for all parameters.

    Returns
    -------
    dict
        ``verification.json``, ``parameters.csv``, ``correlation.csv``, ``draws.csv``, ``effects.json`` and
        ``digests.json`` by name within the archive. Where nothing was drawn, two of them hold their header alone.
    """
    variables, values = draws_of(interface, accuracy)
    names = [v.name for v in variables]
    known, drawn = accuracy.known, accuracy.known.draws
    head = {"synthetic": accuracy.synthetic, "origin": accuracy.origin}
    about_draws = {
        "count": len(values),
        "source": known.why if drawn is None else drawn.source,
        "seed": None if drawn is None else drawn.seed,
    }
    verification = {"schema": "verification/1", **head, "draws": about_draws, "joints": list(accuracy.joints)}
    effects = {"schema": "effects/1", **head, "searched": accuracy.searched, "effects": list(accuracy.effects)}
    digests = {"schema": "digests/1", **head, "equations": interface.equations.digest, **accuracy.digests}
    correlation = _correlation(variables, values, accuracy)
    texts = {
        "verification.json": json_text(verification),
        "parameters.csv": _parameters(known_parameters(interface, accuracy, origins)),
        "correlation.csv": _table(["name", *names], ([n, *row] for n, row in zip(names, correlation, strict=True))),
        "draws.csv": draws_text(names, values),
        "effects.json": json_text(effects),
        "digests.json": json_text(digests),
    }
    return {f"{FOLDER}/{name}": text.encode() for name, text in texts.items()}


def _correlation(variables: Sequence[Variable], values: Array, accuracy: Accuracy) -> list[list[float]]:
    """Return the correlation as the results state it, else that of the draws, shape (n_variables, n_variables)."""
    stated = accuracy.known.correlation
    if not variables:
        return []
    if stated is not None and {v.id for v in variables} <= set(stated[0]):
        places = [stated[0].index(v.id) for v in variables]
        result = np.array(stated[1])[np.ix_(places, places)]
    else:
        std = values.std(axis=0)
        scaled = (values - values.mean(axis=0)) / np.where(std > 0, std, 1.0)
        result = scaled.T @ scaled / len(values)
    np.fill_diagonal(result, 1.0)  # rounding, and parameters that do not vary
    return [[float(x) for x in row] for row in result]


def _parameters(rows: Iterable[KnownParameter]) -> str:
    header = ["name", "value", "unit", "mean", "std", *(f"q{p:g}" for p in QUANTILES), "status", "source"]
    return _table(header, ([*_numbers(row), row.origin.status, row.origin.source] for row in rows))


def _numbers(row: KnownParameter) -> list[Any]:
    v = row.variable
    return [v.name, v.start, v.unit, row.mean, row.std, *(row.quantiles or [None] * len(QUANTILES))]


def _table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Write CSV; numbers keep their last bit, and None is an empty cell."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow([repr(x) if isinstance(x, float) else x for x in row])
    return stream.getvalue()
