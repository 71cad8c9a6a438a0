"""Warnings of parameters that the runs do not excite: `Equations`, parameters and simulated motions in, sentences out.

Each joint is judged on its simulated motion, with the presliding length of its friction law (LuGre: Fs/σ0): a row is in
presliding where the joint is less than twice that length from its last reversal. A warning says that a joint has too
few rows in presliding, too few in gross sliding, or never reaches the Stribeck velocity. Where the runs determine
Coulomb and viscous friction all the same, a stiction or Stribeck velocity that ran away has made it look so.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import law_named


def excitation_warnings(
    equations: Equations, theta: Array, motions: Sequence[tuple[Array, Array]], identified: Collection[str] = ()
) -> tuple[str, ...]:
    """Warn of friction parameters that the simulated motions do not excite.

    Parameters
    ----------
    equations
        Equations of the configuration.
    theta
        Parameters, shape (n_p,).
    motions
        Times t [s], shape (n_t,), and positions y [rad] or [m], shape (n_t, n_joints), by run.
    identified
        Ids of the parameters that the runs determine.

    Returns
    -------
    tuple of str
        Sentences, with the joint's number where several joints are free.
    """
    values = {q.id: float(v) for q, v in zip(equations.parameters, theta, strict=True)}
    free = {q.id for q in equations.parameters if not q.fixed}
    found: list[str] = []
    # Equations that are solved for the torque have the friction of one joint, but no joints.
    joints = zip(equations.joints, id_suffixes(equations.joints), equations.friction, strict=False)
    for k, (joint, suffix, friction_law) in enumerate(joints):
        law = law_named(friction_law)
        friction, roles = law.values(values, suffix), law.roles
        needed = [id for id in (roles.stiffness, roles.stribeck_velocity, roles.stiction) if id]
        if all(friction[id] > 0 for id in needed) and f"{roles.stiffness or roles.coulomb}{suffix}" in free:
            name = f"joint {joint}: " if suffix else ""
            speed = roles.stribeck_velocity
            unit = equations.parameter(f"{speed}{suffix}").unit if speed else ""
            known = [id for id in friction if f"{id}{suffix}" in identified]
            found += _joint_warnings(name, law, friction, [(t, y[:, k]) for t, y in motions], unit, known)
    return tuple(found)


def _joint_warnings(
    name: str,
    law: FrictionLaw,
    friction: dict[str, float],
    motions: list[tuple[Array, Array]],
    unit_of_speed: str,
    identified: Collection[str],
) -> Iterator[str]:
    length = 2.0 * law.presliding_length(friction)
    inside = [presliding(y, length) for _, y in motions]
    rows, total = sum(int(m.sum()) for m in inside), sum(m.size for m in inside)
    fastest = max(float(np.max(np.abs(np.gradient(y, t)))) for t, y in motions)
    if law.roles.stiffness and rows < THRESHOLDS.least_rows_of_friction_regime:
        yield (
            f"{name}only {rows} rows in presliding: {_list_open_parameters(law.without_presliding)}; "
            "add a slow run of small amplitude or sample faster"
        )
    roles = law.roles
    slides = roles.coulomb in identified and roles.viscous in identified
    if total - rows < THRESHOLDS.least_rows_of_friction_regime and not slides:
        listed = _list_open_parameters(law.without_sliding)
        yield f"{name}the runs never leave presliding: {listed}; add a run of larger torque"
    ran_away = slides and roles.stribeck_velocity not in identified
    if roles.stribeck_velocity and fastest < friction[roles.stribeck_velocity] and not ran_away:
        yield (
            f"{name}never faster than {roles.stribeck_velocity} "
            f"({fastest:.2g} of {friction[roles.stribeck_velocity]:.2g} {unit_of_speed}): "
            f"{roles.coulomb} and {roles.viscous} are extrapolated; add a faster run"
        )


def _list_open_parameters(ids: Sequence[str]) -> str:
    """Return ``a, b and c stay open``."""
    return f"{ids[0]} stays open" if len(ids) == 1 else f"{', '.join(ids[:-1])} and {ids[-1]} stay open"


def presliding(y: Array, length: float) -> Array:
    """Find the rows in presliding.

    Parameters
    ----------
    y
        Positions of a joint [rad], shape (n_t,).
    length
        Distance from the last reversal below which a row is in presliding [rad].

    Returns
    -------
    ndarray of bool, shape (n_t,)
        Before the first reversal, the distance is counted from the first row.
    """
    direction = np.sign(np.diff(y))
    turns = np.flatnonzero(direction[1:] * direction[:-1] < 0) + 1
    last = np.zeros(y.size, dtype=np.int64)
    last[turns] = turns
    last = np.maximum.accumulate(last)
    return np.asarray(np.abs(y - y[last]) < length)
