"""An expression tape: formulas recorded as single operations, with constants folded and repeated operations shared.

1. A recursion over the links runs with `Node` as its scalar and `Tape` as its coordinates; each operation appends one
   node, or finds the equal node again.
2. `Tape.definitions` selects the nodes that the wanted results need and returns them as a flat list of
   (symbol, expression) in order, which becomes the definitions of `Equations`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

from haptid.model.algebra.trig_polynomials import position_symbol
from haptid.model.algebra.vectors import Scalar
from haptid.model.device.device import Device

Key = tuple[Any, ...]
"""(kind, operands): an operand is the number of a node, a constant or an expression."""
FUNCTIONS = {"cos": sp.cos, "sin": sp.sin}


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """The result of one operation; plain ints and Fractions are constants.

    Parameters
    ----------
    tape
        The tape that holds the operation.
    number
        Position on the tape; operands have smaller numbers.
    """

    tape: Tape
    number: int

    def __add__(self, other: Scalar) -> Scalar:
        """Return a + b."""
        return self.tape.sum(self, other)

    __radd__ = __add__

    def __neg__(self) -> Scalar:
        """Return −a."""
        return self.tape.product(self, -1)

    def __sub__(self, other: Scalar) -> Scalar:
        """Return a − b."""
        return self.tape.sum(self, -other)

    def __rsub__(self, other: Scalar) -> Scalar:
        """Return b − a."""
        return self.tape.sum(-self, other)

    def __mul__(self, other: Scalar) -> Scalar:
        """Return a·b."""
        return self.tape.product(self, other)

    __rmul__ = __mul__


class Tape:
    """Record operations and serve as the `Coordinates` of the recursions, with positions q<j> as symbols.

    Parameters
    ----------
    device
        Device whose joints are the coordinates.
    prefix
        First letters of the names of definitions, ``rb0``, ``rb1``, ….
    """

    def __init__(self, device: Device, prefix: str = "rb") -> None:
        self.device, self.prefix = device, prefix
        self._keys: list[Key] = []
        self._known: dict[Key, int] = {}

    def symbol(self, symbol: sp.Symbol) -> Node:
        """Return the node of a symbol of the model.

        Parameters
        ----------
        symbol
            Symbol of the model, as q<j>.

        Returns
        -------
        Node
            The same node for the same symbol.
        """
        return self._node(("symbol", symbol))

    def constant(self, value: Fraction | int) -> Scalar:
        """Return a number as it is: constants fold.

        Parameters
        ----------
        value
            Rational number.

        Returns
        -------
        int or Fraction
            An int where the number is whole.
        """
        return int(value) if Fraction(value).denominator == 1 else value

    def cos_sin(self, moved_by: Mapping[int, Fraction]) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of Σ moved_by[j]·q_j; those of −q are written in those of q, to share the nodes.

        Parameters
        ----------
        moved_by
            Joint → coefficient [rad/rad].

        Returns
        -------
        cos, sin : Scalar
            Nodes, or the ints 1 and 0 where the angle is 0.
        """
        terms = {j: ratio for j, ratio in moved_by.items() if ratio}
        if len(terms) == 1:
            ((j, ratio),) = terms.items()
            angle = times_symbol(abs(ratio), position_symbol(j))
            sine = self._node(("sin", angle))
            return self._node(("cos", angle)), sine if ratio > 0 else -sine
        angle = sp.Add(*(times_symbol(ratio, position_symbol(j)) for j, ratio in terms.items()))
        return (1, 0) if angle == 0 else (self._node(("cos", angle)), self._node(("sin", angle)))

    def travel(self, moved_by: Mapping[int, Fraction]) -> Scalar:
        """Return Σ moved_by[j]·q_j.

        Parameters
        ----------
        moved_by
            Joint → coefficient.

        Returns
        -------
        Scalar
            Node of the sum [rad] or [m], or the int 0 of an empty one.
        """
        return sum((self.symbol(position_symbol(j)) * self.constant(ratio) for j, ratio in moved_by.items()), 0)

    def tidy(self, value: Scalar) -> Scalar:
        """Return `value`: nodes need no canonical form.

        Parameters
        ----------
        value
            Scalar on the tape.

        Returns
        -------
        Scalar
            The same.
        """
        return value

    def sum(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a + b in canonical form: signs out of the operands, operands by ascending number.

        Parameters
        ----------
        a, b
            Nodes or constants, at least one of them a node.

        Returns
        -------
        Node or constant
            The node of the sum; 0 where the operands cancel.
        """
        if not isinstance(a, Node):
            a, b = b, a
        if not isinstance(b, Node):
            return a if b == 0 else self._node(("+c", a.number, Fraction(b)))
        # signs are taken out of the operands: −a − b shares the node of a + b, and a + (−b) becomes a difference
        (factor_a, base_a), (factor_b, base_b) = self._split_sign(a), self._split_sign(b)
        if base_a == base_b:
            return self.product(Node(self, base_a), factor_a + factor_b)
        if factor_a < 0 and factor_b < 0:
            return -self.sum(Node(self, base_a), Node(self, base_b))
        if factor_a < 0:
            return self._node(("-", base_b, base_a))
        if factor_b < 0:
            return self._node(("-", base_a, base_b))
        return self._node(("+", min(base_a, base_b), max(base_a, base_b)))

    def product(self, a: Scalar, b: Scalar) -> Scalar:
        """Return a·b in canonical form: constant factors outside, operands by ascending number.

        Parameters
        ----------
        a, b
            Nodes or constants, at least one of them a node.

        Returns
        -------
        Node or constant
            The node of the product; 0 for a factor 0.
        """
        if not isinstance(a, Node):
            a, b = b, a
        if isinstance(b, Node):
            (factor_a, base_a), (factor_b, base_b) = self._split_factor(a), self._split_factor(b)
            node = self._node(("*", min(base_a, base_b), max(base_a, base_b)))
            return self.product(node, factor_a * factor_b)
        factor, base = self._split_factor(a)
        factor = factor * Fraction(b)
        if factor == 0:
            return 0
        return Node(self, base) if factor == 1 else self._node(("*c", base, factor))

    def _split_factor(self, node: Node) -> tuple[Fraction, int]:
        key = self._keys[node.number]
        return (key[2], key[1]) if key[0] == "*c" else (Fraction(1), node.number)

    def _split_sign(self, node: Node) -> tuple[Fraction, int]:
        factor, base = self._split_factor(node)
        return (factor, base) if factor in (1, -1) else (Fraction(1), node.number)

    def _node(self, key: Key) -> Node:
        number = self._known.get(key)
        if number is None:
            number = self._known[key] = len(self._keys)
            self._keys.append(key)
        return Node(self, number)

    def definitions(
        self, wanted: Iterable[Scalar]
    ) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[sp.Expr, ...]]:
        """Write out the part of the tape that the wanted scalars need.

        A product that is used once, in a sum, is written into that sum; every other operation becomes a definition.

        Parameters
        ----------
        wanted
            Nodes and constants.

        Returns
        -------
        definitions
            Pairs (symbol, expression), each expression of model symbols and earlier definitions.
        results
            The wanted scalars in their order, as expressions of model symbols and definitions.
        """
        wanted = tuple(wanted)
        uses = self._uses(node.number for node in wanted if isinstance(node, Node))
        expressions: dict[int, sp.Expr] = {}
        lines: list[tuple[sp.Symbol, sp.Expr]] = []
        for number in sorted(uses):
            key = self._keys[number]
            expression = _expression(key, expressions)
            if key[0] == "symbol" or (key[0] in ("*", "*c") and uses[number] == {"+"}):
                expressions[number] = expression
                continue
            symbol = sp.Symbol(f"{self.prefix}{len(lines)}", real=True)
            lines.append((symbol, expression))
            expressions[number] = symbol
        results = (expressions[x.number] if isinstance(x, Node) else sp.nsimplify(x) for x in wanted)
        return tuple(lines), tuple(results)

    def _uses(self, wanted: Iterable[int]) -> dict[int, set[str]]:
        """Return the needed numbers; value {"+"} where the only use is one sum."""
        uses: dict[int, list[str]] = {number: ["out"] for number in wanted}
        # backwards: operands have smaller numbers, so that all uses of a node are known when the loop reaches it
        for number in range(len(self._keys) - 1, -1, -1):
            if number in uses:
                kind = str(self._keys[number][0])
                for operand in _operands(self._keys[number]):
                    uses.setdefault(operand, []).append("+" if kind in "+-" else kind)
        return {number: {"+"} if kinds == ["+"] else {"many"} for number, kinds in uses.items()}


def times_symbol(ratio: Fraction, symbol: sp.Symbol) -> sp.Expr:
    """Return ratio·symbol.

    Parameters
    ----------
    ratio
        Coefficient.
    symbol
        Symbol of the model.

    Returns
    -------
    sympy.Expr
        The product, with the coefficient as an exact rational number.
    """
    return sp.Rational(ratio.numerator, ratio.denominator) * symbol


def _operands(key: Key) -> tuple[int, ...]:
    if key[0] in ("+", "-", "*"):
        return (key[1], key[2])
    return (key[1],) if key[0] in ("+c", "*c") else ()


def _expression(key: Key, expressions: Mapping[int, sp.Expr]) -> sp.Expr:
    kind = key[0]
    if kind == "symbol":
        return key[1]
    if kind in FUNCTIONS:
        return FUNCTIONS[str(kind)](key[1])
    a = expressions[key[1]]
    if kind in ("+c", "*c"):
        value = sp.Float(float(key[2]), 17) if key[2].denominator > 1 else sp.Integer(int(key[2]))
        return a + value if kind == "+c" else a * value
    b = expressions[key[2]]
    return {"+": a + b, "-": a - b, "*": a * b}[str(kind)]
