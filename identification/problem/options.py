"""Choices of a fit: `FitOptions`, which the command, the posterior and the search for missing effects hand on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from haptid.identification.thresholds import THRESHOLDS

Method = Literal["slsqp", "gauss_newton"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """How a fit is done; the defaults are those of the command.

    Parameters
    ----------
    method
        ``slsqp`` (with a final Gauss–Newton polish) or ``gauss_newton`` throughout.
    starts
        Largest number of starts; fewer run once ``agree`` of them share the best minimum at the noise.
    gains
        Observer gains L [1/s] of the homotopy in their order, the last of them 0.
    seed, workers
        Seed of the starts; number of processes that share them. The result does not depend on that number.
    weights
        Time weights of the first and the second half of a run.
    start
        First start θ, shape (n_p,); the first guesses where None.
    states
        Initial states of the runs from which a start descends, (n_x,) by file; those of the readings where a file is
        missing, or has another number of states.
    priors
        Whether the parameters' priors enter the cost.
    robust
        Whether the pseudo-Huber loss replaces the square.
    free_velocity
        Whether the initial velocities are fitted too (they always are where a run starts in motion).
    agree
        Number of starts that must share the best minimum at the noise before no further start runs.
    tolerance
        RMS of the residual over the noise up to which the residual counts as noise.
    passive
        Whether passivity is demanded where the friction law has a constraint for it (LuGre: σ2 ≥ σ1·(Fs − Fc)/Fc).
    profile
        Whether profile likelihoods are followed to the ends of their 95 % intervals.
    quiet
        Whether the command shows no progress bar; the fit does not depend on it.
    """

    method: Method = "slsqp"
    starts: int = 8
    gains: tuple[float, ...] = (60.0, 20.0, 6.0, 2.0, 0.0)
    seed: int = 0
    workers: int = 1
    weights: tuple[float, float] = THRESHOLDS.weights_of_run_halves
    start: tuple[float, ...] | None = None
    states: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    priors: bool = True
    robust: bool = False
    free_velocity: bool = False
    agree: int = 2
    tolerance: float = 1.05
    passive: bool = False
    profile: bool = False
    quiet: bool = True

    def but(self, **changes: Any) -> FitOptions:
        """Return a copy with some options replaced.

        Parameters
        ----------
        changes
            New values by the option's name.

        Returns
        -------
        FitOptions
        """
        return FitOptions(**{**{name: getattr(self, name) for name in self.__slots__}, **changes})
