"""Inertia that changes with position, with the Christoffel term that goes with it."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.scales import POSITION

LEAST = sp.Rational(1, 20)
"""Share of the inertia that is left at least: no inertia is negative."""
c1, c2 = sp.symbols("inertia_slope inertia_curvature", real=True)

EFFECT = Effect(
    id="configuration_inertia",
    title="inertia that changes with position",
    formula="M·m(q)·q̈ + ½·M·m'(q)·q̇², m = 1 + c1·q + c2·q²",
    lives_in="position",
    side="torque",
    parameters=(
        parameter("inertia_slope", "1/rad", "relative slope of the inertia at q = 0", 0.02, -1.5, 1.5),
        parameter("inertia_curvature", "1/rad^2", "relative curvature of the inertia", 0.02, -0.7, 4.0),
    ),
    amplitudes=2,
    relative={"inertia_slope": 1 / POSITION, "inertia_curvature": 1 / POSITION**2},
    rivals=("cubic_spring", "asymmetric_spring"),
    inertia_factor=sp.Max(1 + c1 * q + c2 * q**2, LEAST),
)
