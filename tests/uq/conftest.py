"""Fixtures of the small joint."""

import pytest

from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from tests.uq.uq_cases import make_equations, make_run


@pytest.fixture(scope="session")
def equations() -> Equations:
    return make_equations()


@pytest.fixture(scope="session")
def runs(equations: Equations) -> tuple[Run, ...]:
    return tuple(make_run(equations, omega=w, seed=i, s=0.01) for i, w in enumerate((2.0, 3.0, 4.5)))
