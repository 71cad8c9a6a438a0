"""The posterior of one joint: what sampling, scoring and prediction gave, as one frozen value."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.measurement.values.run import Array
from haptid.uq.density.laplace import Laplace
from haptid.uq.prediction.choice import Scored
from haptid.uq.prediction.next_run import NextRun
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.arviz_door import LeaveOneOut
from haptid.uq.result.summary import ParameterSummary
from haptid.uq.sampling.sampling import Sample


@dataclass(frozen=True, slots=True, kw_only=True)
class Posterior:
    """The posterior of one joint.

    Parameters
    ----------
    joint
        The free joint.
    candidates, chosen
        Noise models with their held-out scores, and the one that was sampled.
    mode
        Normal approximation under the chosen model.
    sample
        Chains.
    parameters
        One summary per coordinate.
    draws
        Thinned draws of η, shape (n_chains, n_draws, n), to which ``cycle_log_density`` and ``run_log_density`` belong.
    cycle_log_density, run_log_density
        Log density of every cycle given the others of its run (n_chains, n_draws, n_cycles), and of every run
        (n_chains, n_draws, n_runs).
    bands
        Predictive bands of the fitted and the unseen runs.
    modes
        How many separate groups the ensembles form.
    """

    joint: int
    candidates: tuple[Scored, ...]
    chosen: Scored
    mode: Laplace
    sample: Sample
    parameters: tuple[ParameterSummary, ...]
    draws: Array
    cycle_log_density: Array
    run_log_density: Array
    loo: LeaveOneOut
    bands: tuple[Bands, ...]
    modes: int
    next_run: NextRun | None
    sensitivity: dict[str, dict[str, tuple[float, float]]]
    wall_s: float
    notes: tuple[str, ...] = ()

    @property
    def worst_rhat(self) -> float:
        """Largest R̂."""
        return max(p.diagnostics.rhat for p in self.parameters)

    @property
    def sound(self) -> bool:
        """Whether the ensembles agree and their autocorrelation time is known."""
        return self.sample.reached and self.worst_rhat < 1.01 and self.modes == 1
