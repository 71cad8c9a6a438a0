"""A normal density behind the same seam as a joint's posterior; importable by worker processes."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from haptid.uq.density.laplace import Laplace

MEAN = np.array([1.0, -2.0, 0.5])
COVARIANCE = np.array([[1.0, 0.9, 0.0], [0.9, 1.0, 0.03], [0.0, 0.03, 0.04]])


@dataclass(frozen=True)
class Toy:
    names: str
    terms: tuple = ()

    @property
    def equations(self):
        return SimpleNamespace(digest=f"toy of {self.names}", name="toy")

    @property
    def coordinates(self):
        ids = tuple(self.names)
        return SimpleNamespace(names=ids, parametrisation=SimpleNamespace(ids=ids, log=(False,) * len(ids)))


class Normal(Toy):
    def __call__(self, eta):
        z = np.atleast_2d(eta) - MEAN
        return -0.5 * np.einsum("wi,ij,wj->w", z, np.linalg.inv(COVARIANCE), z)


def start(scale: float = 1.0) -> Laplace:
    """A start that is off: twice as wide as the truth and shifted."""
    return Laplace(eta=MEAN + 0.3, covariance=scale * 4.0 * COVARIANCE, density=Normal("abc"), log_density=0.0)


class Corner(Toy):
    """Independent exponential distributions: the mode is where the ends of all ranges meet."""

    def __call__(self, eta):
        eta = np.atleast_2d(eta)
        return np.where((eta >= 0).all(axis=1), -eta.sum(axis=1), -np.inf)


def start_in_corner() -> Laplace:
    return Laplace(eta=np.full(12, 1e-9), covariance=np.eye(12), density=Corner("abcdefghijkl"), log_density=0.0)
