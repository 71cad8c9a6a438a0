"""Tell certain names in a residual torque from doubted ones: `TorqueFit` in, shares of bags and keys out.

An effect that predicts better is needed, but need not be what the joint has. Its name is doubted where

1. few stretches of the runs ask for it: it keeps its name in a small share of the bags (`fit.stability`);
2. a parameter that decides it lies on the end of its range: another form would fit better. These are its own, and for
   an effect that bends the Stribeck curve the Stribeck velocity.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from haptid.discrepancy.fit.stability import Stretches, cut_runs, stability_of
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.identification.statistics.identifiability import on_bound
from haptid.model.effects.effect import Effect
from haptid.model.friction.registry import law_named

STRIBECK_SLOTS = frozenset({"stribeck_velocity", "stribeck_argument"})
"""Slots of a friction law in which an effect bends the Stribeck curve."""


def compute_stability(model: TorqueFit, *, seed: int = 0) -> dict[str, float]:
    """Compute the share of bags of fitted stretches in which each effect keeps its name.

    Parameters
    ----------
    model
        Model with its effects.
    seed
        Seed of the bags.

    Returns
    -------
    dict
        Share [1] by key of the effect.
    """
    return stability_of(_cut_into_stretches(model), model.effects, seed=seed)


def find_doubted(model: TorqueFit, stability: Mapping[str, float]) -> frozenset[str]:
    """Find the effects whose names are not certain.

    Parameters
    ----------
    model
        Model with its effects.
    stability
        Share of bags in which an effect keeps its name, by its key; effects without one are not doubted for it.

    Returns
    -------
    frozenset of str
        Keys of these effects.
    """
    parametrisation = model.problem.parametrisation
    at_end = on_bound(parametrisation, parametrisation.to_coordinates(model.theta))
    ends = {id for id, there in zip(parametrisation.ids, at_end, strict=True) if there}
    least = THRESHOLDS.torque.least_stability_of_certain_name
    return frozenset(
        effect.key
        for effect in model.effects
        if stability.get(effect.key, 1.0) < least or ends & _deciding(model, effect)
    )


def _deciding(model: TorqueFit, effect: Effect) -> set[str]:
    """Return the ids of the parameters that decide what an effect does."""
    own = {q.id for q in effect.parameters}
    if not effect.friction_slots & STRIBECK_SLOTS:
        return own
    return own | {law_named(model.study.base.friction[0]).roles.stribeck_velocity}


def _cut_into_stretches(model: TorqueFit) -> Stretches:
    """Cut the fitted rows into stretches; correlated rows are counted by correlation lengths."""
    parametrisation = model.problem.parametrisation
    over_noise = model.weighted / float(model.study.runs[0].sensor_std[0])
    residuals, jacobians = cut_runs([over_noise], [model.jacobian])
    return Stretches(
        ids=parametrisation.ids,
        slope=parametrisation.slope(model.theta),
        values=model.values,
        residuals=residuals,
        jacobians=jacobians,
        independent=max(model.fitted.size / model.correlation_time, 2.0),
        prior=np.zeros(0),
        prior_jacobian=np.zeros((0, model.jacobian.shape[1])),
    )
