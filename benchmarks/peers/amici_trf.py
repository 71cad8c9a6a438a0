"""AMICI: CVODES with forward sensitivities, SciPy's trust-region least squares on the logarithms of the parameters.

AMICI takes no table as input without one event per row, so it is given the cosines as formulas, late by half a row:
that is what a cosine held over rows of 5 ms amounts to, up to a ripple at the row frequency of less than 1e-8 rad.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import amici
import libsbml
import numpy as np
from amici.importers.sbml import SbmlImporter
from amici.importers.utils import MeasurementChannel
from amici.sim import sundials
from scipy.optimize import least_squares

from benchmarks.peers.contestant import Best, Fit, Statement, compete

TOLERANCE = 1e-8
MAX_STEPS = 200_000


def _formulas(statement: Statement) -> dict[str, str]:
    late = float(statement.t[1]) / 2
    torque = " + ".join(f"{a!r}*cos({w!r}*(time - {late!r}))" for a, w in statement.cosines)
    bristle = "(v - sigma0*abs(v)/(Fc + (Fs - Fc)*exp(-(v/vs)^2))*z)"
    load = f"Ks*(q - epos) + sigma0*z + sigma1*{bristle} + sigma2*v"
    return {"q": "v", "v": f"({torque} - ({load}))/inertia", "z": bristle}


def _sbml(statement: Statement) -> str:
    document = libsbml.SBMLDocument(3, 1)
    model = document.createModel()
    for name in (*statement.names, *_formulas(statement)):
        parameter = model.createParameter()
        parameter.setId(name)
        parameter.setValue(1.0 if name in statement.names else 0.0)
        parameter.setConstant(name in statement.names)
    for state, formula in _formulas(statement).items():
        rule = model.createRateRule()
        rule.setVariable(state)
        rule.setMath(libsbml.parseL3Formula(formula))
    return libsbml.writeSBMLToString(document)


def _model(statement: Statement) -> Any:
    """Return the compiled model, from the work folder where it is there."""
    text = _sbml(statement)
    name = f"joint_{hashlib.sha256((text + amici.__version__).encode()).hexdigest()[:12]}"
    folder = statement.folder / name
    if not (folder / "built").exists():
        channel = MeasurementChannel(id_="reading", formula="q", sigma=statement.noise)
        SbmlImporter(text, from_file=False).sbml2amici(name, folder, observation_model=[channel])
        (folder / "built").touch()
    return amici.import_model_module(name, Path(folder)).get_model()


def prepare(statement: Statement) -> Fit:
    """Compile the model and set the tolerances."""
    model = _model(statement)
    model.set_parameter_scale(sundials.ParameterScaling.ln)
    model.set_timepoints(statement.t[1:])
    solver = model.create_solver()
    solver.set_sensitivity_method(sundials.SensitivityMethod.forward)
    solver.set_sensitivity_order(sundials.SensitivityOrder.first)
    solver.set_relative_tolerance(TOLERANCE)
    solver.set_absolute_tolerance(TOLERANCE)
    solver.set_max_steps(MAX_STEPS)
    data = sundials.ExpData(model)
    data.set_measurements(statement.y[1:])
    data.set_noise_scales(np.full(statement.t.size - 1, statement.noise))
    order = [statement.names.index(id) for id in model.get_free_parameter_ids()]
    back = np.argsort(order)

    def simulate(s: np.ndarray, best: Best) -> tuple[np.ndarray, np.ndarray]:
        model.set_free_parameters(s[order])
        out = sundials.run_simulation(model, solver, data)
        if out["status"] != 0:
            return np.full(statement.t.size - 1, 1e6), np.zeros((statement.t.size - 1, s.size))
        best.seen(np.exp(s), float(out["chi2"]))
        return np.array(out["res"]), np.array(out["sres"])[:, back]

    def fit(start: np.ndarray, best: Best) -> None:
        last: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

        def at(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            key = s.tobytes()
            if key not in last:
                last.clear()
                last[key] = simulate(s, best)
            return last[key]

        bounds = (np.log(statement.lower), np.log(statement.upper))
        found = least_squares(lambda s: at(s)[0], np.log(start), jac=lambda s: at(s)[1], bounds=bounds, max_nfev=500)
        best.note = found.message

    return fit


if __name__ == "__main__":
    compete(prepare, ("amici", "scipy", "numpy"))
