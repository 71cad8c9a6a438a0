"""Haptid's own fit from one start at a time: parameters, covariance and statuses, as ``fitting.fit`` gives them.

``--variant SIMULATOR:METHOD`` with SIMULATOR python or native (FMU) or kernel (in process), METHOD slsqp or
gauss_newton.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.peers.contestant import Best, Fit, Statement, compete
from haptid.fmu_build.building.cached import identification_fmu
from haptid.identification.fit.multistart import fit as identify
from haptid.identification.problem.options import FitOptions
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations


def equations_of(statement: Statement) -> Equations:
    """Return the joint with the bounds as told, all nine as logarithms; no order of Fs and Fc, as for everyone."""
    told = zip(statement.names, statement.lower, statement.upper, strict=True)
    free = {id: {"initial": float(np.sqrt(a * b)), "lower": a, "upper": b, "scale": "log"} for id, a, b in told}
    known = {id: {"fixed": True} for id in ("gravity_cos", "gravity_sin", "Kp")}
    return replace(joint_equations(0), orderings=()).with_parameters({**free, **known})


def _simulator(equations: Equations, name: str) -> Simulator:
    if name == "kernel":
        return KernelSimulator.of(equations)
    return FmuSimulator.of(identification_fmu(equations, kind="python" if name == "python" else "native"), equations)


def prepare(statement: Statement) -> Fit:
    """Build (or find in the cache) what simulates, and frame the data as a run."""
    name, method = statement.variant.split(":")
    equations = equations_of(statement)
    simulator = _simulator(equations, name)
    run = Run(
        file="fit", free_joints=(0,), t=statement.t, u=statement.u[:, None], y=statement.y[:, None],
        noise=np.array([statement.noise]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip
    free = [i for i, q in enumerate(equations.parameters) if not q.fixed]
    assert tuple(equations.parameters[i].id for i in free) == statement.names

    def fit(start: np.ndarray, best: Best) -> None:
        first = np.array([q.initial for q in equations.parameters])
        first[free] = start
        options = FitOptions(method=method, starts=1, start=tuple(first))  # type: ignore[arg-type] # as told
        found = identify(simulator, (run,), options=options)
        best.seen(found.theta[free], found.cost)
        best.note, best.simulations = str(found.outcome), found.simulations

    return fit


if __name__ == "__main__":
    compete(prepare, ("numpy", "scipy"))
