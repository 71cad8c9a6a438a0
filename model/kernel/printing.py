"""C and Python text for SymPy expressions, in the functions of ``real.h`` or of the plain-Python fallback."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import sympy as sp
from sympy.functions.special.delta_functions import DiracDelta, Heaviside
from sympy.printing.c import C99CodePrinter
from sympy.printing.pycode import PythonCodePrinter

FUNCTIONS = ("exp", "log", "sin", "cos", "tanh", "sqrt", "Abs", "sign", "Heaviside")
OWN = ("Magnitude", "Direction", "Max", "Min", "Piecewise")
_C = {"exp": "hk_exp", "sin": "hk_sin", "cos": "hk_cos", "tanh": "hk_tanh", "Abs": "hk_abs", "Magnitude": "hk_abs"}
_C |= {"Direction": "hk_sign", "log": "hk_log"}


class Direction(sp.Function):
    """The sign of a real number, with derivative 0."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:  # noqa: ARG002 - SymPy's signature
        """Return the derivative, which is 0.

        Parameters
        ----------
        argindex
            Number of the argument; there is one.

        Returns
        -------
        sympy.Expr
            0.
        """
        return sp.S.Zero


class Magnitude(sp.Function):
    """The magnitude of a real number, whose derivative is its sign.

    SymPy's ``Abs`` has two disadvantages. A divisor may be 0 for SymPy, so that a quotient may not be real and the
    derivative is taken by real and imaginary part. And ``Abs`` examines the sign of long products, which takes minutes
    where several joints move.
    """

    def fdiff(self, argindex: int = 1) -> sp.Expr:  # noqa: ARG002 - SymPy's signature
        """Return the derivative, which is the sign.

        Parameters
        ----------
        argindex
            Number of the argument; there is one.

        Returns
        -------
        sympy.Expr
            `Direction` of the argument.
        """
        return Direction(self.args[0])


def slopes(expression: sp.Expr, symbols: Iterable[sp.Symbol]) -> list[sp.Expr]:
    """Differentiate an expression of real symbols almost everywhere.

    Parameters
    ----------
    expression
        Expression of real symbols.
    symbols
        Symbols to differentiate by.

    Returns
    -------
    list of sympy.Expr
        ∂expression/∂symbol for each symbol; the derivative of a step is 0 instead of a Dirac delta.
    """
    real = of_reals(expression)
    free = real.free_symbols
    return [_slope(real, s) if s in free else sp.S.Zero for s in symbols]


# An effect changes few of the equations: beside each effect of the catalogue the others are the same. Those of a
# Maxwell-slip friction take seconds.
@lru_cache(maxsize=4096)
def _slope(real: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    """Differentiate an expression that holds the symbol."""
    return _exchange_functions(sp.diff(real, symbol), ((DiracDelta, lambda *_: sp.S.Zero),))


def of_reals(expression: sp.Expr) -> sp.Expr:
    """Replace SymPy's ``Abs`` and ``sign`` by `Magnitude` and `Direction`, whose derivatives stay real and short.

    Parameters
    ----------
    expression
        Expression of real symbols.

    Returns
    -------
    sympy.Expr
        The same function of its symbols.
    """
    return _of_reals(sp.sympify(expression))


@lru_cache(maxsize=4096)
def _of_reals(expression: sp.Expr) -> sp.Expr:
    return _exchange_functions(expression, ((sp.Abs, Magnitude), (sp.sign, Direction)))


def _exchange_functions(expression: sp.Expr, pairs: Iterable[tuple[Any, Any]]) -> sp.Expr:
    """Replace each old function by its new one; an expression without the old function stays as it is."""
    for old, new in pairs:
        if expression.has(old):
            expression = expression.replace(old, new)
    return expression


class CPrinter(C99CodePrinter):
    """Expressions in the arithmetic of ``real.h``: branch-free, the same text for scalars and lanes.

    Parameters
    ----------
    names
        C text of a symbol by its name; a symbol that is absent keeps its name.
    """

    def __init__(self, names: dict[str, str]) -> None:
        super().__init__({"user_functions": _C, "math_macros": {}})  # kernels include no math.h
        self.names = names

    def _print(self, expr: sp.Basic, **kwargs: Any) -> str:
        if isinstance(expr, sp.Function) and expr.is_number:  # functions take lanes, a constant is none
            return repr(float(expr))
        return str(super()._print(expr, **kwargs))

    def _print_Symbol(self, expr: sp.Symbol) -> str:
        return self.names.get(expr.name, expr.name)

    def _print_Integer(self, expr: sp.Integer) -> str:
        return f"{int(expr)}.0"

    def _print_Rational(self, expr: sp.Rational) -> str:
        return f"({expr.p}.0/{expr.q}.0)"

    def _print_Float(self, expr: sp.Float) -> str:
        return repr(float(expr))

    def _print_NumberSymbol(self, expr: sp.Expr) -> str:
        return repr(float(expr))

    def _print_Pow(self, expr: sp.Pow) -> str:
        # real.h has no pow: whole powers become products, half powers roots
        base, power = expr.as_base_exp()
        if power == -1:
            return f"(1.0/{self.parenthesize(base, 1000)})"
        if power.is_Integer and 2 <= int(power) <= 12:
            factor = self.parenthesize(base, 1000)
            return "(" + "*".join([factor] * int(power)) + ")"
        if power.is_Integer and -12 <= int(power) <= -2:
            factor = self.parenthesize(base, 1000)
            return "(1.0/(" + "*".join([factor] * -int(power)) + "))"
        if power.is_Rational and power.q == 2 and abs(power.p) <= 12:
            factor, whole = self.parenthesize(base, 1000), abs(power.p) // 2
            made = "*".join([f"hk_sqrt({self._print(base)})", *[factor] * whole])
            if power < 0:
                return f"(1.0/({made}))"
            return f"({made})" if whole else made
        msg = f"the kernel has no power {power}; write it with exp or sqrt"
        raise NotImplementedError(msg)

    def _print_Mul(self, expr: sp.Mul) -> str:
        """Print divisors that consist of parameters as one factor 1/(...), which the compiler takes out of loops."""
        constant = [f for f in expr.args if self._constant(f) and f.is_Pow and f.exp.is_Number and f.exp < 0]
        if not constant or len(constant) == len(expr.args):
            return super()._print_Mul(expr)
        inverse = self._print(sp.Mul(*(1 / f for f in constant)))
        rest = sp.Mul(*(f for f in expr.args if f not in constant))
        return f"{self.parenthesize(rest, 50)}*(1.0/({inverse}))"

    def _constant(self, expr: sp.Expr) -> bool:
        symbols = expr.free_symbols
        return bool(symbols) and all(self.names.get(s.name, "").startswith("p[") for s in symbols)

    def _print_Max(self, expr: sp.Max) -> str:
        return self._fold("hk_max", expr.args)

    def _print_Min(self, expr: sp.Min) -> str:
        return self._fold("hk_min", expr.args)

    def _fold(self, name: str, args: tuple[sp.Expr, ...]) -> str:
        first, *rest = (self._real(a) for a in args)
        for other in rest:
            first = f"{name}({first}, {other})"
        return first

    def _real(self, expr: sp.Expr) -> str:
        # hk_max, hk_min and hk_select take reals, which may be vectors: K makes one of a plain number
        text = self._print(expr)
        return f"K({text})" if expr.is_number else text

    def _print_sign(self, expr: sp.Expr) -> str:
        return f"hk_sign({self._print(expr.args[0])})"

    def _print_Heaviside(self, expr: sp.Expr) -> str:
        return f"hk_step({self._print(expr.args[0])})"

    def _print_Piecewise(self, expr: sp.Piecewise) -> str:
        # from the last branch back: the last one holds where no earlier condition does
        text = self._real(expr.args[-1].expr)
        for branch in reversed(expr.args[:-1]):
            c = branch.cond
            test = f"hk_true({self._real(c.lhs)} {c.rel_op} {self._real(c.rhs)})"
            text = f"hk_select({test}, {self._real(branch.expr)}, {text})"
        return text


class PythonPrinter(PythonCodePrinter):
    """Expressions for the plain-Python fallback, with ``math`` and the two functions ``sign`` and ``step``.

    Parameters
    ----------
    names
        Python text of a symbol by its name; a symbol that is absent keeps its name.
    """

    def __init__(self, names: dict[str, str]) -> None:
        own = {"Magnitude": "abs", "Direction": "sign"}
        super().__init__({"fully_qualified_modules": True, "user_functions": own})
        self.names = names

    def _print_Symbol(self, expr: sp.Symbol) -> str:
        return self.names.get(expr.name, expr.name)

    def _print_sign(self, expr: sp.Expr) -> str:
        return f"sign({self._print(expr.args[0])})"

    def _print_Heaviside(self, expr: sp.Expr) -> str:
        return f"step({self._print(expr.args[0])})"


class UnsupportedFunctionError(ValueError):
    """An expression uses a function that the kernel does not have."""


def check_functions(expressions: Any) -> None:
    """Check that ``real.h`` has all functions of some expressions.

    Parameters
    ----------
    expressions
        Expressions to print.

    Raises
    ------
    UnsupportedFunctionError
        Where a function is missing; the message names it.
    """
    for expression in expressions:
        for call in sp.sympify(expression).atoms(sp.Function):
            name = type(call).__name__
            if name not in (*FUNCTIONS, *OWN) and not isinstance(call, Heaviside):
                msg = f"the kernel has no function {name}; it has {', '.join(FUNCTIONS)}, Max, Min, Piecewise"
                raise UnsupportedFunctionError(msg)
