"""Candidate noise models of a likelihood: held-out runs decide between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from haptid.noise import hyper
from haptid.noise.hyper import Hyper
from haptid.noise.thresholds import THRESHOLDS

Scatter = Literal["none", "reading", "torque"]
_WORDS = {
    "none": "white sensor noise",
    "reading": "white sensor noise and an amplitude of the reading that differs from cycle to cycle",
    "torque": "white sensor noise and a torque amplitude that differs from cycle to cycle",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """The random parts of the data beside white sensor noise.

    Parameters
    ----------
    scatter
        ``none``: no scatter. ``reading``: each cycle's deviation from equilibrium is multiplied by 1 + s·ξ.
        ``torque``: each cycle's torque is multiplied by 1 + s·ξ.
    runs
        Whether a deviation s_run·ξ common to all cycles of a run is added to the factor.
    correlated
        Whether the data hold a model error of covariance a²·exp(−|Δt|/T).
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

    def hyper(self, *, noise_width: float, travel: float, unit: str = "rad") -> tuple[Hyper, ...]:
        """List the parameters of this noise model with their priors.

        Parameters
        ----------
        noise_width
            Standard deviation of ln(noise factor) in its prior [1].
        travel
            Largest travel of the runs, or range of their torques, in ``unit``.
        unit
            Unit of the readings.

        Returns
        -------
        tuple of Hyper
            Noise factor, then the scatters and the model error where the model has them.
        """
        parts = [hyper.noise_factor(noise_width)]
        parts += [hyper.cycle_scatter()] if self.scatter != "none" else []
        parts += [hyper.run_scatter()] if self.runs else []
        parts += hyper.model_error(travel, unit) if self.correlated else ()
        return tuple(parts)


def candidates(runs: int, cycles: int) -> tuple[NoiseModel, ...]:
    """List the noise models to compare.

    Parameters
    ----------
    runs, cycles
        Number of fitted runs, and of their cycles together. With fewer cycles (runs) than
        `THRESHOLDS.least_samples_of_scatter` no candidate has a scatter from cycle to cycle (from run to run).

    Returns
    -------
    tuple of NoiseModel
        The simplest first: without scatter, with each scatter, with each scatter from run to run too, and with a
        correlated model error.
    """
    models = [NoiseModel()]
    cycles_scatter = cycles >= THRESHOLDS.least_samples_of_scatter
    runs_scatter = runs >= THRESHOLDS.least_samples_of_scatter
    if cycles_scatter:
        models += [NoiseModel(scatter="reading"), NoiseModel(scatter="torque")]
    if cycles_scatter and runs_scatter:
        models += [NoiseModel(scatter="reading", runs=True), NoiseModel(scatter="torque", runs=True)]
    return (
        *models,
        NoiseModel(correlated=True),
        *([NoiseModel(scatter="reading", correlated=True)] if cycles_scatter else []),
    )
