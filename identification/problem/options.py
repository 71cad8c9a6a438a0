"""Choices of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from haptid.identification.problem.weights import PAPER

Method = Literal["slsqp", "gauss_newton"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """How a fit is done; the defaults are those of the command.

    Parameters
    ----------
    method
        ``slsqp`` (with a final Gauss–Newton polish) or ``gauss_newton`` throughout.
    starts
        Most starts; fewer are made once ``agree`` of them share the best minimum at the noise.
    gains
        Observer gains L [1/s] that are gone through, the last of them 0.
    seed, workers
        Seed of the starts; processes that share them. The result does not depend on the number of processes.
    weights
        Time weights of the first and the second half of a run.
    start
        First start θ (n_p,); the first guesses where None.
    priors
        Whether the parameters' priors count.
    robust
        Whether the pseudo-Huber loss replaces the square.
    free_velocity
        Whether the initial velocities are fitted too (they always are where a run starts in motion).
    agree
        How many starts must share the best minimum before the rest are left out.
    tolerance
        RMS over noise up to which a residual counts as noise.
    passive
        Whether passivity is demanded where the friction law has a constraint for it (LuGre: σ2 ≥ σ1·(Fs − Fc)/Fc).
    profile
        Whether profile likelihoods are followed to the ends of their 95 % intervals.
    """

    method: Method = "slsqp"
    starts: int = 8
    gains: tuple[float, ...] = (60.0, 20.0, 6.0, 2.0, 0.0)
    seed: int = 0
    workers: int = 1
    weights: tuple[float, float] = PAPER
    start: tuple[float, ...] | None = None
    priors: bool = True
    robust: bool = False
    free_velocity: bool = False
    agree: int = 2
    tolerance: float = 1.05
    passive: bool = False
    profile: bool = False
    quiet: bool = True

    def but(self, **changes: Any) -> FitOptions:
        """Return a copy with ``changes``."""
        return FitOptions(**{**{name: getattr(self, name) for name in self.__slots__}, **changes})
