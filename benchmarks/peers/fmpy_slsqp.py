"""fmpy.simulate_fmu and SciPy's SLSQP with finite differences, on the FMU that haptid ships (``model.fmu``).

As its users would do it well: logarithms of the parameters, the logarithm of the mean square as cost, one instance that
is reset between simulations.
"""

from __future__ import annotations

import fmpy
import numpy as np
from scipy.optimize import minimize

from benchmarks.peers.contestant import Best, Fit, Statement, compete
from benchmarks.peers.fmpy_names import READING, TORQUE, variables


def prepare(statement: Statement) -> Fit:
    """Load the FMU once."""
    archive = statement.folder / "model.fmu"
    description = fmpy.read_model_description(archive)
    folder = fmpy.extract(archive)
    instance = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    table = np.array(list(zip(statement.t, statement.u, strict=True)), dtype=[("time", float), (TORQUE, float)])
    names = variables(statement.names)
    spacing = statement.t[1]

    def cost(s: np.ndarray, best: Best) -> float:
        theta = np.exp(s)
        instance.reset()
        result = fmpy.simulate_fmu(
            folder, model_description=description, fmu_instance=instance, fmi_type="CoSimulation", input=table,
            output=[READING], start_values=dict(zip(names, map(float, theta), strict=True)), stop_time=statement.t[-1],
            step_size=spacing, output_interval=spacing,
        )  # fmt: skip
        residual = (result[READING] - statement.y)[1:] / statement.noise
        return best.seen(theta, float(0.5 * np.log(np.mean(residual**2))))

    def fit(start: np.ndarray, best: Best) -> None:
        bounds = list(zip(np.log(statement.lower), np.log(statement.upper), strict=True))
        options = {"maxiter": 500, "ftol": 1e-9, "eps": 1e-6}
        found = minimize(cost, np.log(start), args=(best,), method="SLSQP", bounds=bounds, options=options)
        best.note = found.message

    return fit


if __name__ == "__main__":
    compete(prepare, ("fmpy", "scipy", "numpy"))
