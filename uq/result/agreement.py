"""Compare a posterior with the fit it starts from: `Fit` and summaries in, a sentence for the reader out.

Fit and chains see the same runs, so that their values of an identified parameter lie within a few standard deviations.
Where they do not, one of the two is in another minimum or has not come to rest, and neither interval can be trusted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import MODEL_DOES_NOT_FIT, Outcome
from haptid.support.numbers import plain, with_unit
from haptid.uq.result.summary import ParameterSummary
from haptid.uq.thresholds import THRESHOLDS


def word_disagreement(fit: Fit, parameters: Sequence[ParameterSummary]) -> str:
    """Name the parameters that the fit calls identified and in which the posterior contradicts it.

    Parameters
    ----------
    fit
        Fit that the chains start from.
    parameters
        Summaries of the posterior.

    Returns
    -------
    str
        One sentence; empty where |mean − estimate|/√(std² + std_fit²) is at most
        `THRESHOLDS.largest_distance_from_fit_in_std` for every identified parameter.
    """
    values, std = fit.values, fit.std
    found = []
    for one in parameters:
        # A fit that was made for the chains alone has no statuses.
        if one.id not in fit.free or fit.statuses.get(one.id, "identified") != "identified":
            continue
        value, error = values[one.id], float(std[fit.index(one.id)])
        if abs(one.mean - value) > THRESHOLDS.largest_distance_from_fit_in_std * float(np.hypot(one.std, error)):
            here = with_unit(f"{one.mean:.3g} ± {one.std:.2g}", one.unit)
            there = f"{value:.3g} ± {error:.2g}"
            found.append(f"{one.id} is {here} here and {there} there")
    if not found:
        return ""
    return (
        f"Posterior and fit contradict each other: {'; '.join(found)}. One of them is in another minimum, or the "
        "chains are too short: fit with more --starts before either is trusted."
    )


def word_misfit(fit: Fit) -> str:
    """Say that the model of a posterior does not fit, where the fit that it begins at says so.

    Parameters
    ----------
    fit
        Fit that the chains start from.

    Returns
    -------
    str
        One sentence; empty where the fit left the noise, and where it was made in another way, such as of the torque.
    """
    if fit.outcome in (Outcome.UNEXPLAINED, Outcome.UNEXCITED):
        return f"No interval of this model means anything: {fit.outcome.value}."
    if fit.outcome not in MODEL_DOES_NOT_FIT:
        return ""
    left = plain(float(np.sqrt(fit.cost)), 2)
    return (
        f"The model leaves {left} times the noise over all fitted runs. Intervals say how well the data tell a value "
        "in this model; what the model lacks may have moved values further. Look for it first: haptid missing."
    )
