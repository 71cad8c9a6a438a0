"""Amplitudes that differ from cycle to cycle at random."""

from haptid.model.effects.effect import Effect, parameter

EFFECT = Effect(
    id="amplitude_scatter",
    title="amplitude that scatters from cycle to cycle",
    formula="each cycle's amplitude times (1 + s·ξ), ξ standard normal",
    lives_in="cycle",
    side="random",
    parameters=(parameter("amplitude_scatter", "1", "relative scatter s of the amplitude", 0.01, 0.0, 0.5),),
    rivals=("gain_drift",),
)
