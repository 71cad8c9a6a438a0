"""First guesses and bounds of a single joint from its data alone: `Equations` and `Run`s in, `Equations` out.

1. Smooth the positions into motions, without the ends of the runs.
2. Solve an equation linear in the unknowns, over all runs, with M, σ2, Fc ≥ 0. It holds in gross sliding, where
   friction is Coulomb plus viscous:

       Kp·τ = M·q̈ + σ2·q̇ + Fc·sgn q̇ + k·q + c    (k = Ks + g_s, c = g_c − Ks·epos, for small q).

   Inertia follows from the response at speed, the Coulomb torque from the height of the plateaus, k and c from static
   balance. Over a wide range of positions, columns cos q and sin q distinguish gravity from the spring.
3. Give the other parameters of the friction law sizes in proportion, by the law's own `guess`; the fit refines them.
4. Set bounds around the guesses (`guess`).

Where the torque is zero throughout, as of a free swing, the equation tells ratios alone. What the user states of
inertia or gravity is then taken to the side of the torque, and gives the rest its size.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.smoothing import Motion, smooth
from haptid.measurement.values.run import Array, Run
from haptid.model.device.stated_parameters import possible_guess
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.law import FrictionLaw, Sliding
from haptid.model.friction.registry import DEFAULT, law_named

OF_FREE_SWING = {"inertia": 0, "gravity_cos": 5, "gravity_sin": 6}
"""Parameters of which one stated value gives a free swing its scale, with their columns in the equation above."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
    """First guesses and the scales of the data.

    Parameters
    ----------
    values
        First guesses by parameter id.
    torque
        Largest torque [N m].
    travel, centre
        Range and mean of the positions [rad].
    speed
        Largest speed [rad/s].
    """

    values: Mapping[str, float]
    torque: float
    travel: float
    centre: float
    speed: float


def guess_from(
    runs: Sequence[Run],
    *,
    gain: float = 1.0,
    gravity: bool = True,
    friction: str = DEFAULT,
    known: Mapping[str, float] | None = None,
) -> Guess:
    """Estimate the parameters of one joint from its runs.

    Parameters
    ----------
    runs
        Runs of the joint.
    gain
        Kp, factor on the recorded torque.
    gravity
        Whether the joint has gravity parameters.
    friction
        Id of the friction law.
    known
        Stated values by parameter id, which count where the torque is zero throughout.

    Returns
    -------
    Guess
    """
    law = law_named(friction)
    motions = [_moving_part(smooth(run)) for run in runs]
    q, v, a, torque = (np.concatenate([getattr(m, name) for m in motions]) for name in ("q", "v", "a", "torque"))
    torque = gain * torque
    travel, speed = max(float(np.ptp(q)), 1e-9), max(float(np.max(np.abs(v))), 1e-9)
    stated = {} if torque.any() else {id: value for id, value in (known or {}).items() if id in OF_FREE_SWING}
    forces = {"inertia": a, "gravity_cos": np.cos(q), "gravity_sin": np.sin(q)}
    torque = torque - sum(value * forces[id] for id, value in stated.items())
    size = max(float(np.max(np.abs(torque))), 1e-12)
    wide = gravity and travel > THRESHOLDS.least_travel_for_gravity_rad
    # tanh for sgn: the Coulomb torque sets in gradually, over about 2 % of the largest speed.
    columns = [a, v, np.tanh(v / (0.02 * speed)), q, np.ones_like(q)]
    if wide:
        columns += [np.cos(q), np.sin(q)]
    A = np.stack(columns, axis=1)
    # A column of zeros leaves its unknown at 0: what is stated is in the torque already.
    A[:, [k for id, k in OF_FREE_SWING.items() if id in stated and k < A.shape[1]]] = 0.0
    c = _solve_nonnegative(A, torque, free=(4, 5, 6) if wide else (3, 4))
    c[0] = stated.get("inertia", c[0])
    return Guess(
        values=_values(c, law, torque=size, travel=travel, speed=speed, acceleration=float(np.std(a)), wide=wide),
        torque=size,
        travel=travel,
        centre=float(np.mean(q)),
        speed=speed,
    )


def _moving_part(m: Motion) -> Motion:
    """Leave out the ends, where the smoothing has no neighbours, and thin to at most 2000 rows."""
    edge = max(m.t.size // 50, 2)
    rows = slice(edge, m.t.size - edge, max(m.t.size // 2000, 1))
    return Motion(**{name: getattr(m, name)[rows] for name in ("t", "q", "v", "a", "torque")})


def _solve_nonnegative(A: Array, b: Array, free: tuple[int, ...]) -> Array:
    """Least squares with columns of unit size; all unknowns but ``free`` are not negative."""
    size = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    lower = np.zeros(A.shape[1])
    lower[list(free)] = -np.inf
    # Columns of unit size: accelerations and positions differ by orders of magnitude.
    solution = lsq_linear(A / size, b, bounds=(lower, np.inf), method="bvls").x
    return np.asarray(solution / size)


def _values(
    c: Array, law: FrictionLaw, *, torque: float, travel: float, speed: float, acceleration: float, wide: bool
) -> dict[str, float]:
    # No guess of 0: bounds are multiples of a guess on the logarithmic scale, and epos divides by the spring.
    coulomb = max(float(c[2]), 1e-2 * torque)
    inertia = max(float(c[0]), 1e-2 * torque / max(acceleration, 1e-12))
    k, offset = float(c[3]), float(c[4])
    spring = max(k, 1e-3 * torque / travel)
    viscous = max(float(c[1]), 1e-2 * torque / speed)
    seen = Sliding(coulomb=coulomb, viscous=viscous, inertia=inertia, travel=travel, speed=speed)
    return {
        "inertia": inertia,
        **law.guess(seen),
        "Ks": spring,
        "epos": -offset / spring,
        "gravity_cos": float(c[5]) if wide else 0.0,
        "gravity_sin": float(c[6]) if wide else min(k, 0.0),
    }


def guess(equations: Equations, runs: Sequence[Run], *, given: Mapping[str, Mapping[str, object]]) -> Equations:
    """Set first guesses and bounds of one joint from its runs.

    Parameters
    ----------
    equations
        Equations of the joint.
    runs
        Runs that the guesses are estimated from.
    given
        Entries of the campaign by parameter id; a parameter with an entry stays as it is.

    Returns
    -------
    Equations
    """
    fixed = given.get("Kp", {}).get("fixed", equations.parameter("Kp").initial)
    gain = float(fixed) if isinstance(fixed, int | float) else 1.0
    gravity = any(q.id == "gravity_sin" for q in equations.parameters)
    known = {id: float(equations.parameter(id).initial) for id in OF_FREE_SWING if given.get(id)}
    found = guess_from(runs, gain=gain, gravity=gravity, friction=equations.friction[0], known=known)
    changes: dict[str, dict[str, object]] = {}
    for quantity in equations.parameters:
        if quantity.id in found.values and not given.get(quantity.id):
            changes[quantity.id] = _range(quantity, found)
    return equations.with_parameters(changes)


def _range(quantity: Quantity, found: Guess) -> dict[str, object]:
    id, value = quantity.id, found.values[quantity.id]
    if quantity.unit == "1":  # a shape, which has no size that data could give it
        return {"initial": value}
    if quantity.scale == "log":
        factor = THRESHOLDS.bounds_over_guess
        return possible_guess(id, value, value / factor, value * factor)
    if id.startswith("gravity"):
        # A drive swings a load that it cannot hold: then the stiffness, of gravity or of a spring, tells its size.
        size = max(found.torque, *(abs(found.values[other]) for other in ("Ks", "gravity_cos", "gravity_sin")))
        return _within(id, value, -2.0 * size, 2.0 * size)
    if id == "Ks":
        return _within(id, value, 0.0, max(10.0 * value, 4.0 * found.torque / found.travel))
    reach = 2.0 * found.travel
    return _within(id, value, min(value, found.centre) - reach, max(value, found.centre) + reach)


def _within(id: str, value: float, lower: float, upper: float) -> dict[str, object]:
    return possible_guess(id, float(np.clip(value, lower, upper)), lower, upper)
