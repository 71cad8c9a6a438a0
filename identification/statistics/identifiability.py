"""Identifiability: estimates and their information in, status of every parameter and identifiable combinations out.

A parameter is ``identified`` where its standard deviation is at most half of its size: of 1 for a logarithm (50 %), of
its value otherwise. Gravity and spring may also be known to be small: where one standard deviation changes the torque
by less than `THRESHOLDS.smallest_felt_share` of the largest torque, the parameter is identified whatever its value. A
parameter with a prior is ``prior`` where the data did not halve the prior's standard deviation; where they did, it is
identified or not like the others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Combination
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.support.linear_algebra import correlation_of, inverse, profile_out


def felt_sizes(parametrisation: Parametrisation, runs: Sequence[Run]) -> Array:
    """Compute the values at which gravity and spring would make up the largest torque of the runs.

    Parameters
    ----------
    parametrisation
        Free parameters.
    runs
        Runs of the fit, from torque to position or turned round (`torque_run`).

    Returns
    -------
    ndarray, shape (n_free,)
        The largest torque for gravity, over the travel for a spring's stiffness, and the travel for its equilibrium, in
        the parameter's unit; NaN for all others.
    """
    joints = parametrisation.equations.joints
    result = np.full(len(parametrisation.free), np.nan)
    # Equations that are solved for the torque have no joints: the position goes in and the torque comes out.
    for column, suffix in enumerate(id_suffixes(joints) or ("",)):
        torques, positions = ("u", "y") if joints else ("y", "u")
        torque = max(float(np.max(np.abs(getattr(run, torques)[:, column]))) for run in runs)
        # The torque of a free swing, zero throughout, is no size that gravity or a spring could be a share of.
        torque = torque or np.nan
        travel = max(float(np.ptp(getattr(run, positions)[:, column])) for run in runs)
        felt = {"gravity_cos": torque, "gravity_sin": torque, "Ks": torque / max(travel, 1e-300), "epos": travel}
        for id, size in felt.items():
            if f"{id}{suffix}" in parametrisation.ids:
                result[parametrisation.ids.index(f"{id}{suffix}")] = size
    return result


def known_sizes(parametrisation: Parametrisation, s: Array, felt: Array) -> Array:
    """Compute the scaled standard deviations up to which the free parameters are identified.

    Parameters
    ----------
    parametrisation
        Free parameters with their scales.
    s
        Scaled estimates, shape (n_free,).
    felt
        Values that would make up the largest torque, shape (n_free,), as `felt_sizes` returns them.

    Returns
    -------
    ndarray, shape (n_free,)
        Half of 1 for a logarithm. Otherwise half of |p|/w, but at least the felt size's share; half of max(|p|/w, 1)
        where the felt size is not known.
    """
    value = np.abs(parametrisation.physical(s)[list(parametrisation.free)]) / parametrisation.unit
    least = np.where(
        np.isfinite(felt),
        THRESHOLDS.smallest_felt_share * felt / parametrisation.unit,
        THRESHOLDS.largest_std_over_size,
    )
    linear = np.maximum(THRESHOLDS.largest_std_over_size * value, least)
    return np.where(parametrisation.log, THRESHOLDS.largest_std_over_size, linear)


def on_bound(parametrisation: Parametrisation, s: Array) -> Array:
    """Find the free parameters at a bound.

    Parameters
    ----------
    parametrisation
        Free parameters with their bounds.
    s
        Scaled estimates, shape (n_free,).

    Returns
    -------
    ndarray of bool, shape (n_free,)
        Whether the distance from a bound is at most `THRESHOLDS.largest_bound_distance_over_range` of the range.
    """
    lower, upper = parametrisation.bounds
    reach = THRESHOLDS.largest_bound_distance_over_range * np.where(np.isfinite(upper - lower), upper - lower, 0.0)
    return np.asarray((s - lower <= reach) | (upper - s <= reach))


def statuses(parametrisation: Parametrisation, s: Array, std: Array, felt: Array) -> dict[str, str]:
    """Judge whether every parameter is identifiable.

    Parameters
    ----------
    parametrisation
        Free parameters with their scales, bounds and priors.
    s
        Scaled estimates, shape (n_free,).
    std
        Scaled standard deviations, shape (n_free,).
    felt
        Values that would make up the largest torque, shape (n_free,), as `felt_sizes` returns them.

    Returns
    -------
    dict
        ``fixed``, ``at_bound``, ``prior``, ``unidentifiable`` or ``identified`` by id.
    """
    result = {q.id: "fixed" for q in parametrisation.equations.parameters if q.fixed}
    sizes = known_sizes(parametrisation, s, felt)
    lower, upper = parametrisation.bounds
    # Over a range of many decades, as that of a device file without limits, a share of it may be far from the bound.
    told_apart = np.minimum(s - lower, upper - s) > THRESHOLDS.standard_errors_of_interval * std
    edge = np.logical_and(on_bound(parametrisation, s), ~told_apart)
    theta = parametrisation.physical(s)
    slope = parametrisation.slope(theta)
    for k, q in enumerate(parametrisation.quantities):
        # A bound comes first: a standard deviation says nothing of a parameter that its bound holds.
        if edge[k]:
            result[q.id] = "at_bound"
        elif q.prior is not None and std[k] * slope[k] > THRESHOLDS.largest_std_over_prior_std * q.prior.std:
            result[q.id] = "prior"
        else:
            result[q.id] = "unidentifiable" if std[k] > sizes[k] else "identified"
    return result


def combinations(
    parametrisation: Parametrisation, s: Array, information: Array, status: dict[str, str], felt: Array
) -> tuple[Combination, ...]:
    """Find combinations that the data identify, of parameters that the data do not identify alone.

    Parameters
    ----------
    parametrisation
        Free parameters with their scales.
    s
        Scaled estimates, shape (n_free,).
    information
        Scaled Fisher information of the data, initial states marginalised, shape (n_free, n_free).
    status
        Status by id, as `statuses` returns it.
    felt
        Values that would make up the largest torque, shape (n_free,), as `felt_sizes` returns them.

    Returns
    -------
    tuple of Combination
        The best known first; the largest member has the coefficient 1.

    Notes
    -----
    1. Members are the unidentifiable parameters, those known from their prior, and those correlated with them.
    2. The information about the members, all others profiled, is scaled by the parameters' sizes: an eigenvalue above 1
       is a direction whose standard deviation is below the size that `known_sizes` asks for.
    3. Each such eigenvector of two to `THRESHOLDS.most_members_of_combination` components above
       `THRESHOLDS.least_component_of_combination` is a combination.
    """
    sizes = known_sizes(parametrisation, s, felt)
    H = information * np.outer(sizes, sizes)
    members = _members(parametrisation, H, status)
    if len(members) < 2:
        return ()
    values, vectors = np.linalg.eigh(profile_out(H, members))
    theta = parametrisation.physical(s)[list(parametrisation.free)]
    slope = parametrisation.slope(parametrisation.physical(s))
    found = []
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        keep = np.abs(vector) > THRESHOLDS.least_component_of_combination
        if value > 1.0 and 1 < int(keep.sum()) <= THRESHOLDS.most_members_of_combination:
            row = vector / (sizes * slope)[members]
            lead = row[int(np.argmax(np.abs(vector)))]
            chosen = {parametrisation.ids[m]: float(c / lead) for m, c, k in zip(members, row, keep, strict=True) if k}
            total = float(sum(c * theta[parametrisation.ids.index(id)] for id, c in chosen.items()))
            found.append(Combination(coefficients=chosen, value=total, std=float(1.0 / np.sqrt(value) / abs(lead))))
    return tuple(found)


def _members(parametrisation: Parametrisation, H: Array, status: dict[str, str]) -> list[int]:
    """Return the unidentifiable parameters and those correlated with them above 0.95."""
    open_ones = [k for k, id in enumerate(parametrisation.ids) if status[id] in ("unidentifiable", "prior")]
    # H is singular where the data do not see a direction at all: the ridge keeps its correlations finite.
    covariance = inverse(H + 1e-9 * np.eye(len(H)))
    correlation = np.abs(correlation_of(covariance)[0])
    return [k for k in range(len(H)) if k in open_ones or any(correlation[k, o] > 0.95 for o in open_ones)]
