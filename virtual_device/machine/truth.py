"""The numbers of the virtual arm, as they stand in ``truth.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.machine.friction import LAWS, law_parameters

LINK = ("mass", "x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz")
"""Columns of `Truth.links`: mass [kg], centroid [m], inertia tensor about the centroid in link axes [kg m²]."""
DRIVE = ("Kp", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""Columns of `Truth.drives`."""
GEOMETRY = ("upper", "forearm", "crank", "handle", "gravity")
"""Entries of `Truth.geometry`: lengths [m] and gravity [m/s²]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """Numbers of the arm.

    Parameters
    ----------
    geometry
        Lengths [m] and gravity [m/s²] in the order of `GEOMETRY`, shape (5,).
    links
        Inertial parameters of each link in the order of `LINK`, shape (7, 10).
    drives
        Parameters of each joint in the order of `DRIVE`, SI units, shape (6, 9).
    friction
        Law of each joint that does not have the first of `friction.LAWS`. A law takes its own parameters from
        ``drives`` and leaves the others.
    """

    geometry: Array
    links: Array
    drives: Array
    friction: Mapping[int, str] = field(default_factory=dict)

    def law_parameters(self, joint: int) -> dict[str, float]:
        """Return the parameters `friction.OF_LAWS` of a joint.

        Parameters
        ----------
        joint
            Number of the joint.

        Returns
        -------
        dict of str to float
            Number of the law, attraction C [N m/s], spread, unevenness and exponent n, by name.

        Raises
        ------
        InputError
            Where there is no such law.
        """
        return law_parameters(self.friction.get(joint, LAWS[0]), float(self.drives[joint, DRIVE.index("Fc")]))

    def packed(self) -> Array:
        """Lay all numbers out in the order of the C structure.

        Returns
        -------
        ndarray, shape (159,)
            Geometry, links row by row, then drive and law of each joint.

        Raises
        ------
        InputError
            Where a law of ``friction`` is unknown.
        """
        laws = [list(self.law_parameters(joint).values()) for joint in range(len(self.drives))]
        return np.concatenate([self.geometry, self.links.ravel(), np.hstack([self.drives, laws]).ravel()])


def read_truth(path: Path | None = None) -> Truth:
    """Read the numbers of an arm.

    Parameters
    ----------
    path
        File as ``truth.toml``; None for the device that made the embedded campaign.

    Returns
    -------
    Truth
        Geometry, links and drives; every joint has the first friction law.

    Raises
    ------
    KeyError
        Where a number is missing.
    tomllib.TOMLDecodeError
        Where the file is no TOML.
    """
    data = tomllib.loads((path or Path(__file__).with_name("truth.toml")).read_text())
    links = [[row[key] for key in LINK] for row in data["link"]]
    drives = [[row[key] for key in DRIVE] for row in data["joint"]]
    geometry = [data["geometry"][key] for key in GEOMETRY]
    return Truth(geometry=np.array(geometry), links=np.array(links), drives=np.array(drives))


def inertia_tensor(row: Array) -> Array:
    """Return the inertia of a link about its centroid.

    Parameters
    ----------
    row
        Row of `Truth.links`, shape (10,).

    Returns
    -------
    Array
        Inertia tensor in link axes [kg m²], shape (3, 3).
    """
    xx, yy, zz, xy, xz, yz = row[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
