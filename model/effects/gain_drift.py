"""A gain that drifts through a run."""

import sympy as sp

from model.effect import Effect, parameter, t, w
from model.scales import DURATION

r = sp.Symbol("gain_drift_rate", real=True)

EFFECT = Effect(
    id="gain_drift",
    title="motor gain that drifts during a run",
    formula="w = τ·(1 + r·t)",
    lives_in="time",
    place=1,
    side="input",
    parameters=(parameter("gain_drift_rate", "1/s", "relative drift of the gain", 0.02, -0.7, 3.0),),
    relative={"gain_drift_rate": 1 / DURATION},
    rivals=("viscous_drift", "coulomb_drift"),
    input=w * (1 + r * t),
)
