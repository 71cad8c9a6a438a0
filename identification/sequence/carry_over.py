"""Results of earlier configurations in the next one: `Equations` and `LinkBelief` in, `Equations` with priors out.

Coefficients of different configurations are linear in the same inertial parameters π: a Gaussian over π (`LinkBelief`)
is updated with the data of one test alone and predicts the coefficients of the next, as priors. Springs and friction of
a joint start at the estimates of the joint's own test; they get no prior from it, so that the coupled test is free to
disagree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.model.rigid_body.locked_dynamics import Coefficient
from haptid.support.linear_algebra import inverse, profile_out


def carry_over(
    equations: Equations,
    belief: LinkBelief,
    coefficients: Sequence[Coefficient],
    found: Mapping[str, float],
    stated: Sequence[str] = (),
) -> Equations:
    """Set priors of the coefficients from the belief, and first guesses from earlier fits.

    Parameters
    ----------
    equations
        Equations of the next configuration.
    belief
        Gaussian belief over π from the earlier configurations.
    coefficients
        Coefficients of the next configuration, linear in π.
    found
        Values by id of joint parameters that earlier configurations fitted.
    stated
        Ids with an entry in the campaign, which stay as they are.

    Returns
    -------
    Equations
        With the prior N(A·π, `THRESHOLDS.carried_std_over_belief_std`²·A·P·Aᵀ) of each coefficient, no wider than its
        prior before.
    """
    changes: dict[str, dict[str, object]] = {}
    if coefficients:
        mean, covariance = belief.predict(coefficients)
        for coefficient, m, variance in zip(coefficients, mean, np.diag(covariance), strict=True):
            quantity = equations.parameter(coefficient.id)
            if coefficient.id not in stated and not quantity.fixed and variance > 0:
                changes[coefficient.id] = _prior(
                    quantity, float(m), THRESHOLDS.carried_std_over_belief_std * float(np.sqrt(variance))
                )
    for id, value in found.items():
        if id not in stated and any(q.id == id and not q.fixed for q in equations.parameters):
            q = equations.parameter(id)
            changes[id] = {"initial": float(np.clip(value, q.lower, q.upper))}
    return equations.with_parameters(changes)


def _prior(q: Quantity, mean: float, std: float) -> dict[str, object]:
    if q.prior is not None:
        std = min(std, q.prior.std)
    return {"initial": float(np.clip(mean, q.lower, q.upper)), "prior": Normal(mean=mean, std=std, source="earlier")}


def measurement_of(fit: Fit, coefficients: Sequence[Coefficient]) -> Measurement:
    """Remove the priors from the estimates of a fit's coefficients.

    Parameters
    ----------
    fit
        Fit with estimates, information of the data, and priors.
    coefficients
        Coefficients of the configuration; those that were not fitted are left out.

    Returns
    -------
    Measurement
        Values y, shape (n,), and covariance I⁻¹, shape (n, n), from the data alone.

    Notes
    -----
    With I the data's information about the coefficients (all other parameters profiled) and P⁻¹ that of the priors, the
    estimate θ obeys I·(θ − y) = −P⁻¹·(θ − m), hence y = θ + I⁻¹·P⁻¹·(θ − m).
    """
    chosen = [c for c in coefficients if c.id in fit.free]
    places = [fit.free.index(c.id) for c in chosen]
    information = profile_out(fit.information, places)
    quantities = [fit.equations.parameter(c.id) for c in chosen]
    prior = np.array([1.0 / q.prior.std**2 if q.prior else 0.0 for q in quantities])
    mean = np.array([q.prior.mean if q.prior else 0.0 for q in quantities])
    theta = np.array([fit.values[c.id] for c in chosen])
    floor = THRESHOLDS.least_information_over_prior * np.array(
        [1.0 / c.prior_std**2 if c.prior_std > 0 else 1e-12 for c in chosen]
    )
    # The fit has divided its information by this product: the prior's information is divided alike.
    inflated = max(fit.cost, 1.0) * max(fit.correlation_time, 1.0)
    covariance = inverse(information + np.diag(floor))
    values = theta + covariance @ (prior / inflated * (theta - mean))
    return Measurement(coefficients=tuple(chosen), values=values, covariance=covariance)
