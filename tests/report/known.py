"""Results that are known because they are written here: a page has to show these numbers and no others.

No two numbers agree, nor do they where one is taken for another by a factor of ten, a thousand or a complement.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from haptid.discrepancy.detect.localise import Map
from haptid.measurement.values.run import Run, Use
from haptid.model.equations.equations import State
from haptid.model.equations.quantity import Normal, Quantity

T = np.array([0.0, 0.5, 1.0, 1.5])


def known_run(file: str, use: Use = "fit", *, joint: int = 4, noise: float = 2e-4) -> Run:
    return Run(
        file=file,
        free_joints=(joint,),
        t=T,
        u=np.array([[0.11], [0.12], [-0.13], [-0.14]]),
        y=np.array([[0.21], [0.23], [0.19], [0.17]]),
        noise=np.array([noise]),
        resolution=np.zeros(1),
        posture=np.zeros(0),
        use=use,
        reason="a cable hung in the way" if use == "excluded" else "",
    )


INERTIA = Quantity(
    id="inertia", unit="kg m²", description="moment of inertia", initial=1.7e-4, lower=1e-6, upper=0.3,
    prior=Normal(mean=1.7e-4, std=9e-5), scale="log", structured="mechanics.inertia",
)  # fmt: skip
STIFFNESS = Quantity(
    id="Ks", unit="N m/rad", description="stiffness of the spring", initial=0.019, lower=-0.4, upper=0.6,
    structured="spring.Ks",
)  # fmt: skip
GAIN = Quantity(id="Kp", unit="1", description="gain of the drive", initial=1.25, fixed=True, structured="drive.Kp")


def known_equations() -> SimpleNamespace:
    """Return what a page asks of the equations of a joint with two free parameters and a fixed one."""
    parameters = (INERTIA, STIFFNESS, GAIN)
    return SimpleNamespace(
        parameters=parameters,
        parameter={q.id: q for q in parameters}.__getitem__,
        states=(State(id="q", unit="rad", description="position"),),
        outputs=(SimpleNamespace(unit="rad"),),
        joints=(4,),
        friction=("lugre",),
        drive=None,
    )


def known_maps() -> tuple[Map, ...]:
    """Four variables of two bins; the shares of energy and of samples in each are those in ``MAPPED``."""
    return tuple(
        Map(variable=variable, edges=np.array([0.0, 0.4, 1.0]), excess=3.0 * np.array(gap), rows=7.0 * np.array(rows))
        for variable, (gap, rows) in MAPPED.items()
    )


MAPPED = {
    "position_rad": ([25.0, 75.0], [31.0, 69.0]),
    "velocity_rad_s": ([37.0, 63.0], [42.0, 58.0]),
    "torque_Nm": ([18.0, 82.0], [53.0, 47.0]),
    "cycle": ([44.0, 56.0], [65.0, 35.0]),
}
"""Shares [%] of energy and of samples in two bins by variable."""
