"""Which random parts a likelihood holds: the choice that held-out data decide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from haptid.noise import hyper
from haptid.noise.hyper import Hyper

Scatter = Literal["none", "reading", "torque"]
_WORDS = {
    "none": "white sensor noise",
    "reading": "white sensor noise and an amplitude of the reading that differs from cycle to cycle",
    "torque": "white sensor noise and a torque amplitude that differs from cycle to cycle",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """The random parts of the data.

    Parameters
    ----------
    scatter
        ``reading``: each cycle's deviation from equilibrium times 1 + s·ξ. ``torque``: each cycle's torque times it.
    runs
        Whether a factor 1 + s_run·ξ common to all cycles of a run comes on top.
    correlated
        Whether an autocorrelated model error a·exp(−|Δt|/T) is part of the data.
    """

    scatter: Scatter = "none"
    runs: bool = False
    correlated: bool = False

    @property
    def id(self) -> str:
        """Short name, as in ``reading+runs+correlated``."""
        return "+".join([self.scatter, *(["runs"] if self.runs else []), *(["correlated"] if self.correlated else [])])

    @property
    def words(self) -> str:
        """The model as a report says it."""
        extra = [", and from run to run"] if self.runs else []
        extra += [", with a correlated model error on top"] if self.correlated else []
        return _WORDS[self.scatter] + "".join(extra)

    def hyper(self, *, noise_width: float, travel: float) -> tuple[Hyper, ...]:
        """Parameters of this model, for a travel [rad] and the width of the noise factor's prior."""
        parts = [hyper.noise_factor(noise_width)]
        parts += [hyper.cycle_scatter()] if self.scatter != "none" else []
        parts += [hyper.run_scatter()] if self.runs else []
        parts += hyper.model_error(travel) if self.correlated else ()
        return tuple(parts)


def candidates(runs: int, cycles: int) -> tuple[NoiseModel, ...]:
    """Noise models worth comparing on this many fitted runs and cycles, the simplest first."""
    models = [NoiseModel()]
    if cycles >= 3:
        models += [NoiseModel(scatter="reading"), NoiseModel(scatter="torque")]
    if cycles >= 3 and runs >= 3:
        models += [NoiseModel(scatter="reading", runs=True), NoiseModel(scatter="torque", runs=True)]
    return (
        *models,
        NoiseModel(correlated=True),
        *([NoiseModel(scatter="reading", correlated=True)] if cycles >= 3 else []),
    )
