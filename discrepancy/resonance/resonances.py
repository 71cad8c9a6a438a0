"""Find effects that the frequency response shows, resonances above all: `Run`s and `Effect`s in, start values out.

A fit in time does not find a resonance: over a run of n periods its basin is a share 1/n wide in frequency, and a model
without the resonance bends inertia and friction far away. In the frequency response the resonance is a peak.

1. Estimate the frequency response of the runs (`measure_response`).
2. Fit the joint without effects: inertia, spring and viscous friction.
3. Fit it with each effect that has states of its own, from a grid over the ranges of its parameters.
4. Keep the effects that leave far less than the joint without them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product

import numpy as np
from scipy import optimize

from haptid.discrepancy.resonance.frequency_response import FrequencyResponse, measure_response
from haptid.discrepancy.resonance.linear_response import JOINT, LinearJoint, linearise
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect
from haptid.model.equations.quantity import Quantity

LEAST = np.finfo(np.float64).tiny


def find_resonances(
    runs: Sequence[Run], catalogue: Mapping[str, Effect], *, prismatic: bool
) -> dict[str, dict[str, float]]:
    """Return start values of the effects that the frequency response of the runs shows.

    Parameters
    ----------
    runs
        Fitted runs of one joint alone, torque in and position out.
    catalogue
        Catalogue effects by key, in SI units.
    prismatic
        Whether the joint is prismatic.

    Returns
    -------
    dict
        By the key of an effect, its parameters by id and the inertia beside them, in SI units. A form that is offered
        only where there is a resonance has those of the plain form.
    """
    measured = measure_response(runs)
    if measured is None or (alone := linearise(None, prismatic=prismatic)) is None:
        return {}
    least, fitted = _fit(alone, measured, _starts_alone(measured))
    found: dict[str, dict[str, float]] = {}
    for key, effect in catalogue.items():
        if not effect.states or effect.lives_in != "frequency" or effect.resonant_only:
            continue
        joint = linearise(effect, prismatic=prismatic)
        if joint is None or not _has_enough(measured, joint):
            continue
        left, values = _fit(joint, measured, _starts(joint, fitted))
        if left < THRESHOLDS.resonance.largest_share_left * least:
            both = zip(joint.ids, values.tolist(), strict=True)
            found[key] = {id: value for id, value in both if id not in JOINT[1:]}
    return found | {
        key: found[effect.id] for key, effect in catalogue.items() if effect.resonant_only and effect.id in found
    }


def offered(catalogue: Mapping[str, Effect], shown: Collection[str]) -> dict[str, Effect]:
    """Leave out the forms that ask for a resonance that the runs do not show.

    Parameters
    ----------
    catalogue
        Catalogue effects by key.
    shown
        Keys of the effects that `find_resonances` returned.

    Returns
    -------
    dict
        The others, by key.
    """
    return {key: effect for key, effect in catalogue.items() if key in shown or not effect.resonant_only}


def _has_enough(measured: FrequencyResponse, joint: LinearJoint) -> bool:
    return measured.omega.size >= THRESHOLDS.resonance.least_frequencies_per_parameter * len(joint.free)


def _starts_alone(measured: FrequencyResponse) -> list[Array]:
    """Return starts of the joint alone, shape (3,) each: from what inertia or friction alone would be."""
    omega, size = measured.omega, np.abs(measured.mobility)
    inertia, viscous = 1.0 / float(np.median(size * omega)), 1.0 / float(np.median(size))
    springs = (1e-6 * inertia * omega[0] ** 2, inertia * omega[0] ** 2, 0.1 * inertia * omega[-1] ** 2)
    masses, dampers = inertia * np.geomspace(0.1, 10.0, 7), viscous * np.geomspace(0.03, 3.0, 4)
    return [np.array(each) for each in product(masses, springs, dampers)]


def _starts(joint: LinearJoint, alone: Array) -> Iterator[Array]:
    """Yield starts with an effect: the joint as it is without it, and a grid over the effect's parameters."""
    n = len(JOINT)
    points = THRESHOLDS.resonance.points_of_parameter
    for own in product(*(np.geomspace(*_range(q), points + 2)[1:-1] for q in joint.free[n:])):
        yield np.array([*alone, *own])


def _range(q: Quantity) -> tuple[float, float]:
    """Return a range of a parameter that has a logarithm."""
    return max(q.lower, THRESHOLDS.resonance.least_share_of_range * q.upper), q.upper


def _fit(joint: LinearJoint, measured: FrequencyResponse, starts: Iterable[Array]) -> tuple[float, Array]:
    """Fit log H; return the robust mean square over the error, and the parameters, shape (n,).

    Parts of log H are the log of the size and the phase, so that a peak counts no more than the valley beside it.
    """
    wide = THRESHOLDS.resonance.widest_factor_of_joint
    starts = list(starts)
    ranges = [(x / wide, x * wide) for x in starts[0][: len(JOINT)]] + [_range(q) for q in joint.free[len(JOINT) :]]
    lower, upper = np.log(np.maximum(np.array(ranges), LEAST)).T

    def residual(x: Array) -> Array:
        log_ratio = np.log(joint.mobility(np.exp(x), measured.omega) / measured.mobility)
        return np.nan_to_num(
            np.concatenate([log_ratio.real, log_ratio.imag]) / np.tile(measured.relative_error, 2),
            nan=1e3, posinf=1e3, neginf=-1e3,
        )  # fmt: skip

    inside = [np.clip(np.log(np.maximum(start, LEAST)), lower, upper) for start in starts]
    inside.sort(key=lambda x: float(np.sum(np.abs(residual(x)))))
    fits = [
        optimize.least_squares(
            residual, np.clip(x, lower + 1e-9, upper - 1e-9), bounds=(lower, upper), loss="soft_l1",
            f_scale=THRESHOLDS.resonance.errors_of_outlier, max_nfev=THRESHOLDS.resonance.most_evaluations,
        )
        for x in inside[: THRESHOLDS.resonance.most_starts]
    ]  # fmt: skip
    best = min(fits, key=lambda fit: float(fit.cost))
    return float(best.cost) / measured.omega.size, np.exp(best.x)
