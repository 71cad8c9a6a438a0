"""ModestPy with SciPy's SLSQP (finite differences, its own scaling of parameters by their bounds), on the same FMU."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pandas as pd
from modestpy import Estimation
from modestpy.estim.scipy import scipy as engine

from benchmarks.peers.contestant import Best, Fit, Statement, compete
from benchmarks.peers.fmpy_names import READING, TORQUE, variables

OPTIONS = {"maxiter": 500, "ftol": 1e-12, "disp": False, "iprint": 0}


@contextmanager
def _watched(best: Best, names: list[str]) -> Iterator[None]:
    """Note parameters and error of every simulation, so that a start cut short hands in its best."""
    measure, set_param, trial = engine.calc_err, engine.Model.set_param, {}

    def noted(model: Any, table: pd.DataFrame) -> None:
        set_param(model, table)
        trial.update({name: float(table[name].iloc[0]) for name in names if name in table})

    def error(*arguments: Any, **options: Any) -> Any:
        found = measure(*arguments, **options)
        best.seen(np.array([trial[name] for name in names]), float(found["tot"]))
        return found

    engine.calc_err, engine.Model.set_param = error, noted
    try:
        yield
    finally:
        engine.calc_err, engine.Model.set_param = measure, set_param


def prepare(statement: Statement) -> Fit:
    """Put the data into the tables that ModestPy takes."""
    logging.disable(logging.CRITICAL)
    index = pd.Index(statement.t, name="time")
    given = pd.DataFrame({TORQUE: statement.u}, index=index)
    ideal = pd.DataFrame({READING: statement.y}, index=index)
    names = variables(statement.names)

    def fit(start: np.ndarray, best: Best) -> None:
        guesses = {n: row for n, *row in zip(names, start, statement.lower, statement.upper, strict=True)}
        with tempfile.TemporaryDirectory() as folder, _watched(best, names):
            session = Estimation(
                folder, str(statement.folder / "model.fmu"), given, {}, guesses, ideal, methods=("SCIPY",),
                scipy_opts={"solver": "SLSQP", "options": OPTIONS}, ftype="RMSE", default_log=False,
            )  # fmt: skip
            session.estimate()
        best.note = "finished"

    return fit


if __name__ == "__main__":
    compete(prepare, ("modestpy", "fmpy", "pandas", "numpy", "scipy"))
