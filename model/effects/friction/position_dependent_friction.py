"""Dry friction that changes with position: in waves, with their harmonics too, or steadily."""

from functools import partial

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q
from haptid.model.effects.parts.waves import COARSE, WHOLE, series, series_amplitudes, wave, wave_number
from haptid.model.effects.scales import CENTRE, POSITION
from haptid.model.thresholds import THRESHOLDS

HARMONICS = 3
FAMILY = series_amplitudes(
    "friction_wave", "1", "relative wave of dry friction", 0.02, THRESHOLDS.largest_friction_harmonic, HARMONICS
)  # fmt: skip
slope = sp.Symbol("friction_slope", real=True)
_effect = partial(
    Effect,
    id="position_dependent_friction",
    title="dry friction that changes with position",
    lives_in="position",
    side="friction",
    rivals=("cogging", "load_dependent_friction"),
)

EFFECTS = (
    _effect(
        variant="wave",
        formula="Fc, Fs times (1 + a_s·sin(n·q) + a_c·cos(n·q))",
        parameters=(
            parameter("friction_wave_sin", "1", "relative wave of dry friction, sine part", 0.02, -0.7, 0.7),
            parameter("friction_wave_cos", "1", "relative wave of dry friction, cosine part", 0.02, -0.7, 0.7),
            wave_number("friction_wave_number", COARSE),
        ),
        amplitudes=2,
        relative={"friction_wave_number": 1 / POSITION},
        shapes=(("friction_wave_number", COARSE),),
        coulomb_level=1 + wave("friction_wave"),
    ),
    _effect(
        variant="harmonics",
        formula="Fc, Fs times (1 + Σ a_s,h·sin(h·n·q) + a_c,h·cos(h·n·q)), h = 1 … 3",
        parameters=(*FAMILY, wave_number("friction_wave_number", WHOLE)),
        amplitudes=len(FAMILY),
        relative={"friction_wave_number": 1 / POSITION},
        shapes=(("friction_wave_number", WHOLE),),
        coulomb_level=1 + series("friction_wave", HARMONICS),
        series_of="position_dependent_friction:wave",
    ),
    _effect(
        variant="slope",
        formula="Fc, Fs times (1 + a·q)",
        parameters=(parameter("friction_slope", "1/rad", "relative slope of dry friction", 0.02, -0.95, 0.95),),
        relative={"friction_slope": 1 / (POSITION + sp.Abs(CENTRE))},
        coulomb_level=1 + slope * q,
    ),
)
