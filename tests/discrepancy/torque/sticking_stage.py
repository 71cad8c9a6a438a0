"""A stage with dry friction that sticks, under a PID controller: the truth of tests, by formulas of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

MASS, COULOMB, STICTION, VISCOUS = 5.0, 8.0, 12.0, 20.0
"""Truth [kg, N, N, N s/m]; nothing else acts on the stage."""
STRIBECK_SPEED = 1e-3
STEP_S = 1e-4
ROWS_S = 1e-3


def steps(seed: int, hold_s: float = 0.5) -> Callable[[float], float]:
    """Return a reference that steps to another position every ``hold_s``, and rests between."""
    levels = np.random.default_rng(seed).uniform(-0.02, 0.02, 40)
    return lambda t: float(levels[int(t / hold_s)])


def slow_waves(seed: int) -> Callable[[float], float]:
    """Return a reference so slow that the stage sticks and slips."""
    return lambda t: 0.02 * np.sin(0.6 * t + seed) + 0.01 * np.sin(1.7 * t + 2.0 * seed)


def fast_waves(seed: int) -> Callable[[float], float]:
    """Return a reference that turns round without a rest."""
    return lambda t: 0.02 * np.sin(6.0 * t + seed) + 0.005 * np.sin(17.0 * t + 2.0 * seed)


def recorded_stage(
    reference: Callable[[float], float],
    seed: int,
    duration_s: float,
    *,
    stribeck_speed: float = STRIBECK_SPEED,
    **gains: float,
) -> pd.DataFrame:
    """Simulate and record a run; ``gains`` are those of the controller, P [N/m], I [N/(m s)] and D [N s/m]."""
    rng, every = np.random.default_rng(seed), round(ROWS_S / STEP_S)
    q = seen = reference(0.0)
    v = force = integral = 0.0
    rows = []
    for k in range(round(duration_s / STEP_S)):
        t = k * STEP_S
        if k % every == 0:
            reading = q + 1e-6 * rng.standard_normal()
            speed, seen = (reading - seen) / ROWS_S, reading
            integral += gains["I"] * (reference(t) - reading) * ROWS_S
            force = gains["P"] * (reference(t) - reading) - gains["D"] * speed + integral
            rows.append((t, force + 0.05 * rng.standard_normal(), reading, reference(t)))
        driving = force - VISCOUS * v
        if v == 0.0 and abs(driving) <= STICTION:
            continue
        level = COULOMB + (STICTION - COULOMB) * np.exp(-((v / stribeck_speed) ** 2))
        moved, most = v + STEP_S / MASS * driving, level * STEP_S / MASS
        v = 0.0 if abs(moved) <= most else moved - np.sign(moved) * most
        q += STEP_S * v
    return pd.DataFrame(rows, columns=["time_s", "force_0_N", "position_0_m", "reference_0_m"])
