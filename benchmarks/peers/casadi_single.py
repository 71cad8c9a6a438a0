"""CasADi, single shooting: IPOPT with bounds and a Gauss–Newton Hessian on the logarithms of the parameters.

``--variant N`` takes N steps of the integrator per row.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from benchmarks.peers.casadi_model import row_step
from benchmarks.peers.contestant import Best, Fit, Statement, compete

QUIET = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}


def solver(statement: Statement, unknowns: ca.MX, residual: ca.MX) -> ca.Function:
    """Return IPOPT on ½|residual|² with the Gauss–Newton Hessian."""
    jacobian = ca.jacobian(residual, unknowns)
    hessian = ca.triu(ca.mtimes(jacobian.T, jacobian))
    factor = ca.MX.sym("factor")
    arguments = [unknowns, ca.MX.sym("p", 0), factor, ca.MX.sym("multipliers", 0)]
    options = {
        **QUIET,
        "hess_lag": ca.Function("hessian", arguments, [factor * hessian]),
        "ipopt.max_wall_time": statement.budget,
        "ipopt.max_iter": 500,
    }
    return ca.nlpsol("solve", "ipopt", {"x": unknowns, "f": 0.5 * ca.sumsqr(residual)}, options)


def prepare(statement: Statement) -> Fit:
    """Build the shooting function and the solver once."""
    s = ca.MX.sym("s", 9)
    roll = row_step(statement.t[1], int(statement.variant)).mapaccum(statement.t.size - 1)
    states = roll(np.zeros(3), statement.u[None, :-1], ca.repmat(s, 1, statement.t.size - 1))
    residual = (states[0, :].T - statement.y[1:]) / statement.noise / np.sqrt(statement.t.size)
    solve = solver(statement, s, residual)
    bounds = {"lbx": np.log(statement.lower), "ubx": np.log(statement.upper)}

    def fit(start: np.ndarray, best: Best) -> None:
        found = solve(x0=np.log(start), **bounds)
        best.seen(np.exp(np.array(found["x"]).ravel()), float(found["f"]))
        best.note, best.simulations = solve.stats()["return_status"], solve.stats()["iter_count"]

    return fit


if __name__ == "__main__":
    compete(prepare, ("casadi", "numpy"))
