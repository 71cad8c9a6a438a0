"""Output injection: extend equations by an observer that follows the measured position, for homotopy in the gain L.

q̇ = v + 2L·(y_meas − y),  v̇ = f_v + L²·(y_meas − y);  the error of a double integrator then has the characteristic
polynomial s² + 2L·s + L², with both poles at −L. L = 0 gives the free simulation. `Equations` come in and go out.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from haptid.model.equations.equations import Equations, Input
from haptid.model.equations.fmu_names import OBSERVER

GAIN = "observer_gain"


def with_observer(equations: Equations) -> Equations:
    """Add output injection of the measured positions to equations.

    Parameters
    ----------
    equations
        Explicit equations of n joints, whose first n outputs are the positions.

    Returns
    -------
    Equations
        The observer; its inputs are those of ``equations``, then the n measured positions [rad] or [m], then the gain
        L [1/s].

    Raises
    ------
    ValueError
        Where the equations are implicit in the accelerations.
    """
    n = len(equations.joints)
    gain = Input(
        id=GAIN, unit="1/s", description="observer gain L; 0 simulates freely", structured=OBSERVER.format(part="gain")
    )
    measured = tuple(
        Input(
            id=f"measured_{o.id}",
            unit=o.unit,
            description=f"measured {o.description}",
            structured=OBSERVER.format(part=o.id),
        )
        for o in equations.outputs[:n]
    )
    L = gain.symbol
    # outputs behind the n positions (velocities, handle pose) have no measured counterpart
    error = [m.symbol - o.expression for m, o in zip(measured, equations.outputs, strict=False)]
    rhs = list(equations.rhs)
    for i in range(n):
        rhs[i] = rhs[i] + 2 * L * error[i]
        rhs[n + i] = rhs[n + i] + L**2 * error[i]
    if equations.mass_matrix is not None:
        msg = "output injection needs explicit equations"
        raise ValueError(msg)
    return replace(
        equations,
        name=f"{equations.name}_identification",
        inputs=(*equations.inputs, *measured, gain),
        rhs=tuple(sp.sympify(f) for f in rhs),
    )
