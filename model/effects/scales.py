"""Orders of magnitude of a joint in its tests: the units in which the catalogue states the sizes of effects.

An effect refers to a scale by its symbol (``TORQUE``, ``POSITION``, …); `Scales.values` gives the numbers of one joint.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import sympy as sp

TORQUE, POSITION, CENTRE, SPEED, INERTIA, FRICTION, VISCOUS, DURATION = (
    sp.Symbol(f"scale_{name}", real=True)
    for name in ("torque", "position", "centre", "speed", "inertia", "friction", "viscous", "duration")
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scales:
    """Scales of one joint over its runs.

    Parameters
    ----------
    torque
        Largest torque that reaches the joint [N m].
    position, centre
        Half of the span of positions, and its middle [rad].
    speed
        Largest speed [rad/s].
    inertia, friction, viscous
        Fitted M [kg m²], Fc [N m] and σ2 [N m s/rad].
    duration
        Length of the longest run [s].
    prismatic
        Whether the joint slides: then forces [N], lengths [m] and masses [kg] stand above.
    """

    torque: float = 1.0
    position: float = 1.0
    centre: float = 0.0
    speed: float = 1.0
    inertia: float = 1.0
    friction: float = 1.0
    viscous: float = 1.0
    duration: float = 1.0
    prismatic: bool = False

    def values(self) -> dict[sp.Symbol, float]:
        """Return the numerical value of every scale symbol.

        Returns
        -------
        dict
            Values by symbol ``scale_<field>``, in the units of `Scales`.
        """
        numbers = asdict(self)
        del numbers["prismatic"]
        return {sp.Symbol(f"scale_{name}", real=True): value for name, value in numbers.items()}
