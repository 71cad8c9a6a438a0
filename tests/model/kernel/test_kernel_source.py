"""The source of a kernel is printed once for equal formulas, and again wherever they differ."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import sympy as sp

from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel import generate as module
from haptid.model.kernel.generate import generate
from haptid.model.kernel.printing import CPrinter


@pytest.fixture
def printings(monkeypatch: pytest.MonkeyPatch) -> list[Equations]:
    """Equations whose outputs are printed from here on, with no source known before."""
    module._print.cache_clear()
    made: list[Equations] = []
    plain = module._plain

    def noted(e: Equations) -> str:
        made.append(e)
        return plain(e)

    monkeypatch.setattr(module, "_plain", noted)
    yield made
    module._print.cache_clear()


def test_other_values_of_the_same_formulas_have_the_same_source(printings: list[Equations]) -> None:
    first = joint_equations(4)
    other = first.with_parameters({"inertia": {"initial": 3.21e-4}})
    one, two = generate(first), generate(other)
    assert one.source == two.source
    assert one.digest == two.digest
    assert two.equations.parameter("inertia").initial == 3.21e-4
    assert len(printings) == 1


def test_other_formulas_steps_and_sensitivities_have_another_source(printings: list[Equations]) -> None:
    first = joint_equations(4)
    stiffer = replace(first, rhs=(first.rhs[0], 2 * first.rhs[1], *first.rhs[2:]))
    swapped = replace(first, parameters=(*first.parameters[1:], first.parameters[0]))
    sources = {generate(e).source for e in (first, stiffer, swapped)} | {generate(first, tangent=False).source}
    assert len(sources) == 4
    assert len(printings) == 4
    assert generate(first, step=1e-3).digest != generate(first).digest


def test_constants_are_numbers():
    x = sp.Symbol("x", real=True)
    text = CPrinter({}).doprint(sp.log(2) * x + sp.pi + sp.exp(sp.Rational(1, 2)))
    assert "M_" not in text
    assert "hk_log" not in text  # functions take lanes
    assert text == f"x*{math.log(2)!r} + {math.exp(0.5)!r} + {math.pi!r}"
