"""C text of equations: assignments in the names of the kernel's arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from haptid.model.equations.equations import TIME, Equations
from haptid.model.kernel.printing import CPrinter, check_functions


def symbol_names(equations: Equations, state: str) -> dict[str, str]:
    """Return the text of every symbol: ``state`` with the state's number, ``u[i]``, ``p[i]``, ``t``."""
    names = {TIME.name: "t"}
    names.update({x.id: state.format(i) for i, x in enumerate(equations.states)})
    names.update({x.id: f"u[{i}]" for i, x in enumerate(equations.inputs)})
    names.update({x.id: f"p[{i}]" for i, x in enumerate(equations.parameters)})
    return names


def select_definitions(
    definitions: Sequence[tuple[sp.Symbol, sp.Expr]], expressions: Iterable[sp.Expr]
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Return those of the definitions that the expressions use, directly or through others, in order."""
    wanted: set[sp.Symbol] = set().union(*(sp.sympify(e).free_symbols for e in expressions), set())
    kept = []
    for symbol, expression in reversed(definitions):
        if symbol in wanted:
            wanted |= expression.free_symbols
            kept.append((symbol, expression))
    return kept[::-1]


def assignments(
    equations: Equations, targets: Sequence[str], expressions: Sequence[sp.Expr], state: str = "x[{}]"
) -> str:
    """Write assignments ``target = expression;`` with common subexpressions taken out."""
    check_functions(expressions)
    printer = CPrinter(symbol_names(equations, state))
    lines = [
        f"real {printer.doprint(s)} = HK_NEUTRAL + {printer.doprint(e)};"
        for s, e in select_definitions(equations.definitions, expressions)
    ]
    common, reduced = sp.cse([sp.sympify(e) for e in expressions], symbols=sp.numbered_symbols("e_"), order="none")
    lines += [f"real {s.name} = HK_NEUTRAL + {printer.doprint(e)};" for s, e in common]
    lines += [f"{target} = HK_NEUTRAL + {printer.doprint(e)};" for target, e in zip(targets, reduced, strict=True)]
    return "\n".join(f"    {line}" for line in lines)
