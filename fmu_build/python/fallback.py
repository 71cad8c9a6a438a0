"""The kernel in plain Python, for platforms without a compiled one: `Interface` in, text of a Python module out.

Generated functions of the formulas stand between the fixed `fallback_stepper.py` and `fallback_flat.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

import sympy as sp

from haptid.fmu_build.description.interface import Interface, block_offsets
from haptid.fmu_build.native.mass_matrix import checked_matrix
from haptid.model.equations.equations import Equations
from haptid.model.kernel.generate import Kernel, coupling
from haptid.model.kernel.printing import PythonPrinter, slopes
from haptid.model.kernel.text import select_definitions, symbol_names


def module_text(name: str) -> str:
    """Return the text of a module of this folder that goes into the FMU as it is.

    Parameters
    ----------
    name
        Name of the file.

    Returns
    -------
    str
        Content of the file.
    """
    return (resources.files("haptid.fmu_build.python") / name).read_text(encoding="utf-8")


def fallback_source(interface: Interface) -> str:
    """Return a Python module with the functions of ``flat.c``.

    Parameters
    ----------
    interface
        Kernel and layout of the buffer.

    Returns
    -------
    str
        Source that needs the standard library alone.
    """
    kernel = interface.kernel
    e = kernel.equations
    parts = [
        module_text("fallback_stepper.py"),
        _layout(kernel),
        _function(e, "rates", [sp.sympify(r) for r in e.rates], wide=False),
        _function(e, "coupling_of", [coupling(e)], wide=False),
        "def coupling(t, x, u, p):\n    return coupling_of(t, x, u, p)[0]\n",
        _evaluate(e),
        _function(e, "outputs_of", [o.expression for o in e.outputs]),
        "def outputs(t, X, u, p):\n    return [[y] for y in outputs_of(t, X, u, p)]\n",
        *(_tangents(e) if kernel.columns else ()),
        _function(e, "mass_of", [sp.sympify(f) for row in checked_matrix(e) for f in row], wide=False),
        module_text("fallback_flat.py"),
    ]
    return "\n\n".join(parts)


def _layout(kernel: Kernel) -> str:
    e = kernel.equations
    sizes = {"NX": len(e.states), "NU": len(e.inputs), "NP": len(e.parameters), "NC": len(kernel.columns)}
    places = {f"HF_{k.upper()}": n for k, n in block_offsets(kernel).items()}
    return "\n".join(f"{k} = {v!r}" for k, v in {**sizes, **places}.items())


def _function(e: Equations, name: str, expressions: Sequence[sp.Expr], *, wide: bool = True) -> str:
    """Return ``def name(t, X, u, p)`` that returns the list of the expressions; X has columns where ``wide``."""
    state, argument = ("X[{}][0]", "X") if wide else ("x[{}]", "x")
    printer = PythonPrinter(symbol_names(e, state))
    needed = select_definitions(e.definitions, expressions)
    lines = [f"    {symbol.name} = {printer.doprint(formula)}" for symbol, formula in needed]
    common, reduced = sp.cse(list(expressions), symbols=sp.numbered_symbols("e_"), order="none")
    lines += [f"    {s.name} = {printer.doprint(f)}" for s, f in common]
    lines.append(f"    return [{', '.join(printer.doprint(f) for f in reduced)}]")
    return "\n".join((f"def {name}(t, {argument}, u, p):", *lines, ""))


def _evaluate(e: Equations) -> str:
    n, nx = len(e.joints), len(e.states)
    expressions = [sp.sympify(f) for f in e.rhs]
    if e.mass_matrix is None:
        return "\n".join(
            (
                _function(e, "rhs", expressions),
                "",
                "def evaluate(t, X, u, p):",
                "    return [[f] for f in rhs(t, X, u, p)]",
                "",
            )
        )
    matrix = [sp.sympify(e.mass_matrix[i][j]) for i in range(n) for j in range(n)]
    return "\n".join(
        (
            _function(e, "rhs", [*expressions, *matrix]),
            "",
            "def evaluate(t, X, u, p):",
            "    f = rhs(t, X, u, p)",
            f"    M = [f[{nx} + {n} * i : {nx} + {n} * (i + 1)] for i in range({n})]",
            f"    f[{n}:{2 * n}] = solve(M, f[{n}:{2 * n}])",
            f"    return [[value] for value in f[:{nx}]]",
            "",
        )
    )


def _tangents(e: Equations) -> tuple[str, ...]:
    """Return functions that give the value and J·S + ∂/∂p in the columns."""
    return (
        _tangent(e, "evaluate", [sp.sympify(f) for f in e.rhs]),
        _tangent(e, "outputs", [sp.sympify(o.expression) for o in e.outputs]),
    )


def _tangent(e: Equations, name: str, values: Sequence[sp.Expr]) -> str:
    n, nx, n_p = len(values), len(e.states), len(e.parameters)
    symbols = [*(x.symbol for x in e.states), *(x.symbol for x in e.parameters)]
    jacobian = [slope for f in values for slope in slopes(f, symbols)]
    return "\n".join(
        (
            _function(e, f"{name}_parts", [*values, *jacobian]),
            "",
            f"def {name}_tangent(t, X, u, p):",
            f"    f = {name}_parts(t, X, u, p)",
            "    rows = []",
            f"    for i in range({n}):",
            f"        J = f[{n} + {nx + n_p} * i : {n} + {nx + n_p} * (i + 1)]",
            f"        row = [sum(J[k] * X[k][c] for k in range({nx})) for c in range(1, {nx + n_p} + 1)]",
            f"        rows.append([f[i], *(row[c] + (J[{nx} + c] if c < {n_p} else 0.0) for c in range(len(row)))])",
            "    return rows",
            "",
        )
    )
