"""The whole device from its fitted configurations: `Device` and `Step`s in, `Whole` with values and draws out.

1. Estimate physically consistent links from the coefficients of all configurations (`consistent_links`).
2. Condition springs and friction on the links: where consistent links move a coefficient by Δc from its fitted value,
   the other parameters p of that fit move by C_pc·C_cc⁻¹·Δc, with the covariance C_pp − C_pc·C_cc⁻¹·C_cp; those on a
   logarithmic scale by that over their value, in their logarithm, and by a factor of e at most. A value that the runs
   do not tell, alone or with others, stays as it is.
3. Draw inertial parameters from their belief (`physical_draws`), and springs and friction conditioned on each draw.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.links.consistent_links import LinkEstimates, consistent_links
from haptid.identification.links.physical_draws import physical_draws
from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import TOLD_AS_UNCERTAIN
from haptid.identification.sequence.sequence import joint_values, links_of
from haptid.identification.sequence.step import Step
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.device.device import Device
from haptid.model.equations.quantity import Quantity
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.inertial_parameters import standard_ids, to_standard
from haptid.support.linear_algebra import correlation_of, symmetric_inverse


@dataclass(frozen=True, slots=True, kw_only=True)
class Whole:
    """Parameters of the full model.

    Parameters
    ----------
    values
        Values by id.
    draws
        Draws of the values from their uncertainty, by id.
    links
        Physically consistent links.
    """

    values: Mapping[str, float]
    draws: tuple[Mapping[str, float], ...]
    links: LinkEstimates


def whole_device(
    device: Device, steps: Sequence[Step], *, seed: int = 0, draws: int = THRESHOLDS.draws_of_whole_device
) -> Whole:
    """Combine all configurations to the parameters of the full model.

    Parameters
    ----------
    device
        Device of the campaign.
    steps
        Fitted configurations in their order.
    seed
        Seed of the draws.
    draws
        Number of draws.

    Returns
    -------
    Whole
        Springs and friction of a joint are those of the last configuration that fitted them, and of those at the noise
        where there are any: what a model lacks may have moved the values of the others.

    Raises
    ------
    NumericalError
        Where no physically consistent links are found.
    """
    measured = links_of(tuple(steps), device)
    links = consistent_links(device, [one for one in measured if one.coefficients])
    belief = LinkBelief.from_device(device)
    for one in measured:
        if one.coefficients:
            belief = belief.update(one.coefficients, one.values, one.covariance)
    rng = np.random.default_rng([seed, 23])
    drawn = [
        _inertial(device, pi) | _joints(steps, measured, pi, rng)
        for pi in physical_draws(device, belief, links.pi, draws, rng)
    ]
    values = dict(links.standard) | _joints(steps, measured, links.pi, None)
    return Whole(values=values, draws=tuple(drawn), links=links)


def _inertial(device: Device, pi: Array) -> dict[str, float]:
    return dict(zip(standard_ids(device), to_standard(device, pi).tolist(), strict=True))


def _joints(
    steps: Sequence[Step], measured: Sequence[Measurement], pi: Array, rng: np.random.Generator | None
) -> dict[str, float]:
    """Return springs and friction by id with the joint's number, given π; drawn where rng is given."""
    result: dict[str, float] = {}
    # In the order of the fits, those whose values are uncertain first: a later one replaces the values before it.
    pairs = zip(steps, measured, strict=True)
    for step, one in sorted(pairs, key=lambda pair: pair[0].fit.outcome not in TOLD_AS_UNCERTAIN):
        result |= joint_values(step.configuration.free_joints, _condition_on(step, one, pi, rng))
    return result


def _condition_on(step: Step, one: Measurement, pi: Array, rng: np.random.Generator | None) -> dict[str, float]:
    """Condition the other parameters of a fit on its coefficients at π; draw them where rng is given."""
    fit = step.fit
    known = [fit.free.index(c.id) for c in one.coefficients]
    rest = [k for k in range(len(fit.free)) if k not in known]
    # Correlations instead of covariances: the cut of the pseudo-inverse must not depend on the parameters' units.
    C, std = correlation_of(fit.covariance)
    shift, left = np.zeros(len(rest)), C[np.ix_(rest, rest)]
    if known:
        change = (one.rows @ pi - [fit.values[c.id] for c in one.coefficients]) / std[known]
        gain = C[np.ix_(rest, known)] @ symmetric_inverse(C[np.ix_(known, known)], 1e-10)
        shift, left = gain @ change, left - gain @ C[np.ix_(known, rest)]
    if rng is None:
        shift = np.where(_told(fit, [fit.free[k] for k in rest]), shift, 0.0)
    else:
        values, vectors = np.linalg.eigh(left)
        shift = shift + vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(len(rest)))
    moved = {}
    for k, d in zip(rest, shift, strict=True):
        q = fit.equations.parameter(fit.free[k])
        moved[q.id] = _moved(q, fit.values[q.id], float(std[k] * d))
    return restore_orderings(fit.values | moved, fit.equations.orderings, moved)


def _told(fit: Fit, ids: Sequence[str]) -> list[bool]:
    """Say which values the runs tell, alone or in a combination: a shift of the others follows correlations of nothing.

    Stiction that is not seen would come back as a stiction, by the correlation with a coefficient.
    """
    combined = {id for one in fit.combinations for id in one.coefficients}
    return [fit.statuses[id] != "unidentifiable" or id in combined for id in ids]


def _moved(q: Quantity, value: float, change: float) -> float:
    """Move a fitted value by a change that a covariance tells, on the parameter's scale, within its bounds.

    On a logarithmic scale a change of −2 values of a hardly known one is no negative stiffness. Beyond a factor of e a
    covariance about the optimum says nothing: a stiffness that is too high to be seen is not as likely to be near zero.
    """
    moved = value * np.exp(np.clip(change / value, -1.0, 1.0)) if q.scale == "log" else value + change
    return float(np.clip(moved, q.lower, q.upper))


def restore_orderings(
    values: Mapping[str, float], orderings: Iterable[tuple[str, str]], moved: Collection[str]
) -> dict[str, float]:
    """Restore the orderings of pairs of parameters.

    Parameters
    ----------
    values
        Values by id.
    orderings
        Pairs of ids whose first value must not be below the second.
    moved
        Ids of values that may change; in a pair that is out of order, the first is raised where it is among these,
        otherwise the second is lowered.

    Returns
    -------
    dict
        Values by id, in order.

    Examples
    --------
    >>> restore_orderings({"Fs": 1.0, "Fc": 1.1}, [("Fs", "Fc")], moved=["Fs", "Fc"])
    {'Fs': 1.1, 'Fc': 1.1}
    """
    result = dict(values)
    for larger, smaller in orderings:
        if result[larger] < result[smaller]:
            kept, gives = (smaller, larger) if larger in moved else (larger, smaller)
            result[gives] = result[kept]
    return result
