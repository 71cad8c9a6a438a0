"""Tell which effects of a model are smooth torques over position: effects in, those that hardly bend out.

Two of them together follow any smooth curve, as the terms of a series do. So where a model with two of them leaves more
than noise, it shows neither name: a spring that stiffens with another power than the third was followed as well by a
wave and a cubic spring as by two stops and the weight of a load.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.effect import Effect, q


def smooth_curves(study: Study, effects: Sequence[Effect], values: Mapping[str, float]) -> tuple[Effect, ...]:
    """Return the effects that are smooth torques over the position.

    Parameters
    ----------
    study
        Study with the fitted runs, whose travel counts.
    effects
        Effects of a model, in SI units.
    values
        Its parameters by id.

    Returns
    -------
    tuple of Effect
        Those whose torque depends on the position alone, and turns at most `most_turns_of_smooth_curve` times over the
        travel from bending one way to bending the other.
    """
    most = THRESHOLDS.search.most_turns_of_smooth_curve
    torques = [(e, e.position_torque) for e in effects]
    return tuple(e for e, torque in torques if torque is not None and _turns(study, e, torque, values) <= most)


def _turns(study: Study, effect: Effect, torque: sp.Expr, values: Mapping[str, float]) -> int:
    """Count the changes of sign of d²torque/dq² over the travel of the fitted runs."""
    travelled = np.concatenate([run.y[:, effect.joint or 0] for run in study.fitted])
    at = np.linspace(travelled.min(), travelled.max(), THRESHOLDS.search.points_of_smooth_curve)
    known = torque.subs({x: values[str(x.name)] for x in torque.free_symbols - {q}})
    along = np.asarray(sp.lambdify(q, known, "numpy")(at)) * np.ones_like(at)
    bend = np.sign(np.diff(along, 2))
    return int(np.count_nonzero(np.diff(bend[bend != 0.0])))
