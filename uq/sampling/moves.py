"""Proposals: emcee's own, and independent draws from a Student distribution around the ensembles' mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import emcee
import numpy as np

from haptid.measurement.values.run import Array

DEGREES = 10.0
MOVES = ("stretch", "differential", "independent")


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """Student's t with ``DEGREES`` degrees of freedom around ``mean`` (n,) with scale matrix ``lower``·``lower``ᵀ."""

    mean: Array
    lower: Array

    @classmethod
    def of(cls, mean: Array, covariance: Array) -> Proposal:
        """Make a proposal of this covariance's shape; a singular covariance is lifted by 1e-9 of its diagonal."""
        lifted = covariance + np.diag(1e-9 * np.diag(covariance) + 1e-300)
        return cls(mean=mean, lower=np.asarray(np.linalg.cholesky(lifted), dtype=np.float64))

    def log_density(self, x: Array) -> Array:
        """Log density of points (n_sets, n), up to a constant."""
        z = np.linalg.solve(self.lower, (x - self.mean).T)
        return np.asarray(-0.5 * (DEGREES + self.mean.size) * np.log1p(np.sum(z**2, axis=0) / DEGREES))

    def draw(self, random: Any, size: int) -> Array:
        """Draw points (size, n) from a numpy random state."""
        normal = random.randn(size, self.mean.size)
        scale = np.sqrt(random.chisquare(DEGREES, size) / DEGREES)
        return np.asarray(self.mean + (normal / scale[:, None]) @ self.lower.T)

    def __call__(self, coords: Array, random: Any) -> tuple[Array, Array]:
        """Propose independently of where the walkers are; see `emcee.moves.MHMove`."""
        new = self.draw(random, coords.shape[0])
        return new, self.log_density(coords) - self.log_density(new)


Weighted = list[tuple[Any, float]]


def moves(name: str, proposal: Proposal) -> Weighted:
    """Return the weighted moves of one of ``MOVES``.

    ``stretch`` (Goodman and Weare 2010, §2); ``differential`` (ter Braak 2006, with the snooker of ter Braak and Vrugt
    2008 in one step of five); ``independent``: in seven steps of ten all walkers at once propose draws of ``proposal``.
    """
    builders: dict[str, Callable[[], Weighted]] = {
        "stretch": lambda: [(emcee.moves.StretchMove(), 1.0)],
        "differential": lambda: [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)],
        "independent": lambda: [
            (emcee.moves.MHMove(proposal), 0.7),
            (emcee.moves.DEMove(), 0.22),
            (emcee.moves.DESnookerMove(), 0.08),
        ],
    }
    return builders[name]()
