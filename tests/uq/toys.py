"""A normal density behind the same seam as a joint's posterior; importable by worker processes."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from haptid.uq.density.laplace import Laplace

MEAN = np.array([1.0, -2.0, 0.5])
COVARIANCE = np.array([[1.0, 0.9, 0.0], [0.9, 1.0, 0.03], [0.0, 0.03, 0.04]])


@dataclass(frozen=True)
class Normal:
    terms: tuple = ()
    equations: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(digest="toy", name="toy"))
    coordinates: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            names=("a", "b", "c"), parametrisation=SimpleNamespace(ids=("a", "b", "c"), log=(False,) * 3)
        )
    )

    def __call__(self, eta):
        z = np.atleast_2d(eta) - MEAN
        return -0.5 * np.einsum("wi,ij,wj->w", z, np.linalg.inv(COVARIANCE), z)


def start(scale: float = 1.0) -> Laplace:
    """A start that is off: twice as wide as the truth and shifted."""
    return Laplace(eta=MEAN + 0.3, covariance=scale * 4.0 * COVARIANCE, density=Normal(), log_density=0.0)


@dataclass(frozen=True)
class Corner:
    """Twelve independent exponential distributions: the mode is where the ends of all ranges meet."""

    terms: tuple = ()
    equations: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(digest="corner", name="corner"))
    coordinates: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            names=tuple("abcdefghijkl"),
            parametrisation=SimpleNamespace(ids=tuple("abcdefghijkl"), log=(False,) * 12),
        )
    )

    def __call__(self, eta):
        eta = np.atleast_2d(eta)
        return np.where((eta >= 0).all(axis=1), -eta.sum(axis=1), -np.inf)


def start_in_corner() -> Laplace:
    return Laplace(eta=np.full(12, 1e-9), covariance=np.eye(12), density=Corner(), log_density=0.0)
