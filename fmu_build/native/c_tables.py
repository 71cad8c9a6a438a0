"""C tables of an `Interface` for the native FMU, and C source of the derivatives with respect to its inputs."""

from __future__ import annotations

import json
from collections.abc import Sequence

from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.variables import LARGEST_DOUBLE
from haptid.fmu_build.native.mass_matrix import inertial_parameters
from haptid.model.equations.equations import Equations
from haptid.model.kernel.printing import slopes
from haptid.model.kernel.text import assignments

ROLES = ("hidden", "input", "state", "parameter", "output", "derivative", "slope", "sensitivity", "step")
"""Roles of variables; their index is the number in ``fmu_role``."""


def c_array(kind: str, name: str, values: Sequence[object], shape: str = "") -> str:
    """Return the C definition of a constant table.

    C has no empty arrays, so an empty table gets one zero.

    Parameters
    ----------
    kind
        C type of an entry.
    name
        Name of the table.
    values
        Entries as C text, or what becomes it by `str`.
    shape
        Further dimensions, as ``[2]``.

    Returns
    -------
    str
        One line of C.
    """
    body = ", ".join(map(str, values)) or "0"
    return f"static const {kind} {name}[{max(len(values), 1)}]{shape} = {{{body}}};"


def tables(interface: Interface, guid: str, *, exchange: bool = True) -> str:
    """Return the C tables that the FMI functions read, indexed by value reference.

    Parameters
    ----------
    interface
        Variables of the FMU. An index that no variable has gets role 0 (hidden) and an empty range.
    guid
        Identity that instantiation checks.
    exchange
        Whether there are instances for model exchange.

    Returns
    -------
    str
        Macros and tables of names, roles, ranges, start values, nominal values, ordered pairs, and of the parameters in
        each row of the mass matrix.
    """
    n, by_reference = interface.offsets["end"], {v.reference: v for v in interface.variables}
    rows = [by_reference.get(i) for i in range(n)]
    orderings, inertial = interface.orderings, inertial_parameters(interface)
    first = [sum(map(len, inertial[:i])) for i in range(len(inertial) + 1)]
    return "\n".join(
        (
            f"#define FMU_GUID {json.dumps(guid)}",
            f"#define FMU_SWITCH {int(interface.identification)}",
            f"#define FMU_STALE_FROM {interface.stale_from}",
            f"#define FMU_EXCHANGE {int(exchange)}",
            f"#define FMU_JOINTS {len(inertial)}",
            c_array("char *const", "fmu_name", [json.dumps(v.name) if v else '""' for v in rows]),
            c_array("unsigned char", "fmu_role", [ROLES.index(v.role) if v else 0 for v in rows]),
            c_array("double", "fmu_min", [repr(v.minimum_set) if v else repr(LARGEST_DOUBLE) for v in rows]),
            c_array("double", "fmu_max", [repr(v.maximum_set) if v else repr(-LARGEST_DOUBLE) for v in rows]),
            c_array("double", "fmu_start", [repr(value) for value in interface.start]),
            c_array("double", "fmu_nominal", [repr(x.nominal) for x in interface.equations.states]),
            f"enum {{ fmu_orders = {len(orderings)} }};",
            c_array("unsigned", "fmu_order", [f"{{{a}, {b}}}" for a, b in orderings] or ["{0}"], "[2]"),
            c_array("int", "fmu_joint", interface.equations.joints),
            c_array("unsigned", "fmu_mass", [vr for row in inertial for vr in row]),
            c_array("unsigned", "fmu_mass_first", [*first, 0]),
            "",
        )
    )


def input_jacobian(equations: Equations) -> str:
    """Return the C function ``hf_input_jacobian`` of explicit equations.

    Parameters
    ----------
    equations
        Equations ẋ = f(t, x, u, p), y = g(t, x, u, p).

    Returns
    -------
    str
        C source; the function writes B = ∂f/∂u (n_x, n_u) and D = ∂g/∂u (n_y, n_u), row-major.
    """
    targets, values = [], []
    outputs = [o.expression for o in equations.outputs]
    symbols = [u.symbol for u in equations.inputs]
    for letter, rows in (("B", equations.rhs), ("D", outputs)):
        values += [slope for row in rows for slope in slopes(row, symbols)]
        targets += [f"{letter}[{k}]" for k in range(len(rows) * len(symbols))]
    arguments = "double t, const double *x, const double *u, const double *p, double *B, double *D"
    return f"static void hf_input_jacobian({arguments}) {{\n{assignments(equations, targets, values)}\n}}\n"
