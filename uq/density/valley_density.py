"""Density in which the walkers move: the density of η and `Valleys` in, log density of z out.

Ensemble moves propose points on straight lines through walkers, which leave a curved ridge; in z the ridge is straight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.valleys import Valleys
from haptid.measurement.values.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class ValleyDensity:
    """Log density of z: the log density of η plus ln |∂η/∂z|.

    Parameters
    ----------
    density
        Log density of η (n_sets, n), shape (n_sets,).
    valleys
        Map from η to z.
    """

    density: Callable[[Array], Array]
    valleys: Valleys

    def __call__(self, z: Array) -> Array:
        """Compute the log density of z.

        Parameters
        ----------
        z
            Coordinates, shape (n_sets, n), or (n,) for one set.

        Returns
        -------
        ndarray, shape (n_sets,)
            ln p(η(z)) + ln |∂η/∂z|; −inf where no η belongs to z.
        """
        z = np.atleast_2d(z)
        eta = self.valleys.back(z)
        sound = np.isfinite(eta).all(axis=1)
        out = np.full(len(z), -np.inf)
        if sound.any():
            out[sound] = self.density(eta[sound]) + self.valleys.log_volume(z[sound])
        return out
