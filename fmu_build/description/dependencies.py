"""Dependencies of the FMI model structure: `Interface` in, value references that each unknown depends on out."""

from __future__ import annotations

import sympy as sp

from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.description.variables import Variable


class Dependencies:
    """Find the variables on which each output and each derivative depends, from the symbols in its formula.

    Parameters
    ----------
    interface
        Interface of the FMU. Its definitions are resolved once, in their order: each uses only earlier ones.
    """

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        e = interface.equations
        self._definitions = {s: sp.sympify(f).free_symbols for s, f in e.definitions}
        self._resolved: dict[sp.Symbol, set[sp.Symbol]] = {}
        for symbol, used in self._definitions.items():
            self._resolved[symbol] = self._resolve(used)
        self._references = {v.id: v for v in interface.variables if v.settable}
        matrix = [entry for row in e.mass_matrix or () for entry in row]
        self._matrix = self._resolve(set().union(*(sp.sympify(f).free_symbols for f in matrix), set()))

    def _resolve(self, symbols: set[sp.Symbol]) -> set[sp.Symbol]:
        return set().union(*(self._resolved.get(s, {s}) for s in symbols), set())

    def of(self, v: Variable, *, parameters: bool) -> set[int]:
        """Return the value references on which a variable depends.

        Parameters
        ----------
        v
            An output or a derivative. A variable of any other role depends on all states, inputs and parameters.
        parameters
            Whether parameters are listed, as for initial unknowns.

        Returns
        -------
        set of int
            References of inputs and states, and of parameters where asked.
        """
        names = {s.name for s in self._symbols(v)}
        return {
            r.reference for id, r in self._references.items() if id in names and (parameters or r.role != "parameter")
        }

    def parameters_of(self, formula: sp.Expr) -> list[int]:
        """Return the value references of the parameters that a formula uses, ascending; definitions are resolved.

        Parameters
        ----------
        formula
            Formula in symbols of the equations.

        Returns
        -------
        list of int
            Value references, ascending.
        """
        names = {s.name for s in self._resolve(sp.sympify(formula).free_symbols)}
        return sorted(v.reference for id, v in self._references.items() if id in names and v.role == "parameter")

    def _symbols(self, v: Variable) -> set[sp.Symbol]:
        e, n = self.interface.equations, len(self.interface.equations.joints)
        if v.role == "output":
            expression = next(o.expression for o in e.outputs if o.id == v.id)
            return self._resolve(sp.sympify(expression).free_symbols)
        if v.role == "derivative":
            i = v.reference - self.interface.offsets["dx"]
            if e.mass_matrix is None or not n <= i < 2 * n:
                return self._resolve(sp.sympify(e.rhs[i]).free_symbols)
            # M⁻¹ mixes the rows: each acceleration depends on all of h and of M.
            rows = set().union(*(sp.sympify(f).free_symbols for f in e.rhs[n : 2 * n]))
            return self._resolve(rows) | self._matrix
        return {q.symbol for quantities in (e.states, e.inputs, e.parameters) for q in quantities}
