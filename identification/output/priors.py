"""Sentences on priors: `Fit` in; what a prior holds, and what the runs contradict, out."""

from __future__ import annotations

from collections.abc import Mapping

from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.support.numbers import plain


def tell_priors(fit: Fit, names: Mapping[str, str] | None = None) -> list[str]:
    """Say which parameters a prior holds, and which stated priors the runs contradict.

    Parameters
    ----------
    fit
        Fit with its statuses.
    names
        What the parameters are called, by id; their ids where None.

    Returns
    -------
    list of str
        A sentence each for priors that were stated or carried over, and for restraints that nobody stated; one for each
        stated prior that lies farther away than `THRESHOLDS.largest_distance_from_prior_in_std`.
    """
    held: list[str] = []
    restrained: list[str] = []
    contradicted: list[str] = []
    for q in fit.equations.parameters:
        if q.fixed:
            continue
        name, prior = q.id if names is None else names[q.id], q.prior
        distance = abs(fit.values[q.id] - prior.mean) / prior.std if prior is not None else 0.0
        if prior is not None and prior.source == "stated" and distance > THRESHOLDS.largest_distance_from_prior_in_std:
            std = fit.std[fit.index(q.id)]
            value = plain(fit.values[q.id], 3) + (f" ± {plain(std)}" if std > 0 else "")
            contradicted.append(
                f"these runs contradict the stated prior of {name}: {value} {q.unit} lies {plain(distance)} of the "
                f"prior's standard deviations from {plain(prior.mean, 3)} ± {plain(prior.std)} {q.unit}; look "
                "whether the prior is right, else what the model lacks"
            )
        elif fit.statuses.get(q.id) == "prior":
            restraint = prior is not None and prior.source == "restraint"
            (restrained if restraint else held).append(name)
    said = [f"known from the prior more than from these runs: {', '.join(held)}"] if held else []
    if restrained:
        ids = ", ".join(restrained)
        said.append(f"left open by these runs and held near a usual value, though no prior was stated: {ids}")
    return said + contradicted
