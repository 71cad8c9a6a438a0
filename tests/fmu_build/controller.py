"""A position controller as equations of its own, to co-simulate with a joint: PI-D with a filtered derivative."""

import sympy as sp

from haptid.model.equations.equations import Equations, Input, Output, State
from haptid.model.equations.quantity import Quantity

q, i, f = (sp.Symbol(name, real=True) for name in ("reading", "integral", "filtered"))
target, kp, ki, kd, T = (sp.Symbol(name, real=True) for name in ("target", "kp", "ki", "kd", "T"))


def controller() -> Equations:
    error = target - q
    values = (("target", "rad", 0.1), ("kp", "N m/rad", 0.05), ("ki", "N m/rad s", 0.05), ("kd", "N m s/rad", 1e-3))
    parameters = [Quantity(id=id, unit=unit, description=id, initial=value) for id, unit, value in values]
    filter_time = Quantity(id="T", unit="s", description="filter time", initial=0.01, lower=1e-4, scale="log")
    return Equations(
        name="controller",
        title="position controller",
        joints=(),
        states=(
            State(id="integral", unit="rad s", description="integral of the error"),
            State(id="filtered", unit="rad", description="filtered reading"),
        ),
        inputs=(Input(id="reading", unit="rad", description="position reading"),),
        outputs=(
            Output(
                id="torque",
                unit="N m",
                description="torque command",
                expression=kp * error + ki * i - kd * (q - f) / T,
            ),
        ),
        parameters=(*parameters, filter_time),
        rhs=(error, (q - f) / T),
        rates=(sp.S.Zero, 1 / T),
    )
