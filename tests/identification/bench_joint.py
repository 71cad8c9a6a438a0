"""A joint whose parameters are known, measured by the independent virtual device."""

from __future__ import annotations

from functools import cache

import numpy as np

from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.simulate import simulate_joint

NOISE, STEP = 2e-4, 0.0
TRUE = {
    "inertia": 1.1e-4,
    "Ks": 0.0151,
    "epos": -0.0305,
    "sigma0": 0.523,
    "sigma1": 2.2e-3,
    "sigma2": 1.9e-3,
    "vs": 0.0666,
    "Fs": 1.33e-3,
    "Fc": 1.05e-3,
}
OFF = {"inertia": 1.4, "Ks": 0.7, "sigma0": 1.5, "sigma1": 0.6, "sigma2": 1.4, "vs": 1.6, "Fs": 0.8, "Fc": 0.85}
"""Factors from the truth to the first guess."""


def make_run(
    amplitude: float, omega: float, *, use: str = "fit", duration: float = 6.0, seed: int = 0, prismatic: bool = False
) -> Run:
    """Return one cosine run with white noise."""
    t = np.arange(round(duration * 200) + 1) * 0.005
    torque = amplitude * np.cos(omega * t)
    sensor = Sensor(noise=NOISE, resolution=STEP)
    y = simulate_joint({**TRUE, "Kp": 1.0}, t, torque, sensor=sensor, seed=seed)
    return Run(
        file=f"a{amplitude}_w{omega}_{seed}.csv",
        free_joints=(4,),
        t=t,
        u=torque[:, None],
        y=y[:, None],
        noise=np.array([NOISE]),
        resolution=np.array([STEP]),
        posture=np.zeros(0),
        use=use,  # type: ignore[arg-type] # one of the three uses
        prismatic=(prismatic,),
    )


@cache
def runs() -> tuple[Run, ...]:
    """Two runs to fit and one to judge."""
    return (
        make_run(0.005, 1.13, seed=1),
        make_run(0.004, 2.4, seed=2),
        make_run(0.0045, 1.75, seed=3, use="validate"),
    )


@cache
def equations() -> Equations:
    """Equations of the joint without gravity, first guesses off by up to 60 %."""
    base = joint_equations(4)
    kept = tuple(q for q in base.parameters if not q.id.startswith("gravity"))
    changes = {}
    for id, value in TRUE.items():
        start = value * OFF.get(id, 1.0) if id != "epos" else 0.0
        reach = (-0.3, 0.3) if id == "epos" else (value / 20, value * 20)
        changes[id] = {"initial": start, "lower": reach[0], "upper": reach[1]}
    return joint_equations(4, parameters=kept).with_parameters(changes)


@cache
def simulator() -> KernelSimulator:
    """Return the kernel of `equations`."""
    return KernelSimulator.of(equations())
