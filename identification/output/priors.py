"""Sentences on priors: `Fit` in; what a prior holds, what the runs contradict, and another inertia than stated, out."""

from __future__ import annotations

from collections.abc import Mapping

from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
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


def tell_unused_priors(fit: Fit) -> list[str]:
    """Say which stated priors were not used, because the plain model is the result.

    Parameters
    ----------
    fit
        Fit with its outcome.

    Returns
    -------
    list of str
        One sentence where the plain model is the result and a prior was stated; else none.
    """
    stated = [q.id for q in fit.equations.parameters if q.prior is not None and q.prior.source == "stated"]
    if fit.outcome is not Outcome.PLAIN or not stated:
        return []
    return [f"the plain model knows the runs alone: its values do not use the stated prior of {', '.join(stated)}"]


def tell_device_inertia(fit: Fit, device_inertia: float | None) -> list[str]:
    """Say that the runs show another inertia than the device's file gives.

    Parameters
    ----------
    fit
        Fit of a joint alone, with its statuses.
    device_inertia
        Inertia by the device's file [kg m²], [kg] for a prismatic joint; None where there is none to compare.

    Returns
    -------
    list of str
        One sentence where the inertia is identified and differs by at least `least_difference_from_device` of the
        file's and by `least_errors_from_device` of its standard deviations; else none.
    """
    if device_inertia is None or fit.statuses.get("inertia") != "identified":
        return []
    value, std = fit.values["inertia"], float(fit.std[fit.index("inertia")])
    least = max(
        THRESHOLDS.least_difference_from_device * abs(device_inertia), THRESHOLDS.least_errors_from_device * std
    )
    if abs(value - device_inertia) < least:
        return []
    unit = fit.equations.parameter("inertia").unit
    fitted = f"{plain(value, 3)} ± {plain(std)} {unit}"
    return [
        f"inertia {fitted} from the data, {plain(device_inertia, 3)} {unit} in the device file: look whether links, "
        "rotor and gear ratio are right there, and the torque's scale in the campaign"
    ]
