"""Coordinates x in which the ridge between spring and gravity is a straight line: η and its density in, x out.

The walkers move in x: ensemble moves propose points on straight lines through walkers, which leave a curved ridge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array

IDS = ("Ks", "epos", "gravity_sin", "gravity_cos")
"""Parameters that the map changes: stiffness, rest position of the spring, and the two gravity torques g_s and g_c."""
STIFF = 0.05
"""Smallest total stiffness K at the mode, as a share of Ks + |g_s|, at which the map is used: the map needs K > 0."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Straight:
    """Map from η to x: (log Ks, epos, g_s, g_c) become (log K, q₀, g_s/K, g_c/K), the other coordinates stay.

    K = Ks + g_s is the stiffness at q = 0 and q₀ = (Ks·epos − g_c)/K the equilibrium, both to first order in q. A run
    determines K and q₀ far better than how spring and gravity share them. So the posterior is a ridge at nearly
    constant K and q₀: a curve in η, a straight line in x. A factor common to all torques moves log K alone.

    Parameters
    ----------
    places
        Indices of `IDS` in η; empty where the joint has not all four free: then x = η.
    """

    places: tuple[int, ...] = ()

    @classmethod
    def of(cls, names: Sequence[str], logarithmic: Sequence[bool], eta: Array) -> Straight:
        """Return the map for a posterior, x = η where the map cannot be used.

        Parameters
        ----------
        names, logarithmic
            Ids of the coordinates, and whether each is a logarithm.
        eta
            Mode, shape (n,).
        """
        if not set(IDS) <= set(names):
            return cls()
        spring, epos, sine, cosine = places = tuple(list(names).index(name) for name in IDS)
        Ks, g_s = np.exp(eta[spring]), eta[sine]
        usable = logarithmic[spring] and not any(logarithmic[i] for i in (epos, sine, cosine))
        return cls(places=places) if usable and Ks + g_s > STIFF * (Ks + abs(g_s)) else cls()

    def straight(self, eta: Array) -> Array:
        """Map η to x.

        Parameters
        ----------
        eta
            Coordinates of the density, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            log K, q₀, g_s/K and g_c/K at `places`; NaN where K ≤ 0.
        """
        if not self.places:
            return eta
        out = eta.copy()
        log_spring, epos, g_s, g_c = (eta[..., i] for i in self.places)
        Ks = np.exp(log_spring)
        with np.errstate(invalid="ignore", divide="ignore"):
            K = np.where(Ks + g_s > 0, Ks + g_s, np.nan)
            for i, value in zip(self.places, (np.log(K), (Ks * epos - g_c) / K, g_s / K, g_c / K), strict=True):
                out[..., i] = value
        return out

    def back(self, x: Array) -> Array:
        """Map x to η, the inverse of `straight`.

        Parameters
        ----------
        x
            Coordinates of the walkers, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            NaN where Ks = K·(1 − g_s/K) ≤ 0.
        """
        if not self.places:
            return x
        out = x.copy()
        log_k, q0, sine, cosine = (x[..., i] for i in self.places)
        K = np.exp(log_k)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(sine < 1, 1 - sine, np.nan)
            parts = (log_k + np.log(share), (q0 + cosine) / share, K * sine, K * cosine)
            for i, value in zip(self.places, parts, strict=True):
                out[..., i] = value
        return out

    def log_volume(self, x: Array) -> Array:
        """Return log |∂η/∂x| = 2·log K − 2·log(1 − g_s/K) of x (…, n), shape (…,)."""
        if not self.places:
            return np.zeros(x.shape[:-1])
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(2 * x[..., self.places[0]] - 2 * np.log(1 - x[..., self.places[2]]))

    def covariance(self, eta: Array, covariance: Array) -> Array:
        """Propagate a covariance of η to x to first order.

        Parameters
        ----------
        eta
            Point at which the map is linearised, shape (n,).
        covariance
            Covariance C of η, shape (n, n).

        Returns
        -------
        ndarray, shape (n, n)
            J·C·Jᵀ with J = ∂x/∂η by central differences of a thousandth of each standard deviation.
        """
        if not self.places:
            return covariance
        h = 1e-3 * np.sqrt(np.diag(covariance))
        J = (self.straight(eta + np.diag(h)) - self.straight(eta - np.diag(h))).T / (2 * h)
        return np.asarray(J @ covariance @ J.T)


@dataclass(frozen=True, slots=True, kw_only=True)
class StraightDensity:
    """Log density of x: the log density of η plus log |∂η/∂x|.

    Parameters
    ----------
    density
        Log density of η (n_sets, n), shape (n_sets,).
    straight
        Map between η and x.
    """

    density: Callable[[Array], Array]
    straight: Straight

    def __call__(self, x: Array) -> Array:
        """Return the log density of x (n_sets, n) or (n,), shape (n_sets,); −inf where no η belongs to x."""
        x = np.atleast_2d(x)
        eta = self.straight.back(x)
        sound = np.isfinite(eta).all(axis=1)
        out = np.full(len(x), -np.inf)
        if sound.any():
            out[sound] = self.density(eta[sound]) + self.straight.log_volume(x[sound])
        return out
