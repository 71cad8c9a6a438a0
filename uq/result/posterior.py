"""The posterior of one joint as one frozen value: chains, summaries, scores and predictions."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.measurement.values.run import Array
from haptid.uq.density.laplace import Laplace
from haptid.uq.prediction.choice import Scored
from haptid.uq.prediction.next_run import NextRun
from haptid.uq.prediction.predict import Bands
from haptid.uq.result.arviz_door import LeaveOneOut
from haptid.uq.result.sampler_state import Chains


@dataclass(frozen=True, slots=True, kw_only=True)
class Posterior(Chains):
    """The posterior of one joint.

    Chains and their summaries are fields of `Chains`.

    Parameters
    ----------
    joint
        Number of the free joint.
    candidates, chosen
        Noise models with their held-out scores, and the chosen noise model, under which the chains were sampled.
    mode
        Normal approximation under the chosen noise model.
    draws
        Thinned draws of η, shape (n_chains, n_draws, n), to which ``cycle_log_density`` and ``run_log_density`` belong.
    cycle_log_density, run_log_density
        Log density of every cycle given the others of its run (n_chains, n_draws, n_cycles), and of every run
        (n_chains, n_draws, n_runs).
    loo
        PSIS-LOO over cycles.
    bands
        Predictive bands of the fitted and the held-out runs.
    next_run
        Proposed run, None where there is none.
    sensitivity
        Mean and standard deviation by coordinate, with priors of half, stated and double width; empty where not asked.
    wall_s
        Duration of the inference [s].
    shortened
        What bounded the chains, as a sentence without its end; empty where nothing did.
    notes
        Sentences for the reader of the report.
    doubts
        Those of them that say why the intervals are not to be used yet, whatever the chains are worth: the model does
        not fit, or the fit contradicts them.
    """

    joint: int
    candidates: tuple[Scored, ...]
    chosen: Scored
    mode: Laplace
    draws: Array
    cycle_log_density: Array
    run_log_density: Array
    loo: LeaveOneOut
    bands: tuple[Bands, ...]
    next_run: NextRun | None
    sensitivity: dict[str, dict[str, tuple[float, float]]]
    wall_s: float
    shortened: str = ""
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """Unit of what is compared: of the position, or of the torque where a position controller made the runs."""
        return self.mode.density.equations.outputs[0].unit

    @property
    def residual(self) -> str:
        """What is compared, ``position`` or ``torque``."""
        return "position" if self.mode.density.equations.joints else "torque"
