"""Valley of a spring, made straight: `Parametrisation` in, `Valleys` out, for steps of fits and walkers of the sampler.

Data fix the spring's torque at q = 0, o = Ks·epos, far better than Ks and epos apart, and gravity shares it: a run
knows the stiffness Ks + g_s and the torque o − g_c at q = 0. In Ks and epos that valley is a curve, in Ks and o a
straight line. It is the posterior's ridge as well as the valley of the cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.measurement.values.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """Places of Ks and epos among the coordinates, and their scales: p = centre + unit·s, or Ks = exp s.

    Parameters
    ----------
    stiffness, position
        Indices of Ks and epos among the coordinates.
    log
        Whether Ks moves in its logarithm.
    stiffness_centre, stiffness_unit
        Centre and unit of Ks [N m/rad].
    position_centre, position_unit
        Centre and unit of epos [rad].
    """

    stiffness: int
    position: int
    log: bool
    stiffness_centre: float
    stiffness_unit: float
    position_centre: float
    position_unit: float

    def physical(self, s: Array) -> tuple[Array, Array]:
        """Return stiffness and rest position of the spring.

        Parameters
        ----------
        s
            Coordinates, shape (…, n).

        Returns
        -------
        Ks : ndarray, shape (…,)
            Stiffness [N m/rad].
        epos : ndarray, shape (…,)
            Rest position [rad].
        """
        moved = s[..., self.stiffness]
        Ks = np.exp(moved) if self.log else self.stiffness_centre + self.stiffness_unit * moved
        return Ks, self.position_centre + self.position_unit * s[..., self.position]


@dataclass(frozen=True, slots=True, kw_only=True)
class Valleys:
    """Map from coordinates s to z: the places of Ks and epos hold Ks and o = Ks·epos, the others stay as they are.

    Parameters
    ----------
    springs
        Springs whose stiffness and rest position are both free; z = s where there is none.
    """

    springs: tuple[Spring, ...] = ()

    @classmethod
    def of(cls, parametrisation: Parametrisation) -> Valleys:
        """Find the springs (``Ks…`` with ``epos…``) of which both parameters are free and epos is not a logarithm.

        Parameters
        ----------
        parametrisation
            Free parameters; coordinates of anything else may follow theirs.

        Returns
        -------
        Valleys
        """
        place = {id: k for k, id in enumerate(parametrisation.ids)}
        springs = []
        for id, k in place.items():
            e = place.get("epos" + id.removeprefix("Ks"))
            if id.startswith("Ks") and e is not None and not parametrisation.log[e]:
                spring = Spring(
                    stiffness=k,
                    position=e,
                    log=parametrisation.log[k],
                    stiffness_centre=float(parametrisation.centre[k]),
                    stiffness_unit=float(parametrisation.unit[k]),
                    position_centre=float(parametrisation.centre[e]),
                    position_unit=float(parametrisation.unit[e]),
                )
                springs.append(spring)
        return cls(springs=tuple(springs))

    def forward(self, s: Array) -> Array:
        """Map coordinates to z.

        Parameters
        ----------
        s
            Coordinates, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            Ks [N m/rad] and o [N m] at the places of Ks and epos, the others as in ``s``.
        """
        z = s.copy()
        for spring in self.springs:
            Ks, epos = spring.physical(s)
            z[..., spring.stiffness], z[..., spring.position] = Ks, Ks * epos
        return z

    def back(self, z: Array) -> Array:
        """Map z to coordinates, the inverse of `forward`.

        Parameters
        ----------
        z
            Ks and o at the places of Ks and epos, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            NaN at these places where Ks ≤ 0.
        """
        s = z.copy()
        for spring in self.springs:
            Ks = np.where(z[..., spring.stiffness] > 0, z[..., spring.stiffness], np.nan)
            linear = (Ks - spring.stiffness_centre) / spring.stiffness_unit
            s[..., spring.stiffness] = np.log(Ks) if spring.log else linear
            s[..., spring.position] = (z[..., spring.position] / Ks - spring.position_centre) / spring.position_unit
        return s

    def jacobian(self, s: Array) -> Array:
        """Differentiate `forward`.

        Parameters
        ----------
        s
            Coordinates, shape (n,).

        Returns
        -------
        ndarray, shape (n, n)
            ∂z/∂s.
        """
        J = np.eye(s.size)
        for spring in self.springs:
            Ks, epos = spring.physical(s)
            slope = Ks if spring.log else spring.stiffness_unit
            J[spring.stiffness, spring.stiffness] = slope
            J[spring.position, spring.stiffness] = epos * slope
            J[spring.position, spring.position] = Ks * spring.position_unit
        return J

    def log_volume(self, z: Array) -> Array:
        """Return ln |∂s/∂z|.

        Parameters
        ----------
        z
            Ks and o at the places of Ks and epos, shape (…, n).

        Returns
        -------
        ndarray, shape (…,)
            NaN where Ks ≤ 0.
        """
        volume = np.zeros(z.shape[:-1])
        for spring in self.springs:
            Ks = np.where(z[..., spring.stiffness] > 0, z[..., spring.stiffness], np.nan)
            slope = Ks if spring.log else spring.stiffness_unit
            volume = volume - np.log(slope) - np.log(Ks * spring.position_unit)
        return volume
