"""Warnings where the runs do not excite a parameter: never in presliding, never past the Stribeck speed, and so on.

Judged on the simulated motion, joint by joint: the bristle's length is Fs/σ0, a row is in presliding where the joint
is less than twice that from its last reversal.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations

FEW_ROWS = 20


def excitation_warnings(equations: Equations, theta: Array, motions: Sequence[tuple[Array, Array]]) -> tuple[str, ...]:
    """Return sentences about parameters that the motions (t, y (n_t, n_joints)) leave open.

    They name the joint where several are free.
    """
    values = {q.id: float(v) for q, v in zip(equations.parameters, theta, strict=True)}
    free = {q.id for q in equations.parameters if not q.fixed}
    found: list[str] = []
    for k, joint in enumerate(equations.joints):
        tail = "" if len(equations.joints) == 1 else f"_{joint}"
        friction = {id: values.get(f"{id}{tail}", 0.0) for id in ("sigma0", "vs", "Fs")}
        if all(value > 0 for value in friction.values()) and f"sigma0{tail}" in free:
            name = f"joint {joint}: " if tail else ""
            found += _joint_warnings(name, friction, [(t, y[:, k]) for t, y in motions])
    return tuple(found)


def _joint_warnings(name: str, friction: dict[str, float], motions: list[tuple[Array, Array]]) -> Iterator[str]:
    length = 2.0 * friction["Fs"] / friction["sigma0"]
    inside = [presliding(y, length) for _, y in motions]
    rows, total = sum(int(m.sum()) for m in inside), sum(m.size for m in inside)
    fastest = max(float(np.max(np.abs(np.gradient(y, t)))) for t, y in motions)
    if rows < FEW_ROWS:
        yield (
            f"{name}only {rows} rows in presliding: sigma0 and sigma1 stay open; "
            "add a slow run of small amplitude or sample faster"
        )
    if total - rows < FEW_ROWS:
        yield f"{name}the runs never leave presliding: Fc, sigma2 and vs stay open; add a run of larger torque"
    if fastest < friction["vs"]:
        yield (
            f"{name}never faster than vs ({fastest:.2g} of {friction['vs']:.2g} rad/s): "
            "Fc and sigma2 are extrapolated; add a faster run"
        )


def presliding(y: Array, length: float) -> Array:
    """Return which rows lie within ``length`` of the last reversal, shape (n_t,)."""
    direction = np.sign(np.diff(y))
    turns = np.flatnonzero(direction[1:] * direction[:-1] < 0) + 1
    last = np.zeros(y.size, dtype=np.int64)
    last[turns] = turns
    last = np.maximum.accumulate(last)
    return np.asarray(np.abs(y - y[last]) < length)
