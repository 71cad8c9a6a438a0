"""The density in which the walkers move: the same posterior, and nothing where a spring would push."""

import numpy as np
import pytest

from haptid.identification.problem.valleys import Valleys
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.valley_density import ValleyDensity
from tests.uq.uq_cases import make_equations


def test_density_carries_the_volume_and_ends_where_the_spring_would_push():
    coordinates = Coordinates.of(make_equations(), hyper=())
    valleys = Valleys.of(coordinates.parametrisation)
    density = ValleyDensity(density=lambda eta: np.zeros(len(eta)), valleys=valleys)
    eta = coordinates.eta(np.array([q.initial for q in coordinates.equations.parameters]))
    z = np.tile(valleys.forward(eta), (2, 1))
    z[1, coordinates.names.index("Ks")] = -0.01
    values = density(z)
    assert values[0] == pytest.approx(-2 * eta[coordinates.names.index("Ks")])
    assert values[1] == -np.inf
