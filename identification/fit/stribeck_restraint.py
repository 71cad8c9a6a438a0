"""Restraint of stiction and Stribeck speed in a fit of the torque: `Equations` in, `Equations` out.

Along a motion that hardly creeps, a free Stribeck curve of a model that lacks something takes the Coulomb torque's
part: its speed rises to half of the top speed and Fc collapses, or Fs grows without bound. So the curve is held near
what friction has in general. A model that leaves noise without the restraint, and clearly less than with it, lacks
nothing that the curve could stand in for: the restraint is then dropped. So it is where it was what most of the
residual came from: a curve that stands in for something else takes a smaller part.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.model.friction.registry import law_named

RESTRAINT: Final = "restraint"
"""Source of the priors that hold the Stribeck curve."""


def restrain_stribeck(
    equations: Equations, runs: Sequence[Run], stated: Sequence[str], sliding: float = 0.0
) -> Equations:
    """Hold stiction and Stribeck speed near what friction has in general, as far as the data do not pay for more.

    Parameters
    ----------
    equations
        Equations of the joint, whose first guesses are those of the data.
    runs
        Runs that scale the speeds.
    stated
        Ids of the parameters that the user stated, which stay as they are.
    sliding
        Sliding friction of the plain model [N m]; the larger one of it and the first guess of Fc is F.

    Returns
    -------
    Equations
        With normal priors of Fs and vs, and with bounds Fs ≤ 3·F and vs ≤ 5 % of the top speed.
    """
    roles = law_named(equations.friction[0]).roles
    changes: dict[str, dict[str, object]] = {}
    if roles.stiction != roles.coulomb and roles.stiction not in stated:
        level = equations.parameter(roles.coulomb).initial
        mean = THRESHOLDS.stiction_prior_mean_over_coulomb * level
        changes[roles.stiction] = {
            "initial": mean,
            "upper": THRESHOLDS.largest_stiction_over_coulomb * max(level, sliding),
            "prior": Normal(mean=mean, std=THRESHOLDS.stiction_prior_std_over_coulomb * level, source=RESTRAINT),
        }
    if roles.stribeck_velocity and roles.stribeck_velocity not in stated:
        top = max(float(np.max(np.abs(filter_run(run).v))) for run in runs if run.use == "fit")
        usual = THRESHOLDS.stribeck_speed_over_top_speed * top
        changes[roles.stribeck_velocity] = {
            "initial": usual,
            "lower": usual / THRESHOLDS.stribeck_speed_over_least_speed,
            "upper": THRESHOLDS.largest_stribeck_speed_over_top_speed * top,
            "prior": Normal(mean=usual, std=usual, source=RESTRAINT),
        }
    return equations.with_parameters(changes)


def restrained_ids(equations: Equations) -> tuple[str, ...]:
    """Return the ids of the parameters that `restrain_stribeck` holds.

    Parameters
    ----------
    equations
        Equations of the joint.

    Returns
    -------
    tuple of str
        Empty where nothing is held: by a law without a Stribeck curve, or where the user states it.
    """
    return tuple(q.id for q in equations.parameters if isinstance(q.prior, Normal) and q.prior.source == RESTRAINT)


def release_stribeck(equations: Equations) -> Equations:
    """Drop the restraint of `restrain_stribeck`.

    Parameters
    ----------
    equations
        Equations with the restraint.

    Returns
    -------
    Equations
        Without its priors, vs free up to the top speed; a fit begins at the end of the restraint, because a curve that
        the restraint pressed flat, Fs = Fc, tells no speed. Fs ≤ 3·Fc stays.
    """
    changes: dict[str, dict[str, object]] = {}
    for id in restrained_ids(equations):
        upper = equations.parameter(id).upper
        changes[id] = {"prior": None}
        if id == law_named(equations.friction[0]).roles.stribeck_velocity:
            top = upper / THRESHOLDS.largest_stribeck_speed_over_top_speed
            changes[id] |= {"initial": upper, "upper": top}
    return equations.with_parameters(changes)


def pays_for_release(restrained: float, released: float, rows: float, parameters: int, *, leaves_noise: bool) -> bool:
    """Say whether a fit without the restraint leaves clearly less than one with it, and no more than noise or half.

    Parameters
    ----------
    restrained, released
        Mean square of the residual away from reversals over the noise [1] of both fits.
    rows
        Number of independent rows: these rows over the correlation time of the residual.
    parameters
        Number of parameters that are held.
    leaves_noise
        Whether the fit without it leaves no more than noise.

    Returns
    -------
    bool
        Whether n·(χ²₁ − χ²₂) > k·ln n, the penalty of k parameters by the Bayesian information criterion, and above
        the noise χ²₂ < `THRESHOLDS.largest_share_left_by_release`·χ²₁.
    """
    enough = leaves_noise or released < THRESHOLDS.largest_share_left_by_release * restrained
    return bool(enough and rows * (restrained - released) > parameters * np.log(max(rows, 1.0)))
