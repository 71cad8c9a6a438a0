"""Waves over position in a residual torque: `TorqueFit` in, effects with wider grids out (`detect.waves`)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from haptid.discrepancy.detect.waves import with_waves
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect


def with_ripple(model: TorqueFit, catalogue: Mapping[str, Effect]) -> dict[str, Effect]:
    """Offer the waves that stand out of a residual torque to the effects that have a wave number.

    Parameters
    ----------
    model
        Fit whose residual is looked at.
    catalogue
        Catalogue effects by key, in SI units.

    Returns
    -------
    dict
        The effects; those with a wave number have the new ones in their grid and below its upper bound.
    """
    return with_waves(catalogue, partial(_over_position, model))


def _over_position(model: TorqueFit) -> tuple[Array, Array]:
    """Return positions of the fitted rows, and the residual there as it is and times the sign of the speed."""
    q, signals = [], []
    for run, residual, rows in zip(model.study.runs, model.residual, model.study.fitted_rows, strict=True):
        motion = measured_motion(run)[rows]
        q.append(motion[:, 0])
        signals.append(residual[rows, None] * np.column_stack((np.ones(len(motion)), np.sign(motion[:, 1]))))
    return np.concatenate(q), np.concatenate(signals)
