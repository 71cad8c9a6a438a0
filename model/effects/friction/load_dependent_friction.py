"""Dry friction that grows with the torque in the transmission."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, reference, w
from haptid.model.effects.scales import TORQUE

a1, w0 = sp.symbols("load_friction load_reference", real=True)

EFFECT = Effect(
    id="load_dependent_friction",
    title="dry friction that grows with the load",
    formula="Fc, Fs times (1 + a·|w|/w₀)",
    lives_in="torque",
    side="friction",
    parameters=(
        parameter("load_friction", "1", "relative growth of dry friction at the largest torque", 0.02, -0.7, 5.0),
        reference("load_reference", "N m", "largest torque w₀"),
    ),
    relative={"load_reference": TORQUE},
    rivals=("position_dependent_friction",),
    coulomb_level=1 + a1 * sp.Abs(w) / w0,
)
