"""Posteriors of single joints carried to the whole device: `Fit` and `Posterior` in, bands of its runs out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.result.fit import Fit
from haptid.identification.sequence.step import Step
from haptid.identification.sequence.whole_device import whole_device
from haptid.identification.verification.result import Verification
from haptid.identification.verification.verify import verify
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.uq.result.posterior import Posterior
from haptid.uq.thresholds import THRESHOLDS


def as_fit(fit: Fit, posterior: Posterior) -> Fit:
    """Return the fit with mean and covariance of the posterior in place of its own.

    Parameters
    ----------
    fit
        Fit of the joint, with the same free parameters.
    posterior
        Posterior of the joint.

    Returns
    -------
    Fit
        Copy of ``fit`` with the mean of all draws for the free parameters, and their sample covariance in its own
        order.
    """
    coordinates = posterior.mode.density.coordinates
    n = len(coordinates.free)
    values = coordinates.values(posterior.sample.flat())[:, :n]
    theta = np.array(fit.theta)
    for q, mean in zip(coordinates.free, values.mean(axis=0), strict=True):
        theta[fit.index(q.id)] = mean
    order = [[q.id for q in coordinates.free].index(id) for id in fit.free]  # the fit's order may differ from η's
    covariance = np.cov(values.T).reshape(n, n)[np.ix_(order, order)]
    return fit.but(theta=theta, covariance=covariance)


def full_model_bands(
    campaign: Campaign,
    device: Device,
    steps: Sequence[Step],
    *,
    seed: int = 0,
    draws: int = THRESHOLDS.draws_of_whole_device,
) -> Verification:
    """Simulate the validation runs with all joints free by draws of the whole device's parameters.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    device
        The device.
    steps
        One per joint, in locking order, each with a fit as `as_fit` returns it.
    seed
        Seed of the draws.
    draws
        Number of draws.

    Returns
    -------
    Verification
        Empty where a joint of the device has no posterior or where there is no run with all joints free.

    Raises
    ------
    InputError
        As `verify`.
    NumericalError
        Where no physically consistent links are found, or as `verify`.
    """
    if {j for step in steps for j in step.configuration.free_joints} != set(range(len(device.joints))):
        return Verification(runs=())
    whole = whole_device(device, steps, seed=seed, draws=draws)
    unseen = [run for run in campaign.runs if run.use == "validate"]
    return verify(device, whole.values, unseen, campaign.extra.get("controller"), draws=whole.draws)
