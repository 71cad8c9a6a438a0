"""Physically consistent links: `Device` and measured coefficients in, `LinkEstimates` out, by semidefinite programming.

minimise  Σ ‖R^{-1/2} (A π − y)‖² + ‖S⁻¹ (π − π₀)‖²   subject to, for every link, the pseudo-inertia
J = [[½ tr(L) 1 − L, h], [hᵀ, m]] ⪰ 0, and rotor inertias ≥ 0, with π₀ the device's first guesses.
J ⪰ 0 says that some distribution of mass has these parameters: positive mass, triangle inequalities (Wensing, Kim &
Slotine 2018). S Sᵀ is the prior covariance of π; R the measured covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import NDArray

from haptid.identification.thresholds import THRESHOLDS
from haptid.model.device.device import STANDARD, Device
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.inertial_parameters import pi_jacobian, pi_prior, standard_ids, standard_std, to_standard
from haptid.model.rigid_body.standard_parameters import find_contained
from haptid.support.errors import NumericalError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Estimate of one link parameter.

    Parameters
    ----------
    value, std
        Value and standard deviation.
    unit
        Unit of both.
    status
        ``identified`` where the data at least halved the prior standard deviation, and would with all priors
        `THRESHOLDS.widening_of_link_priors` times as wide; ``unidentifiable`` where they did not, as of a mass that the
        data know times its centroid alone; ``prior`` where no measured coefficient contains the parameter, ``fixed``
        where it has no prior deviation.
    """

    value: float
    std: float
    unit: str
    status: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkEstimates:
    """Physically consistent links.

    Parameters
    ----------
    links
        Estimate by link and parameter of `STANDARD`; motors as ``motor_<name>`` with ``J``.
    standard
        Values of the full model's standard parameters by id.
    pi
        Inertial parameters π, shape (n_pi,).
    misfit
        (A π − y)/σ of every measured coefficient, shape (n_coefficients,) by configuration.
    """

    links: dict[str, dict[str, Estimate]]
    standard: dict[str, float]
    pi: Array
    misfit: tuple[Array, ...]


def consistent_links(device: Device, measurements: Sequence[Measurement]) -> LinkEstimates:
    """Estimate physically consistent links from measured coefficients and first guesses.

    Parameters
    ----------
    device
        Device with first guesses and prior standard deviations of its links.
    measurements
        Measured coefficients of every configuration.

    Returns
    -------
    LinkEstimates
        Standard deviations are those of the Gaussian belief without the constraints, and at most the prior's.

    Raises
    ------
    NumericalError
        Where the solver finds no optimum.
    """
    first = LinkBelief.from_device(device)
    belief = _updated(first, measurements)
    widening = THRESHOLDS.widening_of_link_priors
    wide = _updated(LinkBelief(mean=first.mean, covariance=widening**2 * first.covariance), measurements)
    pi = _nearest_consistent(device, belief, measurements)
    standard = to_standard(device, pi)
    jacobian = np.linalg.inv(pi_jacobian(device, standard))
    std, loose = (np.sqrt(np.maximum(np.diag(jacobian @ one.covariance @ jacobian.T), 0.0)) for one in (belief, wide))
    return LinkEstimates(
        links=_table(device, standard, std, loose, measurements),
        standard=dict(zip(standard_ids(device), standard.tolist(), strict=True)),
        pi=pi,
        misfit=tuple((one.rows @ pi - one.values) / np.sqrt(np.diag(one.covariance)) for one in measurements),
    )


def _updated(belief: LinkBelief, measurements: Sequence[Measurement]) -> LinkBelief:
    for one in measurements:
        belief = belief.update(one.coefficients, one.values, one.covariance)
    return belief


def _scales(device: Device, pi: Array) -> Array:
    """Return units in which every link is of order one: its mass, and its radius of gyration."""
    scales = np.abs(pi) + 1e-12
    for i in range(0, 10 * len(device.massive), 10):
        m = pi[i]
        length = np.sqrt(pi[i + 4 : i + 7].sum() / m)
        scales[i : i + 10] = m * np.array([1.0, *(length,) * 3, *(length**2,) * 6])
    return scales


def _nearest_consistent(device: Device, belief: LinkBelief, measurements: Sequence[Measurement]) -> Array:
    mean, covariance = pi_prior(device)
    scales = _scales(device, mean)
    # In units of each link's own size: the solver's tolerances and `THRESHOLDS.least_eigenvalue_of_pseudo_inertia` then
    # mean the same for every link.
    x = cp.Variable(mean.size)
    known = np.diag(covariance) <= 0
    prior = _root(covariance / np.outer(scales, scales))
    cost = cp.sum_squares(prior @ (x - mean / scales))
    for one in measurements:
        # Standard deviations are taken out first: the cut of eigenvalues in `_root` must not depend on units.
        sigma = np.sqrt(np.diag(one.covariance))
        whitened = _root(one.covariance / np.outer(sigma, sigma)) / sigma
        cost += cp.sum_squares((whitened @ (one.rows * scales)) @ x - whitened @ one.values)
    constraints = [x[np.flatnonzero(known)] == (mean / scales)[known]] if known.any() else []
    n = 10 * len(device.massive)
    least = THRESHOLDS.least_eigenvalue_of_pseudo_inertia * np.eye(4)
    for first in range(0, n, 10):
        pseudo_inertia = cp.bmat(_rows_of_pseudo_inertia([x[first + k] for k in range(10)]))
        constraints.append(pseudo_inertia >> least)
    constraints += [x[n:] >= 0] if mean.size > n else []
    x.value = belief.mean / scales
    problem = cp.Problem(cp.Minimize(cost), constraints)
    problem.solve(solver=cp.CLARABEL)
    if problem.status not in ("optimal", "optimal_inaccurate") or x.value is None:
        msg = f"no physically consistent links found: the solver says {problem.status}"
        raise NumericalError(msg)
    return np.asarray(x.value * scales)


def _root(covariance: Array) -> Array:
    """Return W with WᵀW = covariance⁻¹; directions without variance get no weight."""
    values, vectors = np.linalg.eigh(covariance)
    kept = values > 1e-13 * values[-1]
    return np.asarray((vectors[:, kept] / np.sqrt(values[kept])).T)


def pseudo_inertia(values: Sequence[float]) -> Array:
    """Build the pseudo-inertia of one link.

    Parameters
    ----------
    values
        Mass m [kg], first moments h [kg m], and the inertia tensor L about the frame's origin [kg m²] as L11, L22, L33,
        L12, L13, L23.

    Returns
    -------
    ndarray, shape (4, 4)
        J = [[½ tr(L) 1 − L, h], [hᵀ, m]].
    """
    return np.array(_rows_of_pseudo_inertia(values))


def _rows_of_pseudo_inertia(values: Sequence[Any]) -> list[list[Any]]:
    """Return the entries of J by row, of numbers or of the solver's expressions."""
    m, hx, hy, hz, L11, L22, L33, L12, L13, L23 = values
    half = (L11 + L22 + L33) / 2
    return [
        [half - L11, -L12, -L13, hx],
        [-L12, half - L22, -L23, hy],
        [-L13, -L23, half - L33, hz],
        [hx, hy, hz, m],
    ]


def _table(
    device: Device, standard: Array, std: Array, loose: Array, measurements: Sequence[Measurement]
) -> dict[str, dict[str, Estimate]]:
    measured = find_contained(device, (coefficient.exact for one in measurements for coefficient in one.coefficients))
    prior = standard_std(device)
    units = [*(("kg", "m", "m", "m", *("kg m^2",) * 6) * len(device.massive)), *("kg m^2",) * len(device.motors)]
    owners = [(link.name, key) for link in device.massive for key in STANDARD]
    owners += [(f"motor_{motor.name}", "J") for motor in device.motors]
    result: dict[str, dict[str, Estimate]] = {}
    for k, ((owner, key), name) in enumerate(zip(owners, standard_ids(device), strict=True)):
        # Wide priors never narrow a parameter more than the stated ones, up to rounding.
        status = _status(float(max(std[k], loose[k])), float(prior[k]), name in measured)
        result.setdefault(owner, {})[key] = Estimate(
            value=float(standard[k]), std=float(min(std[k], prior[k])), unit=units[k], status=status
        )
    return result


def _status(std: float, prior: float, measured: bool) -> str:
    if prior == 0:
        return "fixed"
    if not measured:
        return "prior"
    return "identified" if std < prior / 2 else "unidentifiable"
