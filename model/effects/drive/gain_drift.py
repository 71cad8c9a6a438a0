"""A gain that drifts through a run, and its contender, a gain that settles while its cause warms up."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, reference, t, w
from haptid.model.effects.scales import DURATION

r, T = sp.symbols("gain_drift_rate gain_settling_time", real=True)
RATE = parameter("gain_drift_rate", "1/s", "relative drift of the gain at the start", 0.02, -0.7, 3.0)

SETTLING = Effect(
    id="gain_settling",
    title="motor gain that settles within a run",
    formula="w = τ·(1 + r·T·(1 − exp(−t/T))), T a third of the run",
    lives_in="time",
    place=1,
    side="input",
    parameters=(RATE, reference("gain_settling_time", "s", "time constant T")),
    relative={"gain_drift_rate": 1 / DURATION, "gain_settling_time": DURATION / 3},
    input=w * (1 + r * T * (1 - sp.exp(-t / T))),
)
"""Contender outside the catalogue: it stands for every gain that does not drift by a constant rate."""

EFFECT = Effect(
    id="gain_drift",
    title="motor gain that drifts during a run",
    formula="w = τ·(1 + r·t)",
    lives_in="time",
    place=1,
    side="input",
    parameters=(RATE.but(description="relative drift of the gain"),),
    relative={"gain_drift_rate": 1 / DURATION},
    rivals=("viscous_drift", "coulomb_drift"),
    contenders=(SETTLING,),
    input=w * (1 + r * t),
)
