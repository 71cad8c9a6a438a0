"""C text of equations: assignments in the names of the kernel's arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from haptid.model.equations.equations import TIME, Equations
from haptid.model.kernel.printing import CPrinter, check_functions


def symbol_names(equations: Equations, state: str) -> dict[str, str]:
    """Return the C text of every symbol.

    Parameters
    ----------
    equations
        Equations with the symbols.
    state
        Format of a state with its number in braces, as ``x[{}]``.

    Returns
    -------
    dict of str to str
        Id → ``t``, the formatted state, ``u[i]`` or ``p[i]``.
    """
    names = {TIME.name: "t"}
    names.update({x.id: state.format(i) for i, x in enumerate(equations.states)})
    names.update({x.id: f"u[{i}]" for i, x in enumerate(equations.inputs)})
    names.update({x.id: f"p[{i}]" for i, x in enumerate(equations.parameters)})
    return names


def select_definitions(
    definitions: Sequence[tuple[sp.Symbol, sp.Expr]], expressions: Iterable[sp.Expr]
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Select the definitions that expressions use, directly or through other definitions.

    Parameters
    ----------
    definitions
        Pairs (symbol, expression), each expression of earlier definitions.
    expressions
        Expressions to print.

    Returns
    -------
    list of (sympy.Symbol, sympy.Expr)
        The used definitions in their order.
    """
    wanted: set[sp.Symbol] = set().union(*(sp.sympify(e).free_symbols for e in expressions), set())
    kept = []
    # backwards: a definition uses only earlier ones, so that all uses are known when the loop reaches it
    for symbol, expression in reversed(definitions):
        if symbol in wanted:
            wanted |= expression.free_symbols
            kept.append((symbol, expression))
    return kept[::-1]


def assignments(
    equations: Equations, targets: Sequence[str], expressions: Sequence[sp.Expr], state: str = "x[{}]"
) -> str:
    """Print assignments ``target = expression;`` with common subexpressions taken out.

    Parameters
    ----------
    equations
        Equations with symbols and definitions.
    targets
        C text of the left-hand sides, with ``real`` where a variable is declared.
    expressions
        Right-hand sides.
    state
        Format of a state, as in `symbol_names`.

    Returns
    -------
    str
        C statements, one a line: used definitions, common subexpressions, assignments.

    Raises
    ------
    UnsupportedFunctionError
        Where an expression uses a function that ``real.h`` lacks.
    """
    check_functions(expressions)
    printer = CPrinter(symbol_names(equations, state))
    # HK_NEUTRAL (−0.0 in every lane) makes a vector of a plain number and leaves every bit of x + (−0.0) as it is
    lines = [
        f"real {printer.doprint(s)} = HK_NEUTRAL + {printer.doprint(e)};"
        for s, e in select_definitions(equations.definitions, expressions)
    ]
    common, reduced = sp.cse([sp.sympify(e) for e in expressions], symbols=sp.numbered_symbols("e_"), order="none")
    lines += [f"real {s.name} = HK_NEUTRAL + {printer.doprint(e)};" for s, e in common]
    lines += [f"{target} = HK_NEUTRAL + {printer.doprint(e)};" for target, e in zip(targets, reduced, strict=True)]
    return "\n".join(f"    {line}" for line in lines)
