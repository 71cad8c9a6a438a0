"""The mass matrix of an FMU, which must be positive definite: `Interface` in, C source and tables of its check out."""

from __future__ import annotations

import sympy as sp

from haptid.fmu_build.description.dependencies import Dependencies
from haptid.fmu_build.description.interface import Interface
from haptid.model.equations.equations import Equations
from haptid.model.kernel.text import assignments

_NOTHING_TO_CHECK = """
HF_API int hf_pivot(double *v, double t, double *pivot) {
    (void)v; (void)t; (void)pivot;
    return -1;
}
"""
Matrix = tuple[tuple[sp.Expr, ...], ...]


def checked_matrix(equations: Equations) -> Matrix:
    """Return the mass matrix of the equations, shape (n_q, n_q); empty where they have none.

    Parameters
    ----------
    equations
        Equations of one or several joints.

    Returns
    -------
    tuple of tuple of sympy.Expr
        Mass matrix [kg m²] of revolute joints, shape (n_q, n_q), or the inertia of one joint; () where there is none.
    """
    return equations.mass_matrix or equations.inertia or ()


def inertial_parameters(interface: Interface) -> list[list[int]]:
    """Return for each row of the checked matrix the parameters that it depends on, up to the diagonal.

    Parameters
    ----------
    interface
        Variables of the FMU.

    Returns
    -------
    list of list of int
        Value references by row. Empty for an identification FMU: a fit's trial steps may pass through such values.
    """
    matrix = () if interface.identification else checked_matrix(interface.equations)
    if not matrix:
        return []
    uses = Dependencies(interface)
    return [sorted(set().union(*map(uses.parameters_of, row[: i + 1]))) for i, row in enumerate(matrix)]


def pivot_source(equations: Equations) -> str:
    """Return the C function ``hf_pivot``, which factors the mass matrix by Cholesky.

    Parameters
    ----------
    equations
        Equations, with or without a mass matrix.

    Returns
    -------
    str
        C source. The function returns the first row whose pivot is not positive, and that pivot; -1 where all are.
    """
    matrix = checked_matrix(equations)
    n = len(matrix)
    if n == 0:
        return _NOTHING_TO_CHECK
    lower = [(i, j) for i in range(n) for j in range(i + 1)]
    entries = assignments(equations, [f"M[{i}][{j}]" for i, j in lower], [matrix[i][j] for i, j in lower])
    return f"""
HF_API int hf_pivot(double *v, double t, double *pivot) {{
    const double *x = v + HF_X, *u = v + HF_U, *p = v + HF_P;
    double M[{n}][{n}];
    (void)t; (void)u;
{entries}
    for (int j = 0; j < {n}; j++) {{
        for (int k = 0; k < j; k++) M[j][j] -= M[j][k] * M[j][k];
        *pivot = M[j][j];
        if (!(M[j][j] > 0)) return j;
        M[j][j] = hk_sqrt(M[j][j]);
        for (int i = j + 1; i < {n}; i++) {{
            for (int k = 0; k < j; k++) M[i][j] -= M[i][k] * M[j][k];
            M[i][j] /= M[j][j];
        }}
    }}
    return -1;
}}
"""
