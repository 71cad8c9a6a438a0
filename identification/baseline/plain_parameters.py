"""The plain model written in the parameters of the equations: `Baseline` and `Equations` in, parameters out.

There is no stiction, presliding is stiff, and no spring acts. A constant torque, which the equations of a joint do not
have, is the torque of a spring so soft that only Ks·epos matters, or the constant force of a slide.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from haptid.identification.baseline.baseline import Baseline
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.device.stated_parameters import ROWS, possible_range, possible_value
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import law_named


def plain_theta(baseline: Baseline, equations: Equations, runs: Sequence[Run]) -> Array:
    """Write the plain model in the parameters of a friction law: no stiction, stiff presliding, no spring.

    Parameters
    ----------
    baseline
        Plain model; its constant torques are not among the parameters.
    equations
        Equations of the configuration.
    runs
        Runs whose travel and torque scale presliding and the least friction.

    Returns
    -------
    ndarray, shape (n_p,)
        Parameters in the order of ``equations.parameters``, SI units; the first guess of any that the plain model
        lacks.
    """
    known = baseline.values
    for k, suffix in enumerate(id_suffixes(baseline.regressor.joints)):
        travel = max(float(np.ptp(run.y[:, k])) for run in runs)
        torque = max(float(np.max(np.abs(run.u[:, k]))) for run in runs)
        coulomb = max(baseline.of_joint("Fc", k), THRESHOLDS.least_friction_over_torque * torque)
        roles = law_named(equations.friction[k]).roles
        values = {"Ks": 0.0, "epos": 0.0, "gravity_cos": 0.0, "gravity_sin": 0.0}
        values |= {roles.viscous: baseline.of_joint("Fv", k), roles.coulomb: coulomb, roles.stiction: coulomb}
        if roles.stiffness:
            values[roles.stiffness] = coulomb / (THRESHOLDS.presliding_of_plain_model_over_travel * travel)
        # What the plain model itself states, such as gravity, goes before the zeros.
        known = {f"{id}{suffix}": value for id, value in values.items()} | known
    return np.array([_possible(q.id, known.get(q.id, q.initial)) for q in equations.parameters])


def _possible(id: str, value: float) -> float:
    """Keep a joint's parameter within what a file may state: least squares give 0 to friction that is not there."""
    name = re.sub(r"_\d+$", "", id)
    return possible_value(name, value) if name in ROWS else value


def with_constant_torque(theta: Array, baseline: Baseline, equations: Equations, runs: Sequence[Run]) -> Array:
    """Put the constant torque of every joint into the parameters.

    Parameters
    ----------
    theta
        Parameters as `plain_theta` returns them, shape (n_p,).
    baseline
        Plain model.
    equations
        Equations of the configuration.
    runs
        Runs whose travel and torque scale the spring.

    Returns
    -------
    ndarray, shape (n_p,)
        Copy with the constant in ``gravity_cos`` of a prismatic joint, else in a spring so soft that it is constant.
    """
    ids = [q.id for q in equations.parameters]
    moved = theta.copy()
    for k, suffix in enumerate(id_suffixes(baseline.regressor.joints)):
        offset = baseline.of_joint("offset", k)
        if runs[0].prismatic[k] and f"gravity_cos{suffix}" in ids:
            moved[ids.index(f"gravity_cos{suffix}")] += offset
        elif f"Ks{suffix}" in ids and offset:
            travel = max(float(np.ptp(run.y[:, k])) for run in runs)
            torque = max(float(np.max(np.abs(run.u[:, k]))) for run in runs)
            softest = THRESHOLDS.soft_spring_torque_over_torque * torque / travel
            # A softer one would have its end where no file may state it.
            stiffness = max(softest, abs(offset) / possible_range("epos")[1])
            moved[ids.index(f"Ks{suffix}")] = stiffness
            # Ks·(q − epos) is −Ks·epos at every position of the joint, to the share above.
            moved[ids.index(f"epos{suffix}")] = -offset / stiffness
    return moved


def parameter_ids(baseline: Baseline, friction: Sequence[str]) -> dict[str, str]:
    """Name the parameters of the plain model by the ids of the equations.

    Parameters
    ----------
    baseline
        Plain model.
    friction
        Names of the friction laws of the free joints.

    Returns
    -------
    dict
        Id of the equations by id of the plain model; a constant torque has none of its own.
    """
    regressor = baseline.regressor
    names = {id: id for id in regressor.ids[: regressor.n_rigid]}
    for k, suffix in enumerate(id_suffixes(regressor.joints)):
        roles = law_named(friction[k]).roles
        names |= {f"Fv{suffix}": f"{roles.viscous}{suffix}", f"Fc{suffix}": f"{roles.coulomb}{suffix}"}
    return names
